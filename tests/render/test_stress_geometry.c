/* Stress cases of the rig and of surfaces (docs/developer/test-cases.md, "Stress cases"): grazing
 * planes, edges of frames and media, contact, scenes far away, tiny and huge, wide rigs, lenses,
 * mirrored scenes; and what the weights hold to whatever the scene. Numbers of the cases are those
 * of the list there. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 16, height = 12, views = 5, pixels = views * width * height };

/* Comparisons that may fail by chance: blocks of 4 x 4 of some 40 runs. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 40 * (views * 12 + 1))

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 6);
}

/* Few base views in each pass, collisions forced. */
static void live(lf_renderer *r)
{
    for (int i = 0; i < 8; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 1 + i % 2, NULL, NULL, NULL), LF_OK);
}

static void assert_weights(const char *text)
{
    lf_test_assert_weights(text, width, height, cycles, 16, 4, LEVEL);
    lf_test_assert_weights(text, width, height, live, 16, 4, LEVEL);
}

static lf_moments *whole(lf_blocks *blocks)
{
    return &blocks->moments[blocks->n - 1];
}

/* Pictures of a scene by mis. */
static void pictures(const char *text, const char *integrator, int replicates, uint64_t salt,
                     lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_render_stats stats;
    lf_test_pictures(r, cycles, LF_ESTIMATOR_MIS, replicates, salt, 4, out);
    lf_renderer_stats(r, &stats);
    assert_true(stats.nonfinite_dropped == 0);
    /* Occlusion rays that deny the base its own pivot. */
    assert_true((double)stats.base_hidden <= 1e-4 * (double)stats.contributions);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Two pictures that are one; a difference of 2 % of the whole would be seen. */
static void assert_same(lf_blocks *a, lf_blocks *b)
{
    int where = 0;
    double p = lf_blocks_welch(a, b, &where);
    if (!(p > LEVEL))
        fail_msg("block %d: %.6g +- %.2g and %.6g +- %.2g, p %.2g", where, a->moments[where].mean,
                 lf_moments_error(&a->moments[where]), b->moments[where].mean,
                 lf_moments_error(&b->moments[where]), p);
    assert_true(whole(a)->mean > 0.0);
    assert_true(lf_blocks_welch_injected(a, b, a->n - 1, 1.02) < LEVEL);
    lf_blocks_finish(a);
    lf_blocks_finish(b);
}

/* -------------------------------------------------------------------------------- invariants -- */

/* Every base ray finds the card and the weights of a pivot sum to 1 over the views that see it: the
 * film holds as many as there were base paths. */
static void invariant_1_weights_of_a_pivot_sum_to_one(void **state)
{
    (void)state;
    double *d = malloc(pixels * sizeof *d), *q = malloc(pixels * sizeof *q), sum = 0.0;
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "bare-camera", "{'meshes': {'card': {'shape': 'quad', "
                       "'transform': {'scale': 20, 'rotate': [70, 10, 20]}}}}"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_render_stats stats;
    cycles(r);
    lf_test_weights(r, false, d, q);
    lf_renderer_stats(r, &stats);
    for (int i = 0; i < pixels; i++)
        sum += (d[i] + q[i]) * stats.native_spp_mean;
    lf_assert_close(sum, (double)stats.base_paths, 1e-6, 0.0);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    free(q);
    free(d);
}

/* A point of view k's film (u, v) at distance r from the camera, by the rig's formulas. */
static void point_of(const lf_rig *rig, int k, double u, double v, double r, double p[3])
{
    double mx = ((double)rig->x0 + u * (double)rig->dx - (double)rig->b[k]) / (double)rig->distance;
    double my = ((double)rig->y0 + v * (double)rig->dy) / (double)rig->distance,
           z = r / sqrt(1.0 + mx * mx + my * my);
    p[0] = (double)rig->b[k] + mx * z;
    p[1] = my * z;
    p[2] = z;
}

/* And back. */
static void film_of(const lf_rig *rig, int k, const double p[3], double film[3])
{
    double x = p[0] - (double)rig->b[k];
    film[0] =
        ((double)rig->b[k] + (double)rig->distance * x / p[2] - (double)rig->x0) / (double)rig->dx;
    film[1] = ((double)rig->distance * p[1] / p[2] - (double)rig->y0) / (double)rig->dy;
    film[2] = sqrt(x * x + p[1] * p[1] + p[2] * p[2]);
}

/* |d(u, v, r)_j / d(u, v, r)_i| by central differences. */
static double jacobian(const lf_rig *rig, int i, int j, const double at[3])
{
    double m[3][3];
    for (int c = 0; c < 3; c++) {
        double lo[3], hi[3], p[3], step = 1e-5, x[3] = {at[0], at[1], at[2]};
        x[c] = at[c] - step;
        point_of(rig, i, x[0], x[1], x[2], p);
        film_of(rig, j, p, lo);
        x[c] = at[c] + step;
        point_of(rig, i, x[0], x[1], x[2], p);
        film_of(rig, j, p, hi);
        for (int k = 0; k < 3; k++)
            m[k][c] = (hi[k] - lo[k]) / (2.0 * step);
    }
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* The map of one view's samples to another's is inverted by the map back, its Jacobians multiply as
 * they should, and they are h_j / h_i: the density of a pivot under view k goes as r_k. */
static void invariant_3_maps_between_views_invert_and_their_jacobians_are_ratios_of_h(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("bare-camera"));
    lf_renderer *renderer = lf_test_renderer(scene, "mvpt", width, height, NULL);
    const lf_rig *rig = &lf_test_rows(renderer)->rig;
    for (int n = 0; n < 50; n++) {
        double at[3] = {2.0 + 0.23 * n, 1.0 + 0.19 * n, 3.0 + 0.11 * n}, p[3], back[3], there[3],
               h[5], j0[5];
        for (int k = 0; k < views; k++) {
            point_of(rig, 1, at[0], at[1], at[2], p);
            film_of(rig, k, p, there);
            h[k] = there[2];
            j0[k] = jacobian(rig, 1, k, at);
            lf_assert_close(j0[k] * jacobian(rig, k, 1, there), 1.0, 1e-5, 0.0);
            point_of(rig, k, there[0], there[1], there[2], p);
            film_of(rig, 1, p, back);
            for (int c = 0; c < 3; c++)
                lf_assert_close(back[c], at[c], 1e-9, 1e-9);
        }
        for (int k = 0; k < views; k++)
            lf_assert_close(j0[k], h[k] / h[1], 1e-5, 0.0);
    }
    lf_renderer_destroy(renderer);
    lf_scene_unref(scene);
}

/* -------------------------------------------------------------------------- planes and edges -- */

/* A wall in the plane of the middle camera: seen from the left by the views to its left, edge on by
 * the middle one, from the right by the others. */
static void case_07_a_plane_that_turns_its_back_inside_the_rig(void **state)
{
    (void)state;
    assert_weights(lf_test_scene_text("wall-in-the-middle"));
}

/* A blade of fog, thin and deep, turned so that some views look along it and others across. */
static void case_11_the_edge_of_a_slab_that_some_views_miss(void **state)
{
    (void)state;
    assert_weights(lf_test_scene_text("fog-blade"));
}

/* fog-on-ground, s times as large and moved along x. */
static const char *contact(double s, double by)
{
    return lf_test_scene_patched(
        "fog-on-ground",
        "{'camera': {'target': [%.9g, 0, 0], 'position': [%.9g, %.9g, %.9g]}, "
        "'volumes': {'fog': {'density': %.9g, 'transform': {'scale': [%.9g, %.9g, %.9g], "
        "'translate': [%.9g, %.9g, 0]}}}, 'meshes': {'ground': {'transform': {'scale': %.9g, "
        "'translate': [%.9g, %.9g, 0]}}, 'ball': {'transform': {'scale': %.9g, "
        "'translate': [%.9g, %.9g, 0]}}}}",
        by, by, 0.6 * s, 5.0 * s, 2.0 / s, 0.9 * s, 0.4 * s, 0.6 * s, by + 0.2 * s, -0.6 * s,
        4.0 * s, by, -1.0 * s, 0.6 * s, by - 0.3 * s, -0.5 * s);
}

static void assert_same_at(double scale, double by)
{
    lf_blocks a, b;
    pictures(contact(1.0, 0.0), "mvpt", 24, 0, &a);
    pictures(contact(scale, by), "mvpt", 24, 700, &b);
    assert_same(&a, &b);
}

static void case_12_contact_and_scenes_far_from_the_origin(void **state)
{
    (void)state;
    assert_weights(contact(1.0, 0.0));
    assert_same_at(1.0, 12345.678);
    assert_same_at(1.0, 1e6 + 0.3);
}

static void case_12_scenes_of_a_ten_thousandth_and_of_a_hundred_thousand(void **state)
{
    (void)state;
    assert_same_at(1e-4, 0.0);
    assert_same_at(1e5, 0.0);
    assert_same_at(1e-4, 1e3);
}

/* --------------------------------------------------------------------------------- the frame -- */

/* Cards whose disparity from view to view is a whole number of pixels, one of them 0, and the ends
 * of the rig look at the very edges: each contribution lands in exactly one pixel, also in the
 * first and last columns. */
static void case_16_whole_disparities_at_the_edges_of_the_frame(void **state)
{
    (void)state;
    /* Window 2 wide and 1.5 high at distance 5, 16 pixels: dx = 0.125. b = 5 tan(a): disparity of Z
     * = 10 is (b_k+1 - b_k) / 2, 2 pixels when the rig is 0.5 a step; cone 2 atan(1/5). */
    const char *scene = lf_test_scene_text("whole-disparities");
    lf_test_assert_weights(scene, width, height, cycles, 24, 1, LEVEL);
    lf_test_assert_weights(scene, width, height, live, 24, 1, LEVEL);
}

/* Outermost and middle views of a wide rig. */
static void case_17_a_rig_of_60_degrees(void **state)
{
    (void)state;
    lf_blocks native, shared;
    assert_weights(lf_test_scene_text("wide-rig"));
    pictures(lf_test_scene_text("wide-rig"), "vpt", 32, 0, &native);
    pictures(lf_test_scene_text("wide-rig"), "mvpt", 32, 700, &shared);
    assert_same(&native, &shared);
}

/* As much light through any part of the disk: the mean of y^2 is a quarter of the radius', and a
 * chord at y is as long as it is. */
static void case_18_a_lens_is_open_evenly(void **state)
{
    (void)state;
    enum { n = 64 };
    const lf_rig rig = {.distance = 5.0f, .focus = 4.0f, .lens_radius = 0.3f};
    double y2 = 0.0, x2 = 0.0;
    for (int i = 0; i < n * n; i++) {
        const float u[2] = {((float)(i % n) + 0.5f) / n, ((float)(i / n) + 0.5f) / n};
        lf_row_plane plane;
        lf_rig_row_plane(&rig, 0.0f, u, &plane);
        y2 += (double)(plane.ly * plane.ly) / (n * n);
        /* x is even on the chord */
        x2 += (double)(plane.lens_chord * plane.lens_chord) / (3.0 * n * n);
        lf_assert_close((double)plane.my, -(double)plane.ly / 4.0, 1e-6, 0.0);
    }
    lf_assert_close(y2, 0.25 * 0.09, 1e-3, 0.0);
    lf_assert_close(x2, 0.25 * 0.09, 1e-3, 0.0);
}

static void case_18_lenses_from_nothing_to_large(void **state)
{
    (void)state;
    double *pinhole, *none;
    static const char *const radii[] = {"1e-6", "0.02", "0.5"};
    for (int i = 0; i < 3; i++) {
        assert_weights(lf_test_scene_patched(
            "fogs", "{'camera': {'lens_radius': %s, 'focus_distance': 4.5}}", radii[i]));
    }
    /* Radius 0 is a pinhole bit for bit, wherever its focus. */
    for (int i = 0; i < 2; i++) {
        lf_scene *scene = lf_test_scene(
            i ? lf_test_scene_patched("fogs", "{'camera': {'lens_radius': 0, 'focus_distance': 3}}")
              : lf_test_scene_views("fogs", 5));
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        cycles(r);
        *(i ? &none : &pinhole) = lf_test_picture(r, LF_ESTIMATOR_CV);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    assert_memory_equal(pinhole, none, pixels * sizeof *pinhole);
    free(pinhole);
    free(none);
}

/* ---------------------------------------------------------------------------------- symmetry -- */

#define MIRRORED                                                                                   \
    "{'volumes': {'fog': {'transform': {'rotate': [0, -20, 0], 'translate': [-0.4, 0, 0.8]}}}, "   \
    "'meshes': {'ball': {'transform': {'translate': [0.7, -0.3, 0.6]}}}, "                         \
    "'lights': {'sun': {'direction': [-0.5, -0.7, -0.5]}}}"

static void case_24_a_mirrored_scene_gives_mirrored_views(void **state)
{
    (void)state;
    lf_blocks a, b;
    pictures(lf_test_scene_text("lopsided"), "mvpt", 32, 0, &a);
    pictures(lf_test_scene_patched("lopsided", MIRRORED), "mvpt", 32, 700, &b);
    assert_true(lf_blocks_welch(&a, &b, NULL) < 1e-9); /* which they are not unmirrored */
    lf_blocks_mirror(&b);
    assert_same(&a, &b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(invariant_1_weights_of_a_pivot_sum_to_one),
        cmocka_unit_test(invariant_3_maps_between_views_invert_and_their_jacobians_are_ratios_of_h),
        cmocka_unit_test(case_07_a_plane_that_turns_its_back_inside_the_rig),
        cmocka_unit_test(case_11_the_edge_of_a_slab_that_some_views_miss),
        cmocka_unit_test(case_12_contact_and_scenes_far_from_the_origin),
        cmocka_unit_test(case_12_scenes_of_a_ten_thousandth_and_of_a_hundred_thousand),
        cmocka_unit_test(case_16_whole_disparities_at_the_edges_of_the_frame),
        cmocka_unit_test(case_17_a_rig_of_60_degrees),
        cmocka_unit_test(case_18_a_lens_is_open_evenly),
        cmocka_unit_test(case_18_lenses_from_nothing_to_large),
        cmocka_unit_test(case_24_a_mirrored_scene_gives_mirrored_views),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
