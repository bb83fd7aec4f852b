/* Stress cases of the media (docs/developer/test-cases.md, "Stress cases"): from a millionth to ten
 * thousand mean free paths, furnaces, contrast, tight majorants, cameras inside. Numbers of the
 * cases are those of the list there. */
#include "tests/testing.h"

#include "tests/render/grids.h"
#include "tests/scene_file.h"

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

enum { width = 16, height = 12, views = 5, pixels = views * width * height };

/* Comparisons that may fail by chance: blocks of 4 x 4 of some 30 runs. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 30 * (views * 12 + 1))

#define CAMERA                                                                                     \
    "'quiltd': 1, 'camera': { 'position': [0, 0, 5], 'fov_y': 12, 'aspect': 1.3333333333, "        \
    "'views': 5, 'cone': 20 }, "
#define WHITE_SKY "'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }"

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

static void one_cycle(lf_renderer *r)
{
    lf_test_cycles(r, 1);
}

/* Forced collisions: thin media give every ray a pivot. */
static void forced(lf_renderer *r)
{
    for (int i = 0; i < 2 * views; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 2, NULL, NULL, NULL), LF_OK);
}

/* ---------------------------------------------------------------------------------- furnaces -- */

#define BALL(density, albedo, g)                                                                   \
    "{" CAMERA "'volumes': { 'fog': { 'shape': 'sphere', 'density': " density                      \
    ", 'albedo': " albedo ", 'g': " g " } }, "                                                     \
    "'render': { 'max_depth': 65536 }, " WHITE_SKY "}"

/* Means over a set of replicates by cv in a white furnace, p and error of the whole picture left to
 * the caller. */
static void furnace(const char *text, int w, int h, lf_test_schedule schedule, int replicates,
                    int block, lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", w, h, NULL);
    lf_render_stats stats;
    lf_test_pictures(r, schedule, LF_ESTIMATOR_CV, replicates, 0, block, out);
    lf_renderer_stats(r, &stats);
    assert_true(stats.nonfinite_dropped == 0);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Smallest p over all blocks of "all is 1". */
static double p_of_white(const lf_blocks *blocks, double rounding, int *out_where)
{
    int n = blocks->n_views * blocks->width * blocks->height;
    double *one = malloc((size_t)n * sizeof *one);
    for (int i = 0; i < n; i++)
        one[i] = 1.0;
    double p = lf_blocks_p(blocks, one, rounding, out_where);
    free(one);
    return p;
}

/* A ball of 1000 mean free paths that fills the picture, g = 0.9: paths of 700 collisions in the
 * mean, of 10^5 now and then. Every pixel of every view is 1 within what Sidak allows at 1e-3, and
 * so is the whole, known to better than a thousandth. */
static void case_01_a_furnace_of_1000_mean_free_paths_and_g_of_0_9_is_white(void **state)
{
    (void)state;
    lf_blocks blocks;
    int where = 0;
    furnace(BALL("500", "1", "0.9"), width, height, cycles, lf_test_long() ? 48 : 8, 1, &blocks);
    const lf_moments *whole = &blocks.moments[blocks.n - 1];
    /* cv knows most pixels to 4e-8, and sums of single precision are 7e-7 off */
    const double rounding = 1e-5;
    double p = p_of_white(&blocks, rounding, &where), error = lf_moments_error(whole);
    print_message("mean %.6f +- %.6f, smallest p of %d pixels %.2g\n", whole->mean, error,
                  blocks.n - 1, p);
    assert_true(p > lf_sidak(1e-3, blocks.n));
    assert_true(error < 1e-3);
    assert_true(fabs(whole->mean - 1.0) < 3.0 * error + rounding);
    lf_blocks_finish(&blocks);
}

/* Isotropic: N/W is a mean of ones wherever anything arrived. At 10^4 mean free paths a few paths
 * reach the limit of 65536 vertices (a random walk of n steps is still inside with probability near
 * n^-1/2): darker by at most that. */
static void case_01_furnaces_of_any_density_are_white(void **state)
{
    (void)state;
    static const char *const density[] = {"5e-7", "5e-4", "0.5", "50", "5000"};
    for (int i = 0; i < 5; i++) {
        char text[512];
        lf_blocks blocks;
        int where = 0;
        snprintf(text, sizeof text, BALL("%s", "1", "0"), density[i]);
        furnace(text, 8, 6,
                i < 2    ? forced
                : i == 4 ? one_cycle
                         : cycles,
                i == 4 ? 2 : 12, 2, &blocks);
        double mean = blocks.moments[blocks.n - 1].mean;
        print_message("density %s: mean %.7f\n", density[i], mean);
        if (i < 4)
            assert_true(p_of_white(&blocks, 1e-5, &where) > LEVEL);
        else
            assert_true(mean > 1.0 - 1.0 / 64.0 && mean < 1.0 + 1e-5);
        lf_blocks_finish(&blocks);
    }
}

/* The bigger the albedo the brighter, always below 1; and what is symmetric looks so from view k
 * and view N + 1 - k. */
static void case_02_grey_furnaces_are_darker_and_symmetric(void **state)
{
    (void)state;
    static const char *const albedo[] = {"0", "0.3", "0.7", "0.95", "1"};
    double last = -1.0;
    for (int i = 0; i < 5; i++) {
        char text[512];
        lf_blocks a, b;
        snprintf(text, sizeof text, BALL("4", "%s", "0.3"), albedo[i]);
        furnace(text, width, height, cycles, 12, 4, &a);
        const lf_moments whole = a.moments[a.n - 1];
        assert_true(whole.mean > last + 6.0 * lf_moments_error(&whole));
        assert_true(whole.mean < 1.0 + (i == 4 ? 1e-4 : -1e-2));
        last = whole.mean;
        if (i == 2) {
            lf_scene *scene = lf_test_scene(text);
            lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
            lf_test_pictures(r, cycles, LF_ESTIMATOR_CV, 12, 500, 4, &b);
            lf_blocks_mirror(&b);
            assert_true(lf_blocks_welch(&a, &b, NULL) > LEVEL);
            lf_blocks_finish(&b);
            lf_renderer_destroy(r);
            lf_scene_unref(scene);
        }
        lf_blocks_finish(&a);
    }
}

/* ------------------------------------------------------------------------- optical thickness -- */

/* A black slab in front of a wall that emits. */
static const char *before_a_wall(const char *density)
{
    return lf_test_scene_patched("slab-before-wall", "{'volumes': {'slab': {'density': %s}}}",
                                 density);
}

static const char *const thickness[] = {"1e-6", "1e-3", "1", "50", "100", "1e3", "1e4"};
enum { thicknesses = 7 };

/* exp(-tau l) with l between the shortest and the longest way of a pixel's rays. */
static void assert_transmitted(const lf_renderer *r, double tau)
{
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS);
    for (int i = 0; i < pixels; i++) {
        int column = i % width, view = i / width % views, row = i / width / views;
        double shortest = INFINITY, longest = 0.0;
        for (int j = 0; j < 9; j++) {
            double mx, my;
            lf_test_slopes(r, view, column + 0.5 * (j % 3), row + 0.5 * (j / 3), &mx, &my);
            double length = sqrt(1.0 + mx * mx + my * my);
            shortest = fmin(shortest, length);
            longest = fmax(longest, length);
        }
        /* Depths carry a relative error of 2^-21 or so, which exp turns into tau 2^-21. */
        double rounding = 1e-6 + 1e-6 * tau;
        if (!(picture[i] >= exp(-tau * longest) * (1.0 - rounding) - 1e-37 &&
              picture[i] <= exp(-tau * shortest) * (1.0 + rounding)))
            fail_msg("tau %g: pixel %d is %.9g, not between %.9g and %.9g", tau, i, picture[i],
                     exp(-tau * longest), exp(-tau * shortest));
    }
    free(picture);
}

static void case_04_slabs_of_a_millionth_to_ten_thousand_let_their_share_through(void **state)
{
    (void)state;
    for (int i = 0; i < thicknesses; i++) {
        lf_scene *scene = lf_test_scene(before_a_wall(thickness[i]));
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        cycles(r);
        assert_transmitted(r, atof(thickness[i]));
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

static void case_04_weights_are_n_q_at_any_thickness(void **state)
{
    (void)state;
    for (int i = 0; i < thicknesses; i++) {
        lf_test_assert_weights(before_a_wall(thickness[i]), width, height,
                               atof(thickness[i]) < 1.0 ? forced : cycles, 16, 4, LEVEL);
    }
}

#if defined(__SSE__)
/* With denormals flushed to zero the picture is the same to 1e-6. */
static void case_04_denormals_do_not_matter(void **state)
{
    (void)state;
    double *picture[2];
    lf_scene *scene = lf_test_scene(before_a_wall("88"));
    for (int flush = 0; flush < 2; flush++) {
        unsigned mode = _mm_getcsr();
        lf_pool *pool = NULL;
        _mm_setcsr(flush ? mode | 0x8040u : mode); /* inherited by the pool's threads */
        lf_assert_ok(lf_pool_create(2, &pool), NULL);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, pool);
        cycles(r);
        picture[flush] = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        lf_renderer_destroy(r);
        lf_pool_destroy(pool);
        _mm_setcsr(mode);
    }
    for (int i = 0; i < pixels; i++)
        assert_true(fabs(picture[0][i] - picture[1][i]) <= 1e-6);
    free(picture[0]);
    free(picture[1]);
    lf_scene_unref(scene);
}
#endif

/* The shipped cloud, its own shapes resampled on slices. */
static void case_04_weights_are_n_q_in_grids_of_any_density(void **state)
{
    (void)state;
    static const char *const scale[] = {"1e-5", "1", "1e3", "1e5"};
    for (int i = 0; i < 4; i++) {
        const char *text = lf_test_scene_patched(
            "dense-cloud", "{'volumes': {'cloud': {'file': '%s', 'scale': %s}}}",
            lf_test_built("../scenes/cloud.vdb"), scale[i]);
        /* A visit of the densest cuts as many cells as 40 of the others: its rows are three times
         * as high. */
        lf_test_assert_weights(text, width, i == 3 ? 2 : 6, i == 0 ? forced : cycles, 8, 2, LEVEL);
    }
}

/* ------------------------------------------------------------------------------ the trackers -- */

static float checkerboard(int x, int y, int z)
{
    return (x + y + z) & 1 ? 100.0f : 0.0f;
}

enum { side = 20 };

static void make_volume(lf_voxel_fn voxel, float scale, bool nearest, lf_volume *volume)
{
    lf_grid *grid = lf_test_grid(voxel, side, side, side);
    *volume =
        (lf_volume){.kind = LF_VOLUME_GRID, .grid = grid, .nearest = nearest, .sigma_scale = scale};
    volume->sigma_max = scale * grid->max_value;
    for (int i = 0; i < 3; i++)
        volume->to_volume[i][i] = volume->to_scene[i][i] = 1.0f;
}

/* Optical depth up to t by many small steps. */
static double depth(const lf_volume *volume, lf_vec3 o, lf_vec3 w, double t)
{
    const int steps = 20000;
    double sum = 0.0;
    for (int i = 0; i < steps; i++) {
        lf_vec3 p = lf_madd(o, (float)(t * (i + 0.5) / steps), w);
        sum += (double)(volume->nearest ? lf_grid_nearest(volume->grid, p.x, p.y, p.z)
                                        : lf_grid_linear(volume->grid, p.x, p.y, p.z));
    }
    return sum * (double)volume->sigma_scale * t / steps;
}

/* Collisions before t as often as the depth says, and the transmittance up to t in the mean exp of
 * minus it. */
static void assert_tracked(lf_volume *volume, lf_vec3 o, lf_vec3 w, float t)
{
    enum { n = 40000 };
    lf_scene scene = {.n_volumes = 1, .volumes = volume};
    lf_tracer tracer = {.scene = &scene, .rng = lf_hash64(lf_test_seed(), 9)};
    double expected = exp(-depth(volume, o, w, (double)t));
    lf_moments through = {0}, transmitted = {0};
    for (int i = 0; i < n; i++) {
        int which;
        lf_moments_add(&through, lf_track_collision(&tracer, o, w, t, &which) < t ? 0.0 : 1.0);
        lf_moments_add(&transmitted, (double)lf_track_transmittance(&tracer, o, w, t));
    }
    if (!(lf_p_mean(&through, expected) > LEVEL && lf_p_mean(&transmitted, expected) > LEVEL))
        fail_msg("t %g: %.6g +- %.2g pass, transmittance %.6g +- %.2g, not %.6g", (double)t,
                 through.mean, lf_moments_error(&through), transmitted.mean,
                 lf_moments_error(&transmitted), expected);
}

static void case_09_trackers_are_right_in_a_checkerboard_of_0_and_100(void **state)
{
    (void)state;
    lf_vec3 o = lf_v3(3.3f, 4.1f, 2.6f), w = lf_normalize(lf_v3(0.31f, 0.2f, 1.0f));
    for (int nearest = 0; nearest < 2; nearest++) {
        lf_volume volume;
        make_volume(checkerboard, 1.0f, nearest, &volume);
        for (float t = 0.02f; t < 0.1f; t *= 1.5f)
            assert_tracked(&volume, o, w, t);
        /* Thin enough to see the other side of many voxels. */
        volume.sigma_scale = volume.sigma_max = 1e-3f;
        volume.sigma_max *= 100.0f;
        assert_tracked(&volume, lf_v3(-3.0f, 7.5f, 6.2f), lf_normalize(lf_v3(1.0f, 0.13f, 0.21f)),
                       30.0f);
        lf_grid_unref(volume.grid);
    }
}

/* Nothing is null here: the density is the majorant, up to the rim. */
static void case_10_a_majorant_that_is_the_density_leaves_no_gap(void **state)
{
    (void)state;
    lf_volume volume;
    make_volume(lf_test_full, 0.05f, false, &volume);
    for (float t = 2.0f; t < 20.0f; t += 5.0f)
        assert_tracked(&volume, lf_v3(1.5f, 9.0f, 9.0f), lf_v3(1.0f, 0.0f, 0.0f), t);
    assert_tracked(&volume, lf_v3(0.0f, 0.0f, 0.0f), lf_v3(0.0f, -0.0f, 1.0f), 19.0f);
    lf_grid_unref(volume.grid);
}

/* ---------------------------------------------------------------------------- cameras inside -- */

#define INSIDE(density, g)                                                                         \
    "{" CAMERA "'volumes': { 'fog': { 'shape': 'sphere', 'density': " density                      \
    ", 'albedo': 0.8, 'g': " g ", "                                                                \
    "'transform': { 'scale': 9 } } }, 'render': { 'max_depth': 8 }, " WHITE_SKY "}"

static void case_13_cameras_inside_a_medium_share_what_they_see(void **state)
{
    (void)state;
    lf_test_assert_weights(INSIDE("0.5", "0.6"), width, height, cycles, 16, 4, LEVEL);
    lf_test_assert_weights(INSIDE("0.05", "0"), width, height, forced, 16, 4, LEVEL);
    /* Pivots a ten thousandth before the camera: no other view has them in its frame, W is n where
     * it is anything. */
    lf_test_assert_weights(INSIDE("1e4", "0.6"), width, height, cycles, 16, 4, LEVEL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(case_01_a_furnace_of_1000_mean_free_paths_and_g_of_0_9_is_white),
        cmocka_unit_test(case_01_furnaces_of_any_density_are_white),
        cmocka_unit_test(case_02_grey_furnaces_are_darker_and_symmetric),
        cmocka_unit_test(case_04_slabs_of_a_millionth_to_ten_thousand_let_their_share_through),
        cmocka_unit_test(case_04_weights_are_n_q_at_any_thickness),
#if defined(__SSE__)
        cmocka_unit_test(case_04_denormals_do_not_matter),
#endif
        cmocka_unit_test(case_04_weights_are_n_q_in_grids_of_any_density),
        cmocka_unit_test(case_09_trackers_are_right_in_a_checkerboard_of_0_and_100),
        cmocka_unit_test(case_10_a_majorant_that_is_the_density_leaves_no_gap),
        cmocka_unit_test(case_13_cameras_inside_a_medium_share_what_they_see),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
