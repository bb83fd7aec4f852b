/* Files that quiltrender writes are whole or not there, however it ends. */
#include "tests/daemon/quiltrender.h"

#include <signal.h>
#include <sys/stat.h>
#include <time.h>

/* Until the process catches SIGTERM: it has read its arguments. */
static void await_handler(pid_t pid)
{
    char path[64];
    char text[4096];
    snprintf(path, sizeof path, "/proc/%d/status", (int)pid);
    for (int i = 0; i < 3000; i++, qr_nap(0.01)) {
        FILE *file = fopen(path, "re");
        assert_non_null(file);
        size_t n = fread(text, 1, sizeof text - 1, file);
        fclose(file);
        text[n] = '\0';
        const char *caught = strstr(text, "SigCgt:");
        if (caught && (strtoull(caught + 7, NULL, 16) >> (SIGTERM - 1) & 1))
            return;
    }
    fail_msg("quiltrender never catches SIGTERM");
}

static void a_terminated_job_leaves_nothing_and_exits_1(void **state)
{
    const qr_files *f = *state;
    static const char *const outs[] = {"k.exr", "k/"};
    static const int signals[] = {SIGTERM, SIGINT};
    for (int i = 0; i < 2; i++) {
        char line[4 * PATH_MAX];
        char text[4096];
        int before = qr_count_files(f->folder);
        int err = memfd_create("stderr", 0);
        int out = memfd_create("stdout", 0);
        snprintf(line, sizeof line, "%s -o %s/%s --view-size 240x320 --spp 100000 --threads 2",
                 f->scene, f->folder, outs[i]);
        pid_t pid = qr_start(line, out, err, RLIM_INFINITY);
        await_handler(pid);
        qr_nap(0.2);
        kill(pid, signals[i]);
        assert_int_equal(qr_ended(pid), 1);
        qr_read_back(err, text, sizeof text);
        close(out);
        assert_non_null(strstr(text, "interrupted"));
        assert_int_equal(qr_count_files(f->folder), before);
    }
}

static void a_killed_job_leaves_no_broken_file(void **state)
{
    const qr_files *f = *state;
    char folder[PATH_MAX];
    char line[4 * PATH_MAX];
    int null = open("/dev/null", O_RDWR);
    lf_quilt_file expected = {0};
    lf_error err = {0};
    int whole = 0;
    snprintf(folder, sizeof folder, "%s/kill", f->folder);
    assert_int_equal(mkdir(folder, 0777), 0);
    lf_assert_ok(lf_quilt_read(f->large, NULL, 0, 0, &expected, &err), &err);
    for (int i = 0; i < 20; i++) {
        snprintf(line, sizeof line, "%s -o %s/k_qs3x2a1.5.png", f->large, folder);
        pid_t pid = qr_start(line, null, null, RLIM_INFINITY);
        qr_nap(0.008 * i); /* from before main to after the end */
        kill(pid, SIGKILL);
        qr_ended(pid);
        if (!qr_exists(folder, "k_qs3x2a1.5.png"))
            continue;
        lf_quilt_file got = {0};
        lf_assert_ok(lf_quilt_read(lf_test_path(folder, "k_qs3x2a1.5.png"), NULL, 0, 0, &got, &err),
                     &err);
        for (int view = 0; view < VIEWS; view++)
            for (int y = 0; y < 160; y++)
                assert_memory_equal(lf_views8_row(&got.views8, view, y),
                                    lf_views8_row(&expected.views8, view, y), 240 * 3);
        lf_quilt_finish(&got);
        whole++;
        if (i % 2)
            unlink(lf_test_path(folder, "k_qs3x2a1.5.png"));
    }
    print_message("%d of 20 killed runs had finished\n", whole);
    qr_succeed("%s", line);
    assert_int_equal(qr_count_files(folder), 1); /* what killed runs left behind is gone */
    lf_quilt_finish(&expected);
    close(null);
}

static void a_full_disk_is_an_error_and_leaves_nothing(void **state)
{
    const qr_files *f = *state;
    static const char *const outs[] = {"d_qs3x2a1.5.exr", "d_qs3x2a1.5.png", "d.jpg", "d/",
                                       "d.tif --print 60@600 --print-size 40x40"};
    for (size_t i = 0; i < sizeof outs / sizeof outs[0]; i++) {
        char line[4 * PATH_MAX];
        qr_outcome o;
        int before = qr_count_files(f->folder);
        snprintf(line, sizeof line, "%s -o %s/%s", f->large, f->folder, outs[i]);
        qr_run_limited(&o, line, 16384);
        qr_assert_fails(&o, 1, "File too large");
        assert_int_equal(qr_count_files(f->folder), before);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_terminated_job_leaves_nothing_and_exits_1),
        cmocka_unit_test(a_killed_job_leaves_no_broken_file),
        cmocka_unit_test(a_full_disk_is_an_error_and_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
