/* What a picture to share is called, and what a job says of what it wrote. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>
#include <stdlib.h>

#include "base/image_io.h"
#include "daemon/tools/progress_line.h"

#define SIZE "--view-size 24x32 --spp 1"

static void assert_wrote(const qr_files *f, const char *name, const char *words, const char *fmt,
                         ...) LF_PRINTF(4, 5);
/* Runs quiltrender: exit 0, the file is there, and its line is "wrote FOLDER/NAME" and WORDS. */
static void assert_wrote(const qr_files *f, const char *name, const char *words, const char *fmt,
                         ...)
{
    char line[4 * PATH_MAX], expected[2 * PATH_MAX];
    qr_outcome o;
    va_list args;
    va_start(args, fmt);
    vsnprintf(line, sizeof line, fmt, args);
    va_end(args);
    qr_run(&o, "%s", line);
    snprintf(expected, sizeof expected, "%s/%s%s", f->folder, name, words);
    if (o.code != 0 || !strstr(o.err, "quiltrender: wrote ") || !strstr(o.err, expected))
        fail_msg("%s: exit %d with %s, expected %s", line, o.code, o.err, expected);
    if (!qr_exists(f->folder, name))
        fail_msg("%s is not there", name);
}

static void one_view_keeps_its_name(void **state)
{
    const qr_files *f = *state;
    assert_wrote(f, "a.png", " (24x32 pixels, 1 spp, ", "%s -o %s/a.png --views 1 " SIZE, f->scene,
                 f->folder);
    assert_wrote(f, "b.png", " (24x32 pixels, 1 spp, ", "%s -o %s/b.png --still " SIZE, f->scene,
                 f->folder);
    qr_assert_same_files(lf_test_path(f->folder, "a.png"), lf_test_path(f->folder, "b.png"));
    assert_wrote(f, "a.exr", " (24x32 pixels, ", "%s -o %s/a.exr --views 1 " SIZE, f->scene,
                 f->folder);
    assert_wrote(f, "a_qs1x1a0.75.png", " (24x32 ", "%s -o %s/a.png --views 1 --quilt 1x1 " SIZE,
                 f->scene, f->folder);
    assert_wrote(f, "a_0002.png", " (24x32 ",
                 "%s -o %s/a.png --views 1 --turntable 2 --overwrite " SIZE, f->scene, f->folder);
    assert_wrote(f, "large.jpg", " (810x1080 pixels, ",
                 "%s -o %s/large.jpg --still --passes 1 --overwrite", f->scene, f->folder);
    assert_wrote(f, "go.png", " (24x32 ", "%s -o %s/go.png --still --preset go " SIZE, f->scene,
                 f->folder);
}

static void assert_near(const char *a, const char *b, double most)
{
    lf_image8 x = {0}, y = {0};
    lf_error err = {0};
    double sum = 0;
    lf_assert_ok(lf_image8_read(a, NULL, &x, &err), &err);
    lf_assert_ok(lf_image8_read(b, NULL, &y, &err), &err);
    assert_int_equal(x.width, y.width);
    assert_int_equal(x.height, y.height);
    const size_t n = (size_t)x.width * (size_t)x.height * 3;
    for (size_t i = 0; i < n; i++)
        sum += abs(x.data[i] - y.data[i]);
    assert_true(sum / (double)n < most);
    lf_image8_finish(&x);
    lf_image8_finish(&y);
}

static void a_quilt_gives_its_middle_view_and_itself_as_jpeg(void **state)
{
    const qr_files *f = *state;
    char view[PATH_MAX], quilt[PATH_MAX], jpeg[PATH_MAX], still[PATH_MAX];
    assert_wrote(f, "views/", " (6 views of 24x32, ", "%s -o %s/views/ --png " SIZE, f->scene,
                 f->folder);
    qr_succeed("%s -o %s/q.png " SIZE, f->scene, f->folder);
    snprintf(quilt, sizeof quilt, "%s", lf_test_path(f->folder, "q_qs3x2a0.75.png"));
    snprintf(view, sizeof view, "%s", lf_test_path(f->folder, "views/view_003.png"));
    snprintf(still, sizeof still, "%s", lf_test_path(f->folder, "m.png"));
    snprintf(jpeg, sizeof jpeg, "%s", lf_test_path(f->folder, "j_qs3x2a0.75.jpeg"));
    assert_wrote(f, "m.png", " (24x32 pixels, ", "%s -o %s/m.png --still", quilt, f->folder);
    assert_near(still, view, 1e-9);
    assert_wrote(f, "n.png", " (24x32 pixels, ", "%s -o %s/n.png --views 1", quilt, f->folder);
    qr_assert_same_files(still, lf_test_path(f->folder, "n.png"));
    assert_wrote(f, "m.jpg", " (24x32 pixels, ", "%s -o %s/m.jpg --still", quilt, f->folder);
    assert_near(lf_test_path(f->folder, "m.jpg"), view, 3);
    assert_wrote(f, "j_qs3x2a0.75.jpeg", " (6 views of 24x32, ", "%s -o %s/j.jpeg --quality 97",
                 quilt, f->folder);
    assert_near(jpeg, quilt, 2);
    /* which is a quilt again */
    qr_succeed("%s -o %s/back.png --still", jpeg, f->folder);
    assert_near(lf_test_path(f->folder, "back.png"), view, 2);
}

static void statistics_go_to_standard_output(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s -o %s/s.png --stats - " SIZE, f->scene, f->folder);
    assert_int_equal(o.code, 0);
    json_t *stats = json_loads(o.out, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(stats, "views")), VIEWS);
    json_decref(stats);
    assert_true(access("-", F_OK) != 0);
}

/* What is logged of so many lines. */
static int count_logged(double interval, int lines)
{
    char text[4096];
    int n = 0, fd = memfd_create("stderr", 0), old = dup(STDERR_FILENO);
    lf_progress_line line = {.logs = true, .program = "x", .interval = interval};
    assert_true(fd >= 0 && old >= 0);
    dup2(fd, STDERR_FILENO);
    for (int i = 0; i < lines; i++)
        lf_progress_line_draw(&line, "rendering  50 %");
    lf_progress_line_clear(&line);
    dup2(old, STDERR_FILENO);
    close(old);
    qr_read_back(fd, text, sizeof text);
    for (const char *at = text; (at = strstr(at, "rendering  50 %\n")); at++)
        n++;
    assert_null(strchr(text, '\r'));
    return n;
}

static void a_log_has_a_line_now_and_then(void **state)
{
    (void)state;
    assert_int_equal(count_logged(0, 3), 3);
    assert_int_equal(count_logged(1e9, 3), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_view_keeps_its_name),
        cmocka_unit_test(a_quilt_gives_its_middle_view_and_itself_as_jpeg),
        cmocka_unit_test(statistics_go_to_standard_output),
        cmocka_unit_test(a_log_has_a_line_now_and_then),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
