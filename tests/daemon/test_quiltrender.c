/* quiltrender from outside: exit codes, error lines, the same bytes for any threads. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>

/* ------------------------------------------------------------------------------- wrong usage -- */

static const struct {
    const char *line, *words; /* %S = the scene, %Q = the quilt, %D = the folder */
} wrong_usage[] = {
    {"", "SCENE: is missing"},
    {"%S", "-o: is missing"},
    {"%S other.json -o %D/x.png", "other.json: unexpected argument; give only one SCENE"},
    {"%S other.json -o %D/x.tif --print 60@300 --print-size 20x20 --copies 1x2",
     "other.json: unexpected argument; --copies repeats one SCENE"},
    {"%S -o %D/x.webp", "/x.webp: must end in .png, .exr, .jpg or .jpeg for an image; "
                        "quiltrender(1) has other outputs under OUT"},
    {"%S -o %D/x", "must end in .png, .exr, .jpg or .jpeg for an image; quiltrender(1)"},
    {"%S -o %D/x.tif", "/x.tif: this is the name of a print; add --print"},
    {"%S -o %D/x.tiff", "this is the name of a print; add --print"},
    {"%S -o %D/x.gif", ".gif holds a loop of views; add --wiggle"},
    {"%S -o %D/x.gif --wiggle --crf 20", "--crf: applies only to OUT.mp4"},
    {"%S -o %D/x.gif --wiggle --views 1", "--wiggle: needs at least two views"},
    {"%S -o %D/x.gif --wiggle --still", "run one job for each output"},
    {"%S -o %D/x.png --wiggle", "the name of a loop of views must end in .gif or .mp4"},
    {"%S -o %D/x.png --still --views 3",
     "--still: is one view and cannot be combined with --views 3"},
    {"%S -o %D/x_qs3x2.png --still", "the name says 3x2 tiles, but the image is one view"},
    {"%S -o %D/x.png --quality 80", "--quality: applies only to OUT.jpg"},
    {"%S -o %D/x.jpg --quality 0", "--quality: expects"},
    {"%S -o %D/x.png --state %S", "is the input; choose another output name"},
    {"%S -o %D/x.png --views 1 --state %D/./x.png",
     "--state: names the same file as another output"},
    {"%S -o %D/x.png --state %D/x.state --stats %D/x.state",
     "--state: names the same file as another output"},
    {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --state %D/x.json",
     "--state: names the same file as another output"},
    {"%Q -o %D/x.png --state %D/s", "--state: cannot be combined with a finished quilt"},
    {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60 --state s",
     "--state: cannot be combined with --chart"},
    {"%S --state-info %D/s", "--state-info: renders nothing"},
    {"%S -o %D/.png", "expected a file name before the ending .png"},
    {"%S -o %D/.exr --reconstruct off", "expected a file name before the ending .exr"},
    {"-o %D/.tif --chart 60+-0.5/0.1@600 --print-size 60x60",
     "expected a file name before the ending .tif"},
    {"%S -o %D/x\x1by.png", "must not contain control characters or line breaks"},
    {"%S -o %D/x\x01y/", "must not contain control characters or line breaks"},
    {"%S -o %D/x.png --shiny", "--shiny: unknown option"},
    {"%S -o %D/x.png --views many", "--views: expects a whole number"},
    {"%S -o %D/x.png --preset phone", "--preset: "},
    {"%S -o %D/x.png --quilt 2x2", "--quilt: 2x2 has 4 tiles"},
    {"%S -o %D/x_qs5x9a0.75.png", "the name says 5x9"},
    {"%S -o %D/x.png --passes 4 --spp 4", "cannot be combined; give only one of them"},
    {"%S -o %D/x.png --time 1 --target-error 0.1", "cannot be combined; give only one of them"},
    {"%S -o %D/x.png --target-shown-error 0.1 --target-error 0.1",
     "cannot be combined; give only one of them"},
    {"%S -o %D/x.exr --target-shown-error 0.1", "needs a denoised image"},
    {"%S -o %D/x.png --target-shown-error 0.1 --denoise off", "needs a denoised image"},
    {"%S -o %D/x.png --reconstruct on --estimator cv", "on needs --estimator mwis"},
    {"%S -o %D/x.png --denoise much", "--denoise: expects"},
    {"%S -o %D/x.png --integrator mismvpt --selection tv",
     "--selection: is not supported by the integrator mismvpt"},
    {"%S -o %D/x.png --shift raw-copy", "--shift: is not supported by the integrator mvpt"},
    {"%S -o %D/x.png --reuse both", "--reuse: is not supported by the integrator mvpt"},
    {"%S -o %D/x.png --time 0", "--time: expects"},
    {"%S -o %D/x.png --filter linear", "--filter: needs --panel"},
    {"%S -o %D/x.png --bleed 3", "--bleed: needs --print"},
    {"%S -o %D/x.tif --print 60@600", "needs --print-size"},
    {"%S -o %D/x.tif --print 60 --print-size 20x20", "--print: expects"},
    {"%S -o %D/x.tif --print 60@600,5 --print-size 20x20",
     "DPI a number from 50 to 9600 dpi, or two as XxY"},
    {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --bits 12", "--bits: expects 8 or 16"},
    {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --compress zip",
     "--compress: expects none, lzw or deflate"},
    {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --orientation up", "--orientation: "},
    {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --views 12", "12"},
    {"%S -o %D/x.tif --print 60@600 --print-size 20x20 --preset go",
     "cannot be combined with --preset"},
    {"%S -o %D/x.tif --print 600@50 --print-size 20x20",
     "--print: a lens of 600 lpi has 0.0833 pixels at 50 dpi, too few for 2 views"},
    {"%S -o %D/x.png --print 60@600 --print-size 20x20", "must end in .tif"},
    {"%S -o %D/x.png --panel p.json --print 60@600 --print-size 20x20", "run one job"},
    {"%S -o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60", "renders nothing"},
    {"-o %D/x.tif --chart 60+-0.5@600 --print-size 60x60", "--chart: expects LPI+-RANGE/STEP@DPI"},
    {"-o %D/x.tif --chart 60+-0.5/0.1@600", "needs --print-size"},
    {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60 --marks", "marks"},
    {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x60 --spp 4",
     "--spp: cannot be combined with --chart"},
    {"-o %D/x.tif --chart 60+-0.5/0.1@600 --print-size 60x20", "11 bands"},
    {"-o %D/x.png --chart 60+-0.5/0.1@600 --print-size 60x60", "must end in .tif"},
    {"%S -o %D/fog.tif --print 60@600 --print-size 2x2 --views 2 --spp 1",
     "is the input; choose another output name"},
    {"%S -o %D/x.png --stats %S", "is the input; choose another output name"},
    {"%S -o %D/panel.tif --print 60@600 --print-size 2x2 --views 2 --spp 1",
     "is not a print manifest"},
    {"%S -o %D/x.png --aov depth", "--aov: applies only to OUT.exr"},
    {"%S -o %D/x.exr --aov width", "all, none or some of"},
    {"%S -o %D/x.exr --guides", "--guides: applies only to OUT.png"},
    {"%Q -o %D/x.png --guides", "--guides: cannot be combined with a finished quilt"},
    {"%Q -o %D/x.exr --aov depth", "--aov: cannot be combined with a finished quilt"},
    {"%S -o %D/x.png --near 2", "--near: needs --rgbd"},
    {"%S -o %D/x.exr --rgbd right", "the name of an image with depth must end in .png"},
    {"%S -o %D/x.png --rgbd right --near 3 --far 2", "--near: near (3) must be less"},
    {"%Q -o %D/x.png --rgbd right", "is a finished image without depth"},
    {"%S -o %D/x.png --skip all,none", "all, none or some of"},
    {"%Q -o %D/x.png --view-size 4x4", "--view-size: cannot be combined with a finished quilt"},
    {"%Q -o %D/x.png --preset portrait", "if the image has depth next to it, add --rgbd-in"},
    {"%Q -o %D/x.png --spp 64", "--spp: cannot be combined with a finished quilt"},
    {"%Q -o %D/x.png --reconstruct on", "--reconstruct: cannot be combined with a finished quilt"},
    {"%Q -o %D/x.png --threads 1 --estimator cv",
     "--estimator: cannot be combined with a finished quilt"},
    {"%Q -o %D/x.png --views 7", "--views: asks for 7 views, but the quilt has 6"},
    {"%S -o %D/x.png --estimator best", "--estimator: "},
};

static void wrong_usage_is_one_line_and_exit_2(void **state)
{
    const qr_files *f = *state;
    int before = qr_count_files(f->folder);
    for (size_t i = 0; i < sizeof wrong_usage / sizeof wrong_usage[0]; i++) {
        char line[4 * PATH_MAX] = "";
        qr_outcome o;
        for (const char *c = wrong_usage[i].line; *c; c++) {
            const char *insert = c[0] != '%'   ? NULL
                                 : c[1] == 'S' ? f->scene
                                 : c[1] == 'Q' ? f->quilt
                                               : f->folder;
            size_t used = strlen(line);
            snprintf(line + used, sizeof line - used, insert ? "%s" : "%.1s", insert ? insert : c);
            c += !!insert;
        }
        print_message("%s\n", wrong_usage[i].line);
        qr_run(&o, "%s", line);
        qr_assert_fails(&o, 2, wrong_usage[i].words);
    }
    assert_int_equal(qr_count_files(f->folder), before);
}

static void failing_jobs_are_one_line_and_exit_1(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    int before = qr_count_files(f->folder);
    qr_run(&o, "%s/absent.json -o %s/x.png", f->folder, f->folder);
    qr_assert_fails(&o, 1, "absent.json");
    qr_run(&o, "%s -o %s/nowhere/x.png", f->scene, f->folder);
    qr_assert_fails(&o, 1, "nowhere");
    qr_run(&o, "%s -o %s/x.png --panel %s/absent.json", f->scene, f->folder, f->folder);
    qr_assert_fails(&o, 1, "absent.json");
    qr_run(&o, "%s -o %s/x.png --panel %s", f->scene, f->folder, f->scene);
    qr_assert_fails(&o, 1, "fog.json");
    qr_run(&o, "%s -o %s/x.png --stats %s/nowhere/s.json", f->scene, f->folder, f->folder);
    qr_assert_fails(&o, 1, "s.json");
    assert_int_equal(qr_count_files(f->folder), before);
    const char *bad =
        lf_test_write(f->folder, "bad.json", "{ \"quiltd\": 1,\n  \"camera\": { \"fov\": 14 } }\n");
    qr_run(&o, "%s -o %s/x.png", bad, f->folder);
    qr_assert_fails(&o, 1, "bad.json:2");
    bad = lf_test_write(f->folder, "bad_qs3x2.png", "no picture");
    qr_run(&o, "%s -o %s/x.png", bad, f->folder);
    assert_int_equal(o.code, 1);
    assert_false(qr_exists(f->folder, "x.png"));
}

static void help_and_version_answer_on_stdout(void **state)
{
    qr_outcome o;
    (void)state;
    qr_run(&o, "--help");
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.out, "Usage: quiltrender SCENE -o OUT"));
    assert_non_null(strstr(o.out, "restir; mvrestir")); /* the longest help's end */
    assert_string_equal(o.err, "");
    qr_run(&o, "--version");
    assert_int_equal(o.code, 0);
    assert_true(strncmp(o.out, "quiltrender ", 12) == 0);
    assert_string_equal(o.err, "");
}

/* ---------------------------------------------------------------------------- quilt pictures -- */

static void a_quilt_goes_to_floats_and_folders_and_back(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    lf_image8 before = {0};
    lf_image8 after = {0};
    lf_error err = {0};
    qr_succeed("%s -o %s/a.exr", f->quilt, d);
    qr_succeed("%s/a_qs3x2a1.5.exr -o %s/a/", d, d);
    /* names of more than three digits come behind those of three */
    char last[2][PATH_MAX];
    for (int i = 0; i < 2; i++) {
        snprintf(last[0], sizeof last[0], "%s/a/view_%03d.exr", d, 4 + i);
        snprintf(last[1], sizeof last[1], "%s/a/view_%d.exr", d, 999 + i);
        assert_int_equal(rename(last[0], last[1]), 0);
    }
    qr_succeed("%s/a/ -o %s/b_qs3x2a1.5.png --quilt 3x2", d, d);
    lf_assert_ok(lf_image8_read(f->quilt, NULL, &before, &err), &err);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "b_qs3x2a1.5.png"), NULL, &after, &err), &err);
    assert_int_equal(before.width, after.width);
    assert_int_equal(before.height, after.height);
    for (int y = 0; y < before.height; y++)
        assert_memory_equal(before.data + (size_t)y * before.stride,
                            after.data + (size_t)y * after.stride, (size_t)before.width * 3);
    lf_image8_finish(&before);
    lf_image8_finish(&after);
}

static void a_quilt_is_woven_for_a_panel(void **state)
{
    const qr_files *f = *state;
    lf_calibration calibration;
    lf_interlacer *interlacer = NULL;
    lf_quilt_file quilt = {0};
    lf_image8 expected = {0};
    lf_image8 got = {0};
    lf_error err = {0};
    lf_assert_ok(lf_calibration_load(f->calibration, &calibration, &err), &err);
    lf_assert_ok(lf_quilt_read(f->quilt, NULL, 0, 0, &quilt, &err), &err);
    for (int variant = 0; variant < 2; variant++) {
        lf_filter filter = variant ? LF_FILTER_LINEAR : LF_FILTER_NEAREST;
        lf_invert invert = variant ? LF_INVERT_NO : LF_INVERT_AUTO;
        qr_succeed("%s -o %s/w.png --panel %s%s", f->quilt, f->folder, f->calibration,
                   variant ? " --filter linear --invert no" : "");
        lf_assert_ok(lf_interlacer_create(&calibration, VIEWS, WIDTH, HEIGHT, 1.5, filter, invert,
                                          &interlacer, &err),
                     &err);
        lf_assert_ok(lf_image8_init(&expected, 90, 60, 3), NULL);
        lf_interlace(interlacer, &quilt.views8, &expected, NULL);
        lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "w.png"), NULL, &got, &err), &err);
        for (int y = 0; y < 60; y++)
            assert_memory_equal(got.data + (size_t)y * got.stride,
                                expected.data + (size_t)y * expected.stride, 90 * 3);
        lf_interlacer_destroy(interlacer);
        lf_image8_finish(&expected);
        lf_image8_finish(&got);
    }
    lf_quilt_finish(&quilt);
}

static json_t *load(const char *folder, const char *name)
{
    json_t *object = json_load_file(lf_test_path(folder, name), 0, NULL);
    assert_true(json_is_object(object));
    return object;
}

static void a_chart_needs_no_scene(void **state)
{
    const qr_files *f = *state;
    json_error_t error;
    qr_succeed("--chart 30+-0.2/0.1@300 --print-size 60x40 -o %s/chart.tif", f->folder);
    json_t *manifest = json_load_file(lf_test_path(f->folder, "chart.json"), 0, &error);
    const json_t *chart = json_object_get(manifest, "chart");
    assert_int_equal(json_array_size(json_object_get(chart, "bands")), 5);
    json_decref(manifest);
}

static void a_quilt_is_printed(void **state)
{
    const qr_files *f = *state;
    qr_succeed(
        "%s -o %s/p.tif --print 60@600 --print-size 20x15 --bleed 2 --compress lzw --views 5",
        f->quilt, f->folder);
    json_t *manifest = load(f->folder, "p.json");
    assert_true(qr_exists(f->folder, "p.tif"));
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(manifest, "stripes"), "views")), 5);
    json_decref(manifest);
    qr_succeed("%s -o %s/q.tif --print 60@600 --print-size 20x15", f->quilt, f->folder);
    manifest = load(f->folder, "q.json");
    /* ten would fit */
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(manifest, "stripes"), "views")), VIEWS);
    json_decref(manifest);
}

/* --------------------------------------------------------------------------------- rendering -- */

static void stats_have_the_stated_keys_and_nothing_made_up(void **state)
{
    static const char *const keys[] = {"scene",
                                       "integrator",
                                       "estimator",
                                       "views",
                                       "width",
                                       "height",
                                       "threads",
                                       "seed",
                                       "passes",
                                       "seconds",
                                       "cpu_seconds",
                                       "base_paths",
                                       "native_spp_mean",
                                       "effective_spp_mean",
                                       "rel_mse_estimate",
                                       "rel_mse_bound",
                                       "error",
                                       "error_bound",
                                       "denoised_error",
                                       "denoised_error_bound",
                                       "shown_error",
                                       "shown_error_bound",
                                       "rays_traced",
                                       "volume_lookups",
                                       "contributions",
                                       "nonfinite_dropped",
                                       "max_depth_loss",
                                       "peak_rss_bytes",
                                       "skipped"};
    const size_t n = sizeof keys / sizeof keys[0];
    const qr_files *f = *state;
    qr_succeed(
        "%s -o %s/s.exr --view-size 12x16 --spp 4 --seed 5 --threads 2 --estimator mis --stats "
        "%s/s.json",
        f->scene, f->folder, f->folder);
    qr_succeed("%s -o %s/t.exr --stats %s/t.json", f->quilt, f->folder, f->folder);
    for (int quilt = 0; quilt < 2; quilt++) {
        json_t *stats = load(f->folder, quilt ? "t.json" : "s.json");
        assert_int_equal(json_object_size(stats), n);
        for (size_t i = 0; i < n; i++)
            assert_non_null(json_object_get(stats, keys[i]));
        assert_int_equal(json_integer_value(json_object_get(stats, "views")), VIEWS);
        assert_true(json_integer_value(json_object_get(stats, "peak_rss_bytes")) > 1000000);
        assert_true(json_is_object(json_object_get(stats, "skipped")));
        for (size_t i = 0; quilt && i < n; i++) {
            bool applies = strcmp(keys[i], "scene") == 0 || strcmp(keys[i], "views") == 0 ||
                           strcmp(keys[i], "width") == 0 || strcmp(keys[i], "height") == 0 ||
                           strcmp(keys[i], "threads") == 0 ||
                           strcmp(keys[i], "peak_rss_bytes") == 0 ||
                           strcmp(keys[i], "skipped") == 0;
            assert_int_equal(json_is_null(json_object_get(stats, keys[i])), !applies);
        }
        json_decref(stats);
    }
    json_t *stats = load(f->folder, "s.json");
    assert_string_equal(json_string_value(json_object_get(stats, "integrator")), "mvpt");
    assert_string_equal(json_string_value(json_object_get(stats, "estimator")), "mis");
    assert_int_equal(json_integer_value(json_object_get(stats, "seed")), 5);
    assert_int_equal(json_integer_value(json_object_get(stats, "threads")), 2);
    assert_int_equal(json_integer_value(json_object_get(stats, "passes")), 4 * VIEWS);
    assert_int_equal(json_integer_value(json_object_get(stats, "base_paths")), 4 * VIEWS * 12 * 16);
    assert_int_equal(json_integer_value(json_object_get(stats, "nonfinite_dropped")), 0);
    assert_true(json_is_integer(json_object_get(stats, "rays_traced")));
    json_decref(stats);
}

static void the_same_bytes_for_any_number_of_threads(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    static const char *const ways[] = {"--estimator mwis", "--estimator cv",
                                       "--estimator mis --sampler independent",
                                       "--integrator vpt --estimator mis"};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        for (int threads = 1; threads <= 3; threads++)
            qr_succeed("%s -o %s/n%d_qs2x3a0.75.exr --view-size 15x20 --quilt 2x3 --spp 3 --seed 7 "
                       "--threads %d %s",
                       f->scene, d, threads, threads, ways[i]);
        for (int threads = 2; threads <= 3; threads++) {
            char other[64];
            snprintf(other, sizeof other, "n%d_qs2x3a0.75.exr", threads);
            qr_assert_same_files(lf_test_path(d, "n1_qs2x3a0.75.exr"), lf_test_path(d, other));
        }
    }
    /* and they are not the same by accident */
    qr_succeed("%s -o %s/n2_qs2x3a0.75.exr --view-size 15x20 --quilt 2x3 --spp 3 --seed 8 %s",
               f->scene, d, ways[3]);
    qr_assert_different_files(lf_test_path(d, "n1_qs2x3a0.75.exr"),
                              lf_test_path(d, "n2_qs2x3a0.75.exr"));
}

static void spp_is_so_many_passes_a_view(void **state)
{
    const qr_files *f = *state;
    qr_succeed("%s -o %s/e1_qs2x3a0.75.exr --quilt 2x3 --view-size 15x20 --spp 2", f->scene,
               f->folder);
    qr_succeed("%s -o %s/e2_qs2x3a0.75.exr --quilt 2x3 --view-size 15x20 --passes 12", f->scene,
               f->folder);
    qr_assert_same_files(lf_test_path(f->folder, "e1_qs2x3a0.75.exr"),
                         lf_test_path(f->folder, "e2_qs2x3a0.75.exr"));
}

/* As of every other option. */
static void the_last_of_a_budget_given_twice_counts(void **state)
{
    const qr_files *f = *state;
    qr_succeed("%s -o %s/twice_qs2x3a0.75.exr --quilt 2x3 --view-size 15x20 --spp 3 --spp 1",
               f->scene, f->folder);
    qr_succeed("%s -o %s/once_qs2x3a0.75.exr --quilt 2x3 --view-size 15x20 --spp 1", f->scene,
               f->folder);
    qr_assert_same_files(lf_test_path(f->folder, "twice_qs2x3a0.75.exr"),
                         lf_test_path(f->folder, "once_qs2x3a0.75.exr"));
}

static void every_budget_ends(void **state)
{
    const qr_files *f = *state;
    qr_succeed("%s -o %s/b_qs2x3a0.75.png --quilt 2x3 --view-size 6x8 --time 0.2 --stats %s/b.json",
               f->scene, f->folder, f->folder);
    json_t *stats = load(f->folder, "b.json");
    assert_true(json_integer_value(json_object_get(stats, "passes")) >= 2);
    json_decref(stats);
    qr_succeed("%s -o %s/b_qs2x3a0.75.png --quilt 2x3 --view-size 6x8 --target-error 0.05 --stats "
               "%s/b.json",
               f->scene, f->folder, f->folder);
    stats = load(f->folder, "b.json");
    const json_t *error = json_object_get(stats, "rel_mse_estimate");
    assert_true(json_is_real(error));
    assert_true(json_real_value(error) <= 0.05 && json_real_value(error) > 0);
    const json_t *bound = json_object_get(stats, "rel_mse_bound");
    assert_true(json_real_value(bound) <= 0.05 && json_real_value(bound) > json_real_value(error));
    json_decref(stats);
    qr_succeed("%s -o %s/b_qs2x3a0.75.png --quilt 2x3 --view-size 6x8 --passes 1 --estimator cv",
               f->scene, f->folder);
}

static void a_scene_becomes_what_the_options_say(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    lf_quilt_file quilt = {0};
    lf_image8 panel = {0};
    lf_error err = {0};
    qr_succeed("%s -o %s/o/ --views 3 --view-size 9x7 --spp 1", f->scene, d);
    lf_assert_ok(lf_quilt_read(lf_test_path(d, "o/"), NULL, 0, 0, &quilt, &err), &err);
    assert_int_equal(quilt.layout.n_views, 3);
    assert_int_equal(quilt.layout.view_width, 9);
    assert_int_equal(quilt.layout.view_height, 7);
    lf_quilt_finish(&quilt);

    qr_succeed("%s -o %s/o.png --views 5 --quilt 3x2 --view-size 9x12 --spp 1", f->scene, d);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "o_qs3x2a0.75.png"), NULL, &panel, &err), &err);
    assert_int_equal(panel.width, 27);
    assert_int_equal(panel.height, 24);
    for (int x = 18; x < 27; x++) /* the sixth tile, top right, is black */
        assert_int_equal(panel.data[(size_t)5 * panel.stride + (size_t)x * 3], 0);
    lf_image8_finish(&panel);

    qr_succeed("%s -o %s/o.png --panel %s --view-size 18x12 --spp 1", f->scene, d, f->calibration);
    lf_assert_ok(lf_image8_read(lf_test_path(d, "o.png"), NULL, &panel, &err), &err);
    assert_int_equal(panel.width, 90);
    assert_int_equal(panel.height, 60);
    lf_image8_finish(&panel);

    for (int horizontal = 0; horizontal < 2; horizontal++) {
        qr_succeed("%s -o %s/o.tif --print 20.04@100 --print-size 30x20 --bleed 1 --orientation %s "
                   "--spp 1 --stats %s/o_stats.json",
                   f->scene, d, horizontal ? "horizontal" : "vertical", d);
        json_t *stats = load(d, "o_stats.json");
        /* floor(0.8 * 100 / 20.04) */
        assert_int_equal(json_integer_value(json_object_get(stats, "views")), 3);
        int across = (int)json_integer_value(json_object_get(stats, "width"));
        int lenses = (int)ceil((horizontal ? 22 : 32) * 20.04 / 25.4);
        assert_in_range(across, lenses, lenses + 2);
        assert_int_equal(json_integer_value(json_object_get(stats, "height")),
                         (int)lround((horizontal ? 32 : 22) * 100 / 25.4));
        json_decref(stats);
    }
}

static void what_a_scene_lacks_is_a_line_on_stderr(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char scene[PATH_MAX];
    lf_test_write(f->folder, "bare.mtl", "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\nd 0.5\n");
    lf_test_write(f->folder, "bare.obj",
                  "mtllib bare.mtl\nusemtl wood\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    snprintf(
        scene, sizeof scene, "%s",
        lf_test_write(f->folder, "bare.json", "{\"meshes\": {\"m\": {\"file\": \"bare.obj\"}}}"));
    qr_run(&o, "%s --spp 1 --views 2 --quilt 2x1 --view-size 8x8 -o %s/bare.png", scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(
        strstr(o.err, "bare.obj: 1 texture is left out: the mesh has no texture coordinates"));
    assert_non_null(strstr(o.err, "bare.json: the scene has no light"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage_is_one_line_and_exit_2),
        cmocka_unit_test(failing_jobs_are_one_line_and_exit_1),
        cmocka_unit_test(help_and_version_answer_on_stdout),
        cmocka_unit_test(a_quilt_goes_to_floats_and_folders_and_back),
        cmocka_unit_test(a_quilt_is_woven_for_a_panel),
        cmocka_unit_test(a_chart_needs_no_scene),
        cmocka_unit_test(a_quilt_is_printed),
        cmocka_unit_test(stats_have_the_stated_keys_and_nothing_made_up),
        cmocka_unit_test(the_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(spp_is_so_many_passes_a_view),
        cmocka_unit_test(the_last_of_a_budget_given_twice_counts),
        cmocka_unit_test(every_budget_ends),
        cmocka_unit_test(a_scene_becomes_what_the_options_say),
        cmocka_unit_test(what_a_scene_lacks_is_a_line_on_stderr),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
