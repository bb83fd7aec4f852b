/* Stress cases of lobes, colours, mirrors and scenes with nothing in them
 * (docs/developer/test-cases.md, "Stress cases"). Numbers of the cases are those of the list there.
 */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 16, height = 12, views = 5, pixels = views * width * height };

/* Comparisons that may fail by chance: blocks of 4 x 4 of some 30 runs. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 30 * (views * 12 + 1))

#define CAMERA                                                                                     \
    "'quiltd': 1, 'camera': { 'position': [0, 0, 5], 'fov_y': 20, 'aspect': 1.3333333333, "        \
    "'views': 5, 'cone': 30 }, "

enum { native_spp = 8 };

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, native_spp);
}

static void pictures(const char *text, const char *integrator, lf_estimator estimator,
                     int replicates, uint64_t salt, int block, lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_render_stats stats;
    lf_test_pictures(r, cycles, estimator, replicates, salt, block, out);
    lf_renderer_stats(r, &stats);
    assert_true(stats.nonfinite_dropped == 0);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------------- lobes -- */

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Variances of the pixels, ascending; [blocks->n - 1]. Caller frees. */
static double *variances(const lf_blocks *blocks)
{
    double *out = malloc((size_t)(blocks->n - 1) * sizeof *out);
    for (int i = 0; i < blocks->n - 1; i++)
        out[i] = lf_moments_variance(&blocks->moments[i]);
    qsort(out, (size_t)(blocks->n - 1), sizeof *out, ascending);
    return out;
}

/* By mwis, variance over 32 seeds: the middle half of all pixels taken together within 1 + 1/n of
 * native (and a fifth more for what 480 pixels of 32 seeds can tell), and no pixel a hundred times
 * as noisy as the noisiest native one. */
static void assert_never_noisier(const char *text, int replicates)
{
    lf_blocks blocks[2];
    double *v[2], middle[2] = {0.0, 0.0};
    for (int i = 0; i < 2; i++) {
        pictures(text, i ? "mvpt" : "vpt", LF_ESTIMATOR_MWIS, replicates, i ? 700 : 0, 1,
                 &blocks[i]);
        v[i] = variances(&blocks[i]);
        for (int j = pixels / 4; j < 3 * pixels / 4; j++)
            middle[i] += v[i][j];
    }
    print_message("variance %.3g of native, of the worst pixel %.3g\n", middle[1] / middle[0],
                  v[1][pixels - 1] / v[0][pixels - 1]);
    assert_true(middle[1] < 1.2 * (1.0 + 1.0 / native_spp) * middle[0]);
    assert_true(v[1][pixels - 1] < 100.0 * v[0][pixels - 1]);
    for (int i = 0; i < 2; i++) {
        lf_blocks_finish(&blocks[i]);
        free(v[i]);
    }
}

/* From nearly all backwards to nearly all forwards: mvpt and vpt have one mean, and mvpt is not
 * noisier by the same paths. */
static void case_14_lobes_of_any_width(void **state)
{
    (void)state;
    static const char *const all_g[] = {"0", "0.5", "-0.5", "0.98", "-0.98", "0.999", "-0.999"};
    for (int i = 0; i < 7; i++) {
        enum { replicates = 32 };
        const char *text = lf_test_scene_patched("fog-under-wide-sun",
                                                 "{'volumes': {'fog': {'g': %s}}}", all_g[i]);
        lf_blocks native, unbiased;
        pictures(text, "vpt", LF_ESTIMATOR_MIS, replicates, 0, 4, &native);
        pictures(text, "mvpt", LF_ESTIMATOR_CV, replicates, 700, 4, &unbiased);
        int where = 0;
        double p = lf_blocks_welch(&unbiased, &native, &where);
        if (!(p > LEVEL))
            fail_msg("g %s, block %d: %.6g +- %.2g, natively %.6g +- %.2g, p %.2g", all_g[i], where,
                     unbiased.moments[where].mean, lf_moments_error(&unbiased.moments[where]),
                     native.moments[where].mean, lf_moments_error(&native.moments[where]), p);
        lf_blocks_finish(&native);
        lf_blocks_finish(&unbiased);
        print_message("g %s: ", all_g[i]);
        assert_never_noisier(text, replicates);
    }
}

/* Mirrors first: nothing is shared, W is 0 everywhere, and in visits of the same size mvpt is vpt
 * bit for bit. */
static void case_15_mirrors_share_nothing(void **state)
{
    (void)state;
    static const char *const integrators[] = {"vpt", "mvpt"};
    double *picture[2], *d = malloc(pixels * sizeof *d), *q = malloc(pixels * sizeof *q);
    lf_scene *scene = lf_test_scene(lf_test_scene_text("mirror-and-lamp"));
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, integrators[i], width, height, NULL);
        r->visit_passes = lf_renderer_settings(r)->camera.n_views;
        cycles(r);
        picture[i] = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        lf_test_weights(r, false, d, q);
        for (int j = 0; j < pixels; j++)
            assert_true(d[j] == 0.0 && q[j] == 0.0);
        lf_renderer_destroy(r);
    }
    assert_memory_equal(picture[0], picture[1], pixels * sizeof *picture[0]);
    free(picture[0]);
    free(picture[1]);
    free(d);
    free(q);
    lf_scene_unref(scene);
}

/* ----------------------------------------------------------------------------------- colours -- */

/* Extinction has no colour here, albedos have: red light in a coloured scene is what it is in one
 * that is grey as red is. The picture is half of the red channel then. */
static const char *red_light(const char *fog, const char *ground)
{
    return lf_test_scene_patched(
        "red-light", "{'volumes': {'fog': {'albedo': %s}}, 'materials': {'clay': {'albedo': %s}}}",
        fog, ground);
}

static void case_22_channels_do_not_mix(void **state)
{
    (void)state;
    const char *const coloured[] = {red_light("[1, 0.5, 0.2]", "[0.1, 0.5, 0.9]"),
                                    red_light("[0.2, 1, 0.5]", "[0.9, 0.1, 0.5]")};
    const char *const grey[] = {red_light("1", "0.1"), red_light("0.2", "0.9")};
    for (int i = 0; i < 2; i++) {
        lf_blocks a, b;
        pictures(coloured[i], "mvpt", LF_ESTIMATOR_CV, 24, 0, 4, &a);
        pictures(grey[i], "mvpt", LF_ESTIMATOR_CV, 24, 700, 4, &b);
        assert_true(lf_blocks_welch(&a, &b, NULL) > LEVEL);
        assert_true(lf_blocks_welch_injected(&a, &b, a.n - 1, 1.02) < LEVEL);
        lf_blocks_finish(&a);
        lf_blocks_finish(&b);
    }
}

/* ----------------------------------------------------------------------------------- nothing -- */

/* By every answer of both integrators all pixels are `value`, and W and q are 0. */
static void assert_flat(const char *text, double value)
{
    static const char *const integrators[] = {"vpt", "mvpt"};
    lf_scene *scene = lf_test_scene(text);
    double *d = malloc(pixels * sizeof *d), *q = malloc(pixels * sizeof *q);
    for (int i = 0; i < 6; i++) {
        lf_renderer *r = lf_test_renderer(scene, integrators[i & 1], width, height, NULL);
        cycles(r);
        double *picture = lf_test_picture(r, (lf_estimator)(i / 2));
        lf_test_weights(r, false, d, q);
        for (int j = 0; j < pixels; j++) {
            lf_assert_close(picture[j], value, 1e-6, 0.0);
            assert_true(d[j] == 0.0 && q[j] == 0.0);
        }
        free(picture);
        lf_renderer_destroy(r);
    }
    free(d);
    free(q);
    lf_scene_unref(scene);
}

static void case_23_scenes_with_nothing_to_meet_show_their_background(void **state)
{
    (void)state;
    assert_flat("{" CAMERA "'render': {} }", 0.0);
    assert_flat("{" CAMERA "'lights': { 'sky': { 'type': 'environment', 'radiance': 0.7 } } }",
                0.7);
    assert_flat("{" CAMERA "'volumes': { 'none': { 'shape': 'box', 'density': 0 } }, "
                "'lights': { 'sky': { 'type': 'environment', 'radiance': 0.7 } } }",
                0.7);
    assert_flat("{" CAMERA "'volumes': { 'small': { 'shape': 'sphere', 'density': 1, "
                "'transform': { 'scale': 1e-9, 'translate': [0, 40, 0] } } }, "
                "'lights': { 'sky': { 'type': 'environment', 'radiance': 0.7 } } }",
                0.7);
}

/* Lights of no power: black, not NaN, whatever there is to be lit. */
static void case_23_black_lights_light_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks;
        pictures(lf_test_scene_text("black-lights"), i ? "mvpt" : "vpt", LF_ESTIMATOR_MWIS, 2, 0, 1,
                 &blocks);
        for (int j = 0; j < blocks.n; j++)
            assert_true(blocks.moments[j].mean == 0.0);
        lf_blocks_finish(&blocks);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(case_14_lobes_of_any_width),
        cmocka_unit_test(case_15_mirrors_share_nothing),
        cmocka_unit_test(case_22_channels_do_not_mix),
        cmocka_unit_test(case_23_scenes_with_nothing_to_meet_show_their_background),
        cmocka_unit_test(case_23_black_lights_light_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
