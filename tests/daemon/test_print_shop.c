/* The files that a shop gets from quiltrender, and the memory that writing them takes. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>
#include <sys/stat.h>

/* Runs quiltrender; its largest resident memory in MB. */
static double memory_of(const char *line)
{
    const int null = open("/dev/null", O_RDWR);
    struct rusage used;
    int status = 0;
    const pid_t pid = qr_start(line, null, null, RLIM_INFINITY);
    close(null);
    assert_int_equal(wait4(pid, &status, 0, &used), pid);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    return (double)used.ru_maxrss / 1000;
}

/* Megabytes. Address sanitizers keep what was released for a while. */
#if defined(__SANITIZE_ADDRESS__)
#define MOST_GROWTH INFINITY
#else
#define MOST_GROWTH 15
#endif

/* 4 MB of raster, and 40. */
static void memory_does_not_grow_with_the_print(void **state)
{
    static const char *const ways[] = {"x.tif", "x.tif --compress lzw", "x.pdf",
                                       "x.tif --orientation horizontal", "x.tif --slant 9"};
    const qr_files *f = *state;
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        double memory[2];
        char line[4 * PATH_MAX];
        for (int tall = 0; tall < 2; tall++) {
            snprintf(line, sizeof line, "%s -o %s/%s --print 60@600 --print-size 40x%d --threads 2",
                     f->quilt, f->folder, ways[i], tall ? 600 : 60);
            memory[tall] = memory_of(line);
        }
        if (memory[1] - memory[0] > MOST_GROWTH)
            fail_msg("%s: %.0f MB, then %.0f MB", ways[i], memory[0], memory[1]);
    }
}

/* make verify: 2 x 1 m at 600 dpi. */
static void a_banner_of_photos_takes_500_mb(void **state)
{
    const qr_files *f = *state;
    enum { PHOTO_WIDTH = 4000, PHOTO_HEIGHT = 2000 };
    const size_t row = 3 * (size_t)PHOTO_WIDTH;
    char line[4 * PATH_MAX];
    lf_error err;
    if (!lf_test_long()) {
        print_message("only with QUILTD_LONG\n");
        skip();
    }
    uint8_t *data = lf_calloc(PHOTO_HEIGHT, row);
    assert_non_null(data);
    assert_int_equal(mkdir(lf_test_path(f->folder, "photos"), 0777), 0);
    for (int i = 0; i < 8; i++) {
        lf_outfile file;
        const lf_views8 views = {1, PHOTO_WIDTH, PHOTO_HEIGHT, row * PHOTO_HEIGHT, row, data};
        const lf_layout one = {1, 1, 1, PHOTO_WIDTH, PHOTO_HEIGHT, 2};
        char name[32];
        for (size_t at = 0; at < row * PHOTO_HEIGHT; at++)
            data[at] = (uint8_t)(at / row / 8 + at % row / 48 + 20 * (size_t)i);
        snprintf(name, sizeof name, "photos/%d.png", i);
        lf_assert_ok(lf_outfile_open(&file, lf_test_path(f->folder, name), true, &err), &err);
        lf_assert_ok(lf_quilt_write_png(&file, &views, &one, NULL, 0, &err), &err);
        lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    }
    lf_free(data);
    snprintf(line, sizeof line,
             "%s/photos/ -o %s/banner.tif --print 60.13@600 --print-size 2000x1000 --views 8",
             f->folder, f->folder);
    const double memory = memory_of(line);
    print_message("a banner of 8 photos: %.0f MB\n", memory);
    assert_true(memory < 500);
    struct stat banner;
    assert_int_equal(stat(lf_test_path(f->folder, "banner.tif"), &banner), 0);
    assert_true(banner.st_size > INT64_C(47244) * 23622 * 3);
    unlink(lf_test_path(f->folder, "banner.tif"));
}

static json_t *manifest_of(const qr_files *f, const char *name)
{
    json_t *manifest = json_load_file(lf_test_path(f->folder, name), 0, NULL);
    assert_non_null(manifest);
    return manifest;
}

static void a_print_is_a_pdf_by_its_name(void **state)
{
    const qr_files *f = *state;
    char head[9] = "";
    qr_succeed("%s -o %s/job.pdf --print 60@600 --print-size 20x10 --views 4", f->quilt, f->folder);
    FILE *file = fopen(lf_test_path(f->folder, "job.pdf"), "rb");
    assert_non_null(file);
    assert_int_equal(fread(head, 1, 8, file), 8);
    fclose(file);
    assert_string_equal(head, "%PDF-1.6");
    json_t *manifest = manifest_of(f, "job.json");
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(manifest, "file"), "name")), "job.pdf");
    json_decref(manifest);
    qr_succeed("-o %s/chart.pdf --chart 60+-0.5/0.1@600 --print-size 60x60", f->folder);
    assert_true(qr_exists(f->folder, "chart.json"));
}

static void a_relief_lies_beside_its_print(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o,
           "%s -o %s/lens.tif --print 60@600 --print-size 20x10 --views 4 --relief --radius 0.3 "
           "--thickness 0.5 --distance 400",
           f->quilt, f->folder);
    assert_int_equal(o.code, 0);
    /* f = 0.3 1.56 / 0.56 */
    assert_non_null(strstr(o.err, "relief: lenses of radius 0.3 mm focus at 0.8357 mm, but the "
                                  "print lies at 0.5 mm"));
    assert_true(qr_exists(f->folder, "lens_relief.tif"));
    json_t *manifest = manifest_of(f, "lens.json");
    const json_t *relief = json_object_get(manifest, "relief");
    assert_string_equal(json_string_value(json_object_get(json_object_get(relief, "file"), "name")),
                        "lens_relief.tif");
    assert_string_equal(json_string_value(json_object_get(relief, "pitch_kind")), "mechanical");
    json_decref(manifest);
    qr_run(&o, "%s -o %s/none.tif --print 60@600 --print-size 20x10 --views 4 --relief", f->quilt,
           f->folder);
    qr_assert_fails(&o, 2, "needs the radius, the thickness or the viewing angle");
    assert_false(qr_exists(f->folder, "none.tif"));
}

static void frames_are_a_folder_and_older_ones_go(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    for (int views = 5; views >= 3; views -= 2) {
        qr_succeed("%s -o %s/frames/ --print 60@600 --print-size 20x10 --views %d --frame-set 150",
                   f->quilt, f->folder, views);
        assert_int_equal(qr_count_files(lf_test_path(f->folder, "frames")), views + 2);
    }
    assert_true(qr_exists(f->folder, "frames/frame_003.tif"));
    assert_true(qr_exists(f->folder, "frames/order.txt"));
    json_t *manifest = manifest_of(f, "frames/frames.json");
    assert_int_equal(json_array_size(json_object_get(manifest, "frames")), 3);
    json_decref(manifest);
    qr_run(&o, "%s -o %s/y.tif --print 60@600 --print-size 20x10 --frame-set 150", f->quilt,
           f->folder);
    qr_assert_fails(&o, 2, "the name of a frame set must end in /");
    qr_run(&o, "%s -o %s/frames/ --print 60@600 --print-size 20x10 --frame-set 150 --marks",
           f->quilt, f->folder);
    qr_assert_fails(&o, 2, "--marks: has no effect on a frame set");
}

/* Every option of this kind of print that would do nothing is named. */
static void assert_refused(const char *line, const char *const *options, const char *why)
{
    qr_outcome o;
    char words[256], expected[512];
    for (int i = 0; options[i]; i++) {
        qr_run(&o, "%s %s", line, options[i]);
        snprintf(words, sizeof words, "%s", options[i]);
        words[strcspn(words, " ")] = '\0';
        snprintf(expected, sizeof expected, "%s: has no effect %s", words, why);
        qr_assert_fails(&o, 2, expected);
    }
}

static void profiles_have_no_word_for_the_pitch(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s -o %s/auto.tif --print auto --print-size 20x10", f->quilt, f->folder);
    qr_assert_fails(&o, 2, "without --print, --lens and --printer give both");
}

static void options_that_would_do_nothing_are_named(void **state)
{
    static const char *const chart[] = {"--slant 10",
                                        "--relief",
                                        "--lens-grid square",
                                        "--view-rows 2",
                                        "--phase-down 1",
                                        "--map exact",
                                        "--thickness 1",
                                        "--index 1.5",
                                        "--radius 1",
                                        "--viewing-angle 40",
                                        "--distance 400",
                                        "--spot 0.1",
                                        "--dot-gain 0.1",
                                        "--ink-spread 0.01",
                                        "--compensate on",
                                        "--headroom 0.1",
                                        "--guard-kind white",
                                        "--label-size 3",
                                        "--frame-set 100",
                                        "--gutter 2",
                                        "--marks",
                                        NULL};
    static const char *const frames[] = {"--gutter 2",
                                         "--stripes nearest",
                                         "--guard-kind white",
                                         "--spot 0.1",
                                         "--ink-spread 0.01",
                                         "--headroom 0.1",
                                         "--compensate on",
                                         "--phase 1",
                                         "--label-size 3",
                                         "--mirror",
                                         NULL};
    static const char *const lonely[][3] = {{"--headroom 0.1", NULL, "without --compensate"},
                                            {"--gutter 2", NULL, "without --copies"},
                                            {"--label-size 3", NULL, "without --label"},
                                            {"--guard-kind white", NULL, "without --guard"}};
    const qr_files *f = *state;
    char line[2 * PATH_MAX];
    snprintf(line, sizeof line, "-o %s/none.tif --chart 60+-0.5/0.1@600 --print-size 60x60",
             f->folder);
    assert_refused(line, chart, "on a chart");
    snprintf(line, sizeof line,
             "%s -o %s/none/ --print 60@600 --print-size 20x10 --views 3 --frame-set 150", f->quilt,
             f->folder);
    assert_refused(line, frames, "on a frame set");
    snprintf(line, sizeof line, "%s -o %s/none.tif --print 60@600 --print-size 20x10 --views 3",
             f->quilt, f->folder);
    for (size_t i = 0; i < sizeof lonely / sizeof *lonely; i++)
        assert_refused(line, lonely[i], lonely[i][2]);
    assert_false(qr_exists(f->folder, "none.tif"));
    qr_succeed("%s --label a --label-size 3 --check off", line);
}

static void frames_of_a_scene_are_rendered_at_their_size(void **state)
{
    const qr_files *f = *state;
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        qr_succeed(
            "%s -o %s/scene/ --print 60@600 --print-size 6x4 --bleed 1 --views 3 --frame-set "
            "100 --passes 1 --orientation %s",
            f->scene, f->folder, horizontal ? "horizontal" : "vertical");
        json_t *manifest = manifest_of(f, "scene/frames.json");
        const json_t *size = json_object_get(json_object_get(manifest, "size"), "frame_px");
        assert_int_equal(json_integer_value(json_array_get(size, 0)), 31);
        assert_int_equal(json_integer_value(json_array_get(size, 1)), 24);
        json_decref(manifest);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_does_not_grow_with_the_print),
        cmocka_unit_test(a_banner_of_photos_takes_500_mb),
        cmocka_unit_test(a_print_is_a_pdf_by_its_name),
        cmocka_unit_test(a_relief_lies_beside_its_print),
        cmocka_unit_test(frames_are_a_folder_and_older_ones_go),
        cmocka_unit_test(profiles_have_no_word_for_the_pitch),
        cmocka_unit_test(options_that_would_do_nothing_are_named),
        cmocka_unit_test(frames_of_a_scene_are_rendered_at_their_size),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
