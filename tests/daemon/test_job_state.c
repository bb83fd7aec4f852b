/* --state: a job that was stopped goes on to the bytes of one that was not; files that are another
 * job's, or damaged, are refused in one line and stay as they are. */
#include "tests/daemon/quiltrender.h"
#include "tests/scene_file.h"

#include <math.h>
#include <signal.h>
#include <time.h>

#include "daemon/tools/job_state.h"
#include "daemon/tools/rendering.h"

#define SIZE "--view-size 24x32 --threads 2"

/* Starts a job, stops it after a while and returns its exit code. */
static int run_and_stop(const char *line, double seconds, int number, char *said, size_t size)
{
    int err = memfd_create("stderr", 0), out = memfd_create("stdout", 0);
    pid_t pid = qr_start(line, out, err, RLIM_INFINITY);
    qr_nap(seconds);
    kill(pid, number);
    const int code = qr_ended(pid);
    qr_read_back(err, said, size);
    close(out);
    return code;
}

static json_t *info_of(const char *path)
{
    qr_outcome o;
    qr_run(&o, "--state-info %s", path);
    assert_int_equal(o.code, 0);
    json_t *info = json_loads(o.out, 0, NULL);
    assert_non_null(info);
    return info;
}

static json_int_t passes_of(const char *path, bool complete)
{
    json_t *info = info_of(path);
    const json_int_t passes = json_integer_value(json_object_get(info, "passes"));
    assert_int_equal(json_is_true(json_object_get(info, "complete")), complete);
    json_decref(info);
    return passes;
}

/* Again and again, each time for longer, until it is done. */
static void a_stopped_job_goes_on_to_the_same_bytes(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], said[8192];
    int code = 75, stops = 0;
    qr_succeed("%s -o %s/whole.exr --spp 150 " SIZE, f->scene, f->folder);
    for (int i = 0; code == 75 && i < 100; i++) {
        snprintf(line, sizeof line, "%s -o %s/parts.exr --spp 150 --state %s/p.lfstate " SIZE,
                 f->scene, f->folder, f->folder);
        code = run_and_stop(line, 0.15 * (i + 1), i % 2 ? SIGINT : SIGTERM, said, sizeof said);
        stops += code == 75;
        /* before it catches signals, or in the end */
        if (code == 1000 + SIGTERM || code == 1000 + SIGINT)
            code = 75;
    }
    print_message("stopped %d times\n", stops);
    assert_int_equal(code, 0);
    qr_assert_same_files(lf_test_path(f->folder, "whole_qs3x2a0.75.exr"),
                         lf_test_path(f->folder, "parts_qs3x2a0.75.exr"));
    assert_int_equal(passes_of(lf_test_path(f->folder, "p.lfstate"), true), 150 * VIEWS);
}

/* What is longer than anybody waits, so that it is stopped for sure. */
static void a_stopped_job_says_75_and_keeps_its_work(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], path[PATH_MAX], said[8192];
    json_int_t passes = 0;
    snprintf(path, sizeof path, "%s", lf_test_path(f->folder, "long.lfstate"));
    snprintf(line, sizeof line, "%s -o %s/long.png --spp 10000000 --state %s " SIZE, f->scene,
             f->folder, path);
    for (int i = 0; i < 2; i++) {
        for (double seconds = 0.5; access(path, F_OK) != 0 || passes_of(path, false) <= passes;
             seconds *= 2) {
            const int code = run_and_stop(line, seconds, SIGTERM, said, sizeof said);
            assert_true(code == 75 || code == 1000 + SIGTERM);
        }
        assert_non_null(strstr(said, "interrupted: "));
        assert_non_null(strstr(said, "run the same command to continue"));
        const bool goes_on = strstr(said, "continuing at ");
        assert_int_equal(goes_on, i);
        passes = passes_of(path, false);
    }
    assert_false(qr_exists(f->folder, "long_qs3x2a0.75.png"));
}

static void a_larger_job_goes_on_and_a_complete_one_is_done_at_once(void **state)
{
    const qr_files *f = *state;
    static const char *const kinds[] = {"w.png", "w.png --reconstruct on",
                                        "w.tif --print 60@600 --print-size 6x8 --views 6",
                                        "w.png --still"};
    static const char *const names[] = {"w_qs3x2a0.75.png", "w_qs3x2a0.75.png", "w.tif", "w.png"};
    for (int i = 0; i < 4; i++) {
        const char *size = i == 2 ? "" : SIZE;
        char path[PATH_MAX], out[PATH_MAX], whole[PATH_MAX];
        snprintf(out, sizeof out, "%s", lf_test_path(f->folder, names[i]));
        snprintf(whole, sizeof whole, "%s", lf_test_path(f->folder, "kept"));
        snprintf(path, sizeof path, "%s/%d.lfstate", f->folder, i);
        qr_succeed("%s -o %s/%s --spp 4 %s", f->scene, f->folder, kinds[i], size);
        assert_int_equal(rename(out, whole), 0);
        qr_succeed("%s -o %s/%s --spp 2 --state %s %s", f->scene, f->folder, kinds[i], path, size);
        qr_assert_different_files(out, whole);
        for (int again = 0; again < 2; again++) {
            qr_outcome o;
            unlink(out);
            qr_run(&o, "%s -o %s/%s --spp 4 --state %s %s", f->scene, f->folder, kinds[i], path,
                   size);
            assert_int_equal(o.code, 0);
            assert_non_null(
                strstr(o.err, again ? "the image is complete (4 spp)" : "continuing at 2 spp"));
            qr_assert_same_files(out, whole);
        }
        unlink(out);
    }
}

static void a_foreign_file_is_refused_and_named(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *options, *words;
    } cases[] = {
        {"--spp 2 --seed 7", "differs in the seed (0, not 7); remove it"},
        {"--spp 2 --views 5", "differs in the number of views (6, not 5)"},
        {"--spp 2 --view-size 24x31", "the views' height (32, not 31)"},
        {"--spp 2 --integrator vpt", "the integrator (\"mvpt\", not \"vpt\")"},
        {"--spp 2 --max-depth 2", "the render settings"},
        {"--spp 1", "holds 2 spp, but this job asks for 1"},
    };
    char path[PATH_MAX], kept[PATH_MAX], other[PATH_MAX];
    qr_outcome o;
    snprintf(path, sizeof path, "%s", lf_test_path(f->folder, "mine.lfstate"));
    snprintf(kept, sizeof kept, "%s", lf_test_path(f->folder, "mine.copy"));
    qr_succeed("%s -o %s/m.png --spp 2 --state %s --reconstruct off " SIZE, f->scene, f->folder,
               path);
    qr_succeed("%s -o %s/m.png --spp 2 --state %s --reconstruct off " SIZE, f->scene, f->folder,
               kept);
    char *bytes = NULL;
    size_t n = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &bytes, &n, &err), &err);
    int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        qr_run(&o, "%s -o %s/no.png --state %s --reconstruct off " SIZE " %s", f->scene, f->folder,
               path, cases[i].options);
        qr_assert_fails(&o, 1, cases[i].words);
    }
    qr_run(&o, "%s -o %s/no.png --state %s --reconstruct off --spp 2 --fit=fog " SIZE, f->scene,
           f->folder, path); /* a warning of its depth comes first */
    assert_int_equal(o.code, 1);
    assert_non_null(strstr(o.err, "differs in the camera"));
    qr_run(&o, "%s -o %s/no.png --state %s --reconstruct on --spp 2 " SIZE, f->scene, f->folder,
           path);
    qr_assert_fails(&o, 1, "--denoise (false, not true)");
    assert_int_equal(qr_count_files(f->folder), before);
    snprintf(other, sizeof other, "%s",
             lf_test_write(f->folder, "other.json",
                           "{\"camera\": {\"position\": [0,0,6], \"views\": 6, \"aspect\": 0.75}, "
                           "\"lights\": {\"sky\": {\"type\": \"environment\", \"radiance\": 1}}}"));
    qr_run(&o, "%s -o %s/no.png --state %s --spp 2 --reconstruct off " SIZE, other, f->folder,
           path);
    qr_assert_fails(&o, 1, "differs in the scene, the camera");
    qr_run(&o, "%s -o %s/no.png --state %s --spp 2 " SIZE, f->scene, f->folder, other);
    qr_assert_fails(&o, 1, "is not the state of a job");
    qr_succeed("%s -o %s/m.png --passes 13 --reconstruct off --state %s/odd.lfstate " SIZE,
               f->scene, f->folder, f->folder);
    qr_run(&o, "%s -o %s/no.png --spp 4 --reconstruct off --state %s/odd.lfstate " SIZE, f->scene,
           f->folder, f->folder);
    qr_assert_fails(&o, 1, "holds passes of another job");
    qr_run(&o, "%s -o %s/no.png --state %s/n.lfstate --spp 2 --integrator amvpt " SIZE, f->scene,
           f->folder, f->folder);
    qr_assert_fails(&o, 2, "--state: is not supported with this --integrator");
    char *after = NULL;
    size_t m = 0;
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &after, &m, &err), &err);
    assert_int_equal(m, n);
    assert_memory_equal(after, bytes, n);
    lf_free(after);
    lf_free(bytes);
}

/* ------------------------------------------------------------------------------------ damage -- */

typedef struct tiny {
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    json_t *of;
} tiny;

static void open_tiny(tiny *t)
{
    lf_error err = {0};
    json_t *doc = lf_test_scene_document("fog-over-clay");
    const lf_budget budget = {.passes = 4};
    const lf_job_place place = {.last_row = 2, .frame = -1, .camera_row = -1, .shutter_part = -1};
    lf_assert_ok(lf_scene_from_json(doc, ".", "fog", NULL, NULL, &t->scene, &err), &err);
    json_decref(doc);
    lf_render_settings settings = {.camera = *lf_scene_camera(t->scene), .width = 3, .height = 3};
    settings.camera.n_views = 2;
    lf_assert_ok(lf_pool_create(1, &t->pool), NULL);
    lf_assert_ok(lf_renderer_create(t->scene, &settings, t->pool, &t->renderer, &err), &err);
    t->of = lf_job_state_of("fog", t->renderer, &budget, &place);
    assert_non_null(t->of);
}

static void close_tiny(tiny *t)
{
    json_decref(t->of);
    lf_renderer_destroy(t->renderer);
    lf_pool_destroy(t->pool);
    lf_scene_unref(t->scene);
}

static void write_bytes(const char *path, const char *data, size_t n)
{
    FILE *file = fopen(path, "we");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

/* Refused with a remedy, and whoever asks what is in it is told or refused, too. */
static void assert_damaged(const tiny *t, const char *path)
{
    lf_job_progress progress = {0};
    lf_error err = {0};
    json_t *info = NULL;
    const lf_status status = lf_job_state_restore(path, t->of, t->renderer, &progress, &err);
    if (status != LF_E_FORMAT && status != LF_E_STATE)
        fail_msg("status %d", status);
    assert_string_equal(err.where, path);
    assert_non_null(strstr(err.what, "pass another --state FILE"));
    if (lf_job_state_info(path, &info, &err) == LF_OK)
        json_decref(info);
}

static void every_byte_that_was_changed_is_noticed(void **state)
{
    const qr_files *f = *state;
    tiny t;
    lf_error err = {0};
    lf_job_progress progress = {.times = {.passes = 4, .seconds = 1, .cpu_seconds = 2},
                                .complete = true};
    char path[PATH_MAX], *bytes = NULL;
    size_t n = 0;
    open_tiny(&t);
    snprintf(path, sizeof path, "%s", lf_test_path(f->folder, "tiny.lfstate"));
    lf_assert_ok(lf_renderer_passes(t.renderer, NULL, 4, false, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_job_state_write(path, t.of, t.renderer, &progress, &err), &err);
    lf_assert_ok(lf_file_read(path, NULL, 1 << 20, &bytes, &n, &err), &err);
    for (size_t i = 0; i < n; i += i < 600 ? 1 : 13) {
        bytes[i] = (char)(bytes[i] ^ (1 << (i % 8)));
        write_bytes(path, bytes, n);
        assert_damaged(&t, path);
        bytes[i] = (char)(bytes[i] ^ (1 << (i % 8)));
    }
    for (size_t shorter = 0; shorter < n; shorter += shorter < 600 ? 7 : 101) {
        write_bytes(path, bytes, shorter);
        assert_damaged(&t, path);
    }
    write_bytes(path, bytes, n);
    memset(&progress, 0, sizeof progress);
    lf_assert_ok(lf_job_state_restore(path, t.of, t.renderer, &progress, &err), &err);
    assert_true(progress.complete);
    assert_int_equal(progress.times.passes, 4);
    lf_assert_close(progress.times.seconds, 1, 0, 0);
    lf_assert_close(progress.times.cpu_seconds, 2, 0, 0);
    lf_free(bytes);
    close_tiny(&t);
}

/* ------------------------------------------------------------------------------ now and then -- */

static int n_written;

lf_status __real_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err);
lf_status __wrap_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err);
lf_status __wrap_lf_job_state_write(const char *path, const json_t *of, const lf_renderer *renderer,
                                    const lf_job_progress *progress, lf_error *err)
{
    n_written++;
    return __real_lf_job_state_write(path, of, renderer, progress, err);
}

/* A job that saves whenever it may, in this process. */
static void saving_now_and_then_changes_no_bit(void **state)
{
    const qr_files *f = *state;
    char line[4 * PATH_MAX], *argv[16];
    int argc = 0;
    snprintf(line, sizeof line,
             "quiltrender %s -o %s/often.exr --view-size 6x8 --spp 5 --threads 1 --state "
             "%s/often.lfstate",
             f->scene, f->folder, f->folder);
    for (char *word = strtok(line, " "); word && argc < 15; word = strtok(NULL, " "))
        argv[argc++] = word;
    argv[argc] = NULL;
    lf_render_arguments a;
    lf_cancel cancel = 0, paused = 0;
    bool done = false;
    lf_error err = {0};
    qr_succeed("%s -o %s/once.exr --spp 5 --view-size 6x8", f->scene, f->folder);
    lf_assert_ok(lf_render_arguments_parse(argc, argv, &a, &done, &err), &err);
    lf_rendering r = {.arguments = &a, .cancel = &cancel, .pause = &paused};
    n_written = 0;
    lf_assert_ok(lf_rendering_open(&r, &err), &err);
    lf_assert_ok(lf_rendering_run(&r, &err), &err);
    lf_assert_ok(lf_rendering_write(&r, &err), &err);
    lf_rendering_finish(&r);
    assert_true(n_written > 8);
    qr_assert_same_files(lf_test_path(f->folder, "often_qs3x2a0.75.exr"),
                         lf_test_path(f->folder, "once_qs3x2a0.75.exr"));
}

static void a_state_that_cannot_be_saved_is_an_error(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char line[4 * PATH_MAX];
    int before = qr_count_files(f->folder);
    snprintf(line, sizeof line, "%s -o %s/full.png --spp 1 --state %s/full.lfstate " SIZE, f->scene,
             f->folder, f->folder);
    qr_run_limited(&o, line, 4096);
    qr_assert_fails(&o, 1, "File too large");
    qr_run(&o, "%s -o %s/x.png --spp 1 --state %s/none/s " SIZE, f->scene, f->folder, f->folder);
    qr_assert_fails(&o, 1, "cannot write to the folder");
    qr_run(&o, "--state-info %s/none", f->folder);
    qr_assert_fails(&o, 1, "none");
    assert_int_equal(qr_count_files(f->folder), before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stopped_job_goes_on_to_the_same_bytes),
        cmocka_unit_test(a_stopped_job_says_75_and_keeps_its_work),
        cmocka_unit_test(a_larger_job_goes_on_and_a_complete_one_is_done_at_once),
        cmocka_unit_test(a_foreign_file_is_refused_and_named),
        cmocka_unit_test(every_byte_that_was_changed_is_noticed),
        cmocka_unit_test(saving_now_and_then_changes_no_bit),
        cmocka_unit_test(a_state_that_cannot_be_saved_is_an_error),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
