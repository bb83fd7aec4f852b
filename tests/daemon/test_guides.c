/* Guides: what lies outside of the sharp depth is marked, in the colours that are said, and nothing
 * else is touched; and what is said of a depth that is too much, in words of who says it. */
#include "tests/daemon/quiltrender.h"
#include "tests/scene_file.h"

#include "daemon/output/content.h"
#include "daemon/output/guides.h"

static const lf_depth depth = {.sharp_from = 8.0, .sharp_to = 12.0};

/* Grey of 0.5 at a distance, covered by a share. */
static void mark(const lf_depth *d, double exposure, double z, double covered, float out[3])
{
    const float layers[2] = {(float)z, (float)covered};
    out[0] = out[1] = out[2] = 0.5f;
    lf_guides_mark(d, exposure, layers, 1, out);
}

static void what_is_sharp_and_what_meets_nothing_is_left_alone(void **state)
{
    (void)state;
    static const double at[][2] = {{8.01, 1}, {10, 1}, {11.99, 1}, {0, 0}, {0, 1}, {7, 0}, {13, 0}};
    for (size_t i = 0; i < sizeof at / sizeof at[0]; i++) {
        float c[3];
        mark(&depth, 0, at[i][0], at[i][1], c);
        assert_true(c[0] == 0.5f && c[1] == 0.5f && c[2] == 0.5f);
    }
    const lf_depth endless = {.sharp_from = 8.0, .sharp_to = (double)INFINITY};
    float c[3];
    mark(&endless, 0, 1e9, 1, c);
    assert_true(c[0] == 0.5f && c[2] == 0.5f);
}

static void what_is_too_near_is_red_and_what_is_too_far_is_blue(void **state)
{
    (void)state;
    float near[3], far[3], half[3], dark[3];
    mark(&depth, 0, 7.99, 1, near);
    mark(&depth, 0, 12.01, 1, far);
    mark(&depth, 0, 5, 0.5, half);
    mark(&depth, -3, 5, 1, dark); /* shown 8 times darker: the mark is as bright on the screen */
    assert_true(near[0] > 0.65f && near[1] < 0.3f && near[2] < 0.3f);
    assert_true(far[2] > 0.65f && far[1] < 0.35f && far[0] < 0.3f);
    for (int i = 0; i < 3; i++) {
        lf_assert_close(half[i], 0.5 * (0.5 + (double)near[i]), 1e-5, 0);
        lf_assert_close(dark[i] - 0.25f, 8.0 * (double)(near[i] - 0.25f), 1e-5, 0);
    }
}

/* White cubes one behind the other, under an even sky: each has the colour of where it stands. */
static void cubes_before_in_and_behind_the_window(void **state)
{
    const qr_files *f = *state;
    char path[PATH_MAX], out[PATH_MAX];
    snprintf(path, sizeof path, "%s",
             lf_test_write(f->folder, "cubes.json", lf_test_scene_text("cubes-in-depth")));
    qr_succeed("%s -o %s/cubes.png --guides --view-size 60x60 --quilt 5x1 --spp 4", path,
               f->folder);
    snprintf(out, sizeof out, "%s/cubes_qs5x1a1.png", f->folder);
    lf_image8 image = {0};
    lf_assert_ok(lf_image8_read(out, NULL, &image, NULL), NULL);
    /* The middle view: slopes of the middles of the cubes, over that of the window's edge. */
    static const double slope[] = {-0.6 / 6, 0, 2.0 / 18};
    for (int i = 0; i < 3; i++) {
        int x = 2 * 60 + 30 + (int)(30 * slope[i] / tan(10 * M_PI / 180));
        const uint8_t *at = image.data + 30 * image.stride + (size_t)x * 3;
        int redder = at[0] - at[2];
        assert_true(i == 0 ? redder > 40 : i == 1 ? abs(redder) < 3 : redder < -40);
    }
    const uint8_t *sky = image.data + 5 * image.stride + (size_t)(2 * 60 + 30) * 3;
    assert_true(sky[0] == sky[2]);
    lf_image8_finish(&image);
}

static void guides_that_mark_nothing_are_told(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    static const char nothing[] = "--guides: marks nothing", sharp[] = "guides: the panel shows";
    qr_run(&o, "%s -o %s/one.png --guides --still --view-size 16x16 --passes 1", f->scene,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_true(strstr(o.err, nothing) && !strstr(o.err, sharp));
    qr_run(&o, "%s -o %s/two.png --guides --views 2 --view-size 16x16 --passes 1", f->scene,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_true(!strstr(o.err, nothing) && strstr(o.err, sharp));
}

/* What is beyond a limit is not told as the limit. */
static void numbers_that_differ_are_told_apart(void **state)
{
    (void)state;
    lf_depth d = {.nearest_step = -2, .farthest_step = 16.946, .limit = 16.8, .sharp_to = 12};
    char words[LF_DEPTH_WORDS];
    lf_depth_words(&d, 420, LF_DEPTH_PANEL, words, sizeof words);
    assert_non_null(strstr(words, "behind the focal plane shift by 16.9 of 420 pixels"));
    assert_non_null(strstr(words, "(limit 16.8; sharp up to distance 12)"));
    assert_non_null(strstr(words, "camera.fit"));
    d.farthest_step = 59.3;
    lf_depth_words(&d, 420, LF_DEPTH_FILE, words, sizeof words);
    assert_non_null(strstr(words, "by 59 of 420 pixels"));
    assert_non_null(strstr(words, "(limit 17; sharp"));
    /* a method of a socket is nothing to quiltrender, nor is a panel to a print */
    assert_null(strstr(words, "camera."));
    const lf_camera sharp = {.view_blur = 0}, smooth = {.view_blur = 1};
    d.nearest_step = -1.04;
    d.farthest_step = 0.5;
    assert_true(lf_depth_exceeds(&d, &sharp, LF_DEPTH_PRINT));
    assert_false(lf_depth_exceeds(&d, &smooth, LF_DEPTH_PRINT));
    assert_false(lf_depth_exceeds(&d, &sharp, LF_DEPTH_FILE));
    lf_depth_words(&d, 142, LF_DEPTH_PRINT, words, sizeof words);
    assert_non_null(strstr(words, "in front of the focal plane shift by 1.04 of 142 lenses"));
    assert_non_null(strstr(words, "(limit 1.00)"));
    assert_null(strstr(words, "camera."));
    assert_null(strstr(words, "panel"));
    d.nearest_step = -(double)INFINITY;
    lf_depth_words(&d, 142, LF_DEPTH_PRINT, words, sizeof words);
    assert_non_null(strstr(words, "by more than the view width"));
    d.nearest_step = -1;
    assert_false(lf_depth_exceeds(&d, &sharp, LF_DEPTH_PRINT));
}

/* Its manifest says it, too. */
static void a_print_says_how_deep_it_is(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char *manifest = NULL;
    size_t n;
    lf_error err = {0};
    qr_run(&o, "%s -o %s/deep.tif --print 40@300 --print-size 30x40 --passes 1", f->scene,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "fog.json: too deep for lenses"));
    assert_null(strstr(o.err, "ghost")); /* of the number of views that is the default */
    lf_assert_ok(
        lf_file_read(lf_test_path(f->folder, "deep.json"), NULL, 1 << 20, &manifest, &n, &err),
        &err);
    assert_non_null(memmem(manifest, n, "lenses between views", 20));
    lf_free(manifest);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_sharp_and_what_meets_nothing_is_left_alone),
        cmocka_unit_test(what_is_too_near_is_red_and_what_is_too_far_is_blue),
        cmocka_unit_test(cubes_before_in_and_behind_the_window),
        cmocka_unit_test(guides_that_mark_nothing_are_told),
        cmocka_unit_test(numbers_that_differ_are_told_apart),
        cmocka_unit_test(a_print_says_how_deep_it_is),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
