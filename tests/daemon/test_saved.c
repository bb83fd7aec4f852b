/* What quiltrender writes where nothing is said of reconstruct, and for how long it renders: the
 * picture that a panel would show, but what the estimator says where somebody measures. */
#include "tests/daemon/quiltrender.h"
#include "tests/daemon/written.h"

#include <jansson.h>

#include "daemon/tools/render_arguments.h"

#define SIZE "--view-size 15x20 --quilt 2x3"

static int64_t stat_of(const qr_files *f, const char *key)
{
    json_error_t error;
    json_t *stats = json_load_file(lf_test_path(f->folder, "stats.json"), 0, &error);
    assert_true(json_is_integer(json_object_get(stats, key)));
    const int64_t value = json_integer_value(json_object_get(stats, key));
    json_decref(stats);
    return value;
}

/* Nothing is said of how long. */
static void pictures_are_reconstructed_and_measurements_are_not(void **state)
{
    const qr_files *f = *state;
    static const struct {
        const char *options, *looked_at;
        bool expected;
    } all[] = {
        {"a.png", "a_qs2x3a0.75.png", true},
        {"a.png --integrator amvpt", "a_qs2x3a0.75.png", true},
        {"a.png --reconstruct off", "a_qs2x3a0.75.png", false},
        {"a.png --denoise off", "a_qs2x3a0.75.png", false},
        {"a.png --denoise off --reconstruct auto", "a_qs2x3a0.75.png", true},
        {"a.png --estimator mwis", "a_qs2x3a0.75.png", false},
        {"a.png --estimator mis", "a_qs2x3a0.75.png", false},
        {"a.png --integrator vpt", "a_qs2x3a0.75.png", false},
        {"a.png --integrator mvpt2022", "a_qs2x3a0.75.png", false},
        {"a.png --estimator mwis --reconstruct on", "a_qs2x3a0.75.png", true},
        {"a.exr", "a_qs2x3a0.75.exr", false},
        {"a.exr --reconstruct on", "a_qs2x3a0.75.exr", true},
        {"folder/", "folder/view_000.exr", false},
        {"folder/ --png", "folder/view_000.png", true},
        {"folder/ --png --views 1", "folder/view_000.png", true},
        {"p.png", "p.png", true},
        {"d.png --rgbd right", "d.png", true},
        {"s.tif --print 20@100 --print-size 9x12", "s.json", true},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        const bool prints = strstr(all[i].options, "--print "),
                   interlaces = all[i].looked_at[0] == 'p';
        print_message("%s\n", all[i].options);
        qr_succeed("%s -o %s/%s %s%s%s --stats %s/stats.json", f->scene, f->folder, all[i].options,
                   prints ? "" : SIZE, interlaces ? " --panel " : "",
                   interlaces ? f->calibration : "", f->folder);
        assert_int_equal(written_reconstructed(lf_test_path(f->folder, all[i].looked_at)),
                         all[i].expected);
        const int64_t passes = LF_RENDER_DEFAULT_SPP * stat_of(f, "views"),
                      fewer = passes < LF_RENDER_DEFAULT_PASSES ? passes : LF_RENDER_DEFAULT_PASSES;
        assert_int_equal(stat_of(f, "passes"), all[i].expected ? fewer : passes);
    }
}

/* Cameras one by one have none, and say so only to who asks for it. */
static void what_cannot_be_reconstructed_is_not(void **state)
{
    const qr_files *f = *state;
    char text[2 * PATH_MAX], scene[PATH_MAX];
    qr_outcome o;
    snprintf(
        text, sizeof text,
        "{ \"include\": \"%s\", \"camera\": { \"views\": { \"list\": [{ \"position\": [-2, 0, 6] "
        "}, { \"position\": [2, 1, 5] }] } } }",
        f->scene);
    snprintf(scene, sizeof scene, "%s", lf_test_write(f->folder, "list.json", text));
    qr_succeed("%s -o %s/l_qs2x1a0.75.png --quilt 2x1 --view-size 12x16", scene, f->folder);
    assert_false(written_reconstructed(lf_test_path(f->folder, "l_qs2x1a0.75.png")));
    qr_run(&o, "%s -o %s/l.png --view-size 12x16 --target-denoised-error 0.1", scene, f->folder);
    qr_assert_fails(&o, 2, "--target-denoised-error: is not supported with a list, path or circle");
}

/* What the programs wrote before there was a picture to reconstruct: the estimator's answer, toned,
 * and nothing else. */
static void off_is_the_answer_of_the_estimator(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    qr_succeed("%s -o %s/light.exr " SIZE " --spp 2", f->scene, d);
    qr_succeed("%s/light_qs2x3a0.75.exr -o %s/toned.png", d, d);
    qr_succeed("%s -o %s/off.png " SIZE " --spp 2 --reconstruct off", f->scene, d);
    qr_succeed("%s -o %s/mwis.png " SIZE " --spp 2 --estimator mwis", f->scene, d);
    qr_succeed("%s -o %s/on.png " SIZE " --spp 2", f->scene, d);
    qr_assert_same_files(lf_test_path(d, "off_qs2x3a0.75.png"),
                         lf_test_path(d, "mwis_qs2x3a0.75.png"));
    assert_int_equal(written_difference(lf_test_path(d, "off_qs2x3a0.75.png"),
                                        lf_test_path(d, "toned_qs2x3a0.75.png")),
                     0);
    assert_true(written_difference(lf_test_path(d, "off_qs2x3a0.75.png"),
                                   lf_test_path(d, "on_qs2x3a0.75.png")) > 2);
}

/* Whether the left of a picture is another one. */
static void assert_left_is(const char *path, const char *left_path)
{
    lf_image8 whole = {0}, left = {0};
    lf_error err = {0};
    lf_assert_ok(lf_image8_read(path, NULL, &whole, &err), &err);
    lf_assert_ok(lf_image8_read(left_path, NULL, &left, &err), &err);
    assert_int_equal(whole.width, 2 * left.width);
    assert_int_equal(whole.height, left.height);
    for (size_t y = 0; y < (size_t)left.height; y++)
        assert_memory_equal(whole.data + y * whole.stride, left.data + y * left.stride,
                            (size_t)left.width * 3);
    lf_image8_finish(&whole);
    lf_image8_finish(&left);
}

static void all_kinds_have_the_picture_of_the_quilt(void **state)
{
    const qr_files *f = *state;
    const char *d = f->folder;
    char text[2 * PATH_MAX], scene[PATH_MAX];
    /* the panel's aspect and cone */
    snprintf(text, sizeof text,
             "{ \"include\": \"%s\", \"camera\": { \"aspect\": 1.5, "
             "\"cone\": 40 } }",
             f->scene);
    snprintf(scene, sizeof scene, "%s", lf_test_write(d, "wide.json", text));
#define WIDE "--quilt 2x3 --view-size 30x20 --passes 6"
    qr_succeed("%s -o %s/w.png " WIDE, scene, d);
    qr_succeed("%s -o %s/panel.png " WIDE " --panel %s", scene, d, f->calibration);
    qr_succeed("%s/w_qs2x3a1.5.png -o %s/woven.png --panel %s", d, d, f->calibration);
    assert_int_equal(written_difference(lf_test_path(d, "panel.png"), lf_test_path(d, "woven.png")),
                     0);
    qr_succeed("%s -o %s/views/ --png " WIDE, scene, d);
    qr_succeed("%s/views/ -o %s/again_qs2x3a1.5.png --quilt 2x3", d, d);
    assert_int_equal(written_difference(lf_test_path(d, "w_qs2x3a1.5.png"),
                                        lf_test_path(d, "again_qs2x3a1.5.png")),
                     0);
    qr_succeed("%s -o %s/depth.png --rgbd right --rgbd-of quilt " WIDE, scene, d);
    assert_left_is(lf_test_path(d, "depth.png"), lf_test_path(d, "w_qs2x3a1.5.png"));
}

/* A cube as deep as wide fills the window: with the cone of panels it would shift by several lenses
 * from view to view. A cone that a scene says stays. */
static void a_print_of_a_file_alone_is_as_deep_as_lenses_show(void **state)
{
    const qr_files *f = *state;
    char cube[PATH_MAX], scene[PATH_MAX];
    qr_outcome o;
    snprintf(
        cube, sizeof cube, "%s",
        lf_test_write(f->folder, "cube.obj",
                      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
                      "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"));
    snprintf(scene, sizeof scene, "%s",
             lf_test_write(f->folder, "cube.json",
                           "{\"camera\": {\"fit\": true, \"cone\": 35}, \"meshes\": {\"m\": "
                           "{\"file\": \"cube.obj\"}}, \"lights\": {\"l\": {\"type\": "
                           "\"environment\", \"radiance\": 1}}}"));
    qr_run(&o, "%s -o %s/c.tif --print 60@600 --print-size 20x20 --passes 1", cube, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "so that the lenses show all of the scene sharply"));
    assert_null(strstr(o.err, "too deep"));
    qr_run(&o, "%s -o %s/s.tif --print 60@600 --print-size 20x20 --passes 1", scene, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "too deep for lenses"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_reconstructed_and_measurements_are_not),
        cmocka_unit_test(what_cannot_be_reconstructed_is_not),
        cmocka_unit_test(off_is_the_answer_of_the_estimator),
        cmocka_unit_test(all_kinds_have_the_picture_of_the_quilt),
        cmocka_unit_test(a_print_of_a_file_alone_is_as_deep_as_lenses_show),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
