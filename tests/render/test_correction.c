/* What is drawn from slices counts for the grids themselves (docs/developer/estimators/grids.md,
 * "The weight"): single scattering in closed form where slices are worst, transmittance by brute
 * force, and the same with the correction pulled out. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/plane/correction.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { VIEWS = 5, SIDE = 12, REPLICATES = 12 };

/* The tests of this program that may fail by chance. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 16)

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 32);
}

/* ------------------------------------------------------------------------- single scattering -- */

enum { THICK = 8, WIDE = 128 };
static const double voxel = 0.02;

/* A slab with edges of one voxel, its normal turned by tilt against the view, under a sun at cosine
 * mu0. */
static lf_scene *slab_scene(double mfp_a_voxel, double tilt, double mu0, bool nearest)
{
    double turn = tilt + acos(mu0); /* of the direction to the sun against the view, about y */
    const char *text = lf_test_scene_patched(
        "thin-slab", "{'lights': {'sun': {'direction': [%.9f, 0, %.9f]}}}", -sin(turn), -cos(turn));
    return lf_test_grid_scene(text, lf_test_grid(lf_test_full, WIDE, 16, THICK), voxel, tilt,
                              (float)(mfp_a_voxel / voxel), nearest);
}

/* Its mean over replicates. */
static lf_moments lit_slab(const char *integrator, double mfp_a_voxel, double tilt, double mu0,
                           bool nearest, unsigned faults)
{
    lf_blocks blocks;
    lf_scene *scene = slab_scene(mfp_a_voxel, tilt, mu0, nearest);
    lf_renderer *r = lf_test_renderer(scene, integrator, SIDE, SIDE, NULL);
    r->faults = faults;
    lf_test_pictures(r, cycles, LF_ESTIMATOR_MIS, REPLICATES, 0, SIDE, &blocks);
    lf_moments whole = blocks.moments[blocks.n - 1];
    lf_blocks_finish(&blocks);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return whole;
}

/* E / (4 pi) m0 / (m0 + mv) (1 - exp(-tau (1/m0 + 1/mv))), whatever the profile (Chandrasekhar
 * 1950). */
static double slab_truth(double mfp_a_voxel, double tilt, double mu0)
{
    double mv = cos(tilt), tau = THICK * mfp_a_voxel;
    return 10.0 / (4.0 * M_PI) * mu0 / (mu0 + mv) * -expm1(-tau * (1.0 / mu0 + 1.0 / mv));
}

static void edges_of_one_voxel_scatter_what_a_grazing_sun_gives_them(void **state)
{
    (void)state;
    static const struct {
        const char *integrator;
        double mfp, tilt, mu0;
        bool nearest;
    } cases[] = {
        {"mvpt", 1.0, 0.0, 0.2, false},  {"mvpt", 2.0, 0.35, 0.3, false},
        {"vpt", 2.0, 0.2, 0.2, false},   {"mvpt", 1.0, 0.0, 0.2, true},
        {"mvpt", 8.0, 0.35, 0.3, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double truth = slab_truth(cases[i].mfp, cases[i].tilt, cases[i].mu0);
        lf_moments m = lit_slab(cases[i].integrator, cases[i].mfp, cases[i].tilt, cases[i].mu0,
                                cases[i].nearest, 0);
        lf_moments wrong = lit_slab(cases[i].integrator, cases[i].mfp, cases[i].tilt, cases[i].mu0,
                                    cases[i].nearest, LF_FAULT_NO_CORRECTION);
        double p = lf_p_mean(&m, truth);
        print_message("case %d: %.4f +- %.4f of the truth, p %.2g; uncorrected %.4f\n", (int)i,
                      m.mean / truth, lf_moments_error(&m) / truth, p, wrong.mean / truth);
        assert_true(p > LEVEL);
        assert_true(lf_moments_error(&m) < 0.006 * truth);
        if (cases[i].nearest)
            assert_true(wrong.mean == m.mean); /* there is nothing to correct */
        else
            assert_true(lf_p_mean(&wrong, truth) < 1e-6);
    }
}

/* ----------------------------------------------------------------------------- transmittance -- */

/* The field by definition, in double. */
static double field(const lf_volume *v, double x, double y, double z)
{
    double p[3], sum = 0.0;
    int c[3];
    for (int i = 0; i < 3; i++) {
        p[i] = (double)v->to_volume[i][0] * x + (double)v->to_volume[i][1] * y +
               (double)v->to_volume[i][2] * z + (double)v->to_volume[i][3];
        c[i] = (int)floor(v->nearest ? p[i] + 0.5 : p[i]);
    }
    for (int n = 0; n < 8; n++) {
        double weight = v->nearest ? n == 0 : 1.0;
        int at[3];
        bool inside = true;
        for (int i = 0; i < 3; i++) {
            int up = n >> i & 1;
            at[i] = c[i] + up;
            inside = inside && at[i] >= 0 && at[i] < v->grid->size[i];
            weight *= v->nearest ? 1.0 : up ? p[i] - c[i] : 1.0 - (p[i] - c[i]);
        }
        if (inside && weight > 0.0)
            sum += weight * (double)lf_test_rough(at[0], at[1], at[2]);
    }
    return (double)v->sigma_scale * sum;
}

/* Mean transmittance of the picture, by rays in a lattice over the pixels and steps of a tenth of a
 * voxel. */
static double brute_force(const lf_renderer *r, const lf_volume *v)
{
    enum { RAYS = 48, STEPS = 400 };
    double sum = 0.0, reach = (double)v->bounds_max.x;
    for (int n = 0; n < RAYS * RAYS; n++) {
        double mx, my, tau = 0.0, step = 2.0 * reach / STEPS;
        lf_test_slopes(r, 0, SIDE * (n % RAYS + 0.5) / RAYS, SIDE * (n / RAYS + 0.5) / RAYS, &mx,
                       &my);
        for (int i = 0; i < STEPS; i++) {
            double depth = 5.0 - reach + (i + 0.5) * step;
            tau += step * field(v, mx * depth, my * depth, 5.0 - depth);
        }
        sum += exp(-tau * sqrt(1.0 + mx * mx + my * my));
    }
    return sum / (RAYS * RAYS);
}

static void what_comes_through_rough_voxels_is_what_brute_force_says(void **state)
{
    (void)state;
    for (int nearest = 0; nearest < 2; nearest++) {
        lf_blocks blocks[2];
        lf_scene *scene = lf_test_grid_scene(
            "{ 'camera': { 'position': [0, 0, 5], 'fov_y': 2.2, 'aspect': 1, 'cone': 0, 'views': 5 "
            "}, " LF_TEST_VOLUMES(
                "") ", 'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } } }",
            lf_test_grid(lf_test_rough, 14, 14, 14), 0.02, 0.5, 40.0f, nearest);
        scene->volumes[0].albedo = lf_v3(0.0f, 0.0f, 0.0f);
        lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
        double truth = brute_force(r, &scene->volumes[0]);
        for (int wrong = 0; wrong < 2; wrong++) {
            r->faults = wrong ? LF_FAULT_NO_CORRECTION : 0;
            lf_test_pictures(r, cycles, LF_ESTIMATOR_MIS, REPLICATES, 0, SIDE, &blocks[wrong]);
        }
        const lf_moments *m = &blocks[0].moments[blocks[0].n - 1],
                         *w = &blocks[1].moments[blocks[1].n - 1];
        print_message("%s: %.5f +- %.5f for %.5f, uncorrected %.5f\n",
                      nearest ? "nearest" : "linear", m->mean, lf_moments_error(m), truth, w->mean);
        assert_true(fabs(m->mean - truth) < 4.0 * lf_moments_error(m) + 2e-4);
        assert_true(lf_moments_error(m) < 1e-3);
        if (nearest)
            assert_true(w->mean == m->mean);
        else
            assert_true(fabs(w->mean - truth) > 4.0 * lf_moments_error(w) + 2e-4);
        for (int i = 0; i < 2; i++)
            lf_blocks_finish(&blocks[i]);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

/* Correction weights have both signs. Where they cancel in a pixel's W, behind few visits, N/W must
 * not be a spark, and a negative W is no hole: sparks were 250 times as bright as anything is. */
static void weights_that_cancel_leave_no_sparks(void **state)
{
    (void)state;
    const double tilt = 0.35, mu0 = 0.3;
    lf_scene *scene = slab_scene(1.0, tilt, mu0, false);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    for (uint64_t seed = 0; seed < 24; seed++) {
        lf_test_reseed(r, seed);
        lf_test_passes(r, 3);
        lf_assert_ok(lf_renderer_fill_holes(r, NULL, NULL), NULL);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        for (int k = 0; k < VIEWS * SIDE * SIDE; k++)
            if (!(fabs(picture[k]) < 16.0 * slab_truth(1.0, tilt, mu0)))
                fail_msg("seed %d, pixel %d: %g", (int)seed, k, picture[k]);
        free(picture);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* T / T~ times T~ of one ray in a row's plane, over many draws (the same in every run), beside T by
 * steps of 1/200 of a voxel. */
static lf_moments oblique(lf_media *media, const lf_renderer *r, const lf_row_plane *plane,
                          float x0, float slope, double *out_truth)
{
    enum { DRAWS = 4000 };
    float x[LF_LANES], s[LF_LANES], end[LF_LANES], tau[LF_LANES];
    lf_tracer tracer = {.scene = &lf_test_rows(r)->seen, .rng = 12345};
    lf_moments m = {0};
    double depth = 0.0, step = 1e-4,
           length =
               sqrt(1.0 + (double)slope * (double)slope + (double)plane->my * (double)plane->my);
    for (int k = 0; k < LF_LANES; k++) {
        x[k] = x0;
        s[k] = slope;
        end[k] = 100.0f;
    }
    const lf_rays rays = {.scene = &lf_test_rows(r)->seen,
                          .rig = &lf_test_rows(r)->rig,
                          .plane = plane,
                          .kernels = lf_kernels_get(),
                          .n = LF_LANES,
                          .x0 = x,
                          .slope = s,
                          .z_end = end};
    lf_media_depths(media, &rays, tau, -1, NULL);
    for (double z = 0.5 * step; z < 3.0; z += step) {
        lf_vec3 at = lf_rig_point(&lf_test_rows(r)->rig, x0 + slope * (float)z,
                                  plane->ly + plane->my * (float)z, (float)z);
        depth += step * (double)lf_volume_sigma_t(&lf_test_rows(r)->seen.volumes[0], at);
    }
    *out_truth = exp(-depth * length);
    for (int i = 0; i < DRAWS; i++) {
        float factor[LF_LANES];
        for (int k = 0; k < LF_LANES; k++)
            factor[k] = 1.0f;
        lf_correction_transmittance(media, &rays, LF_CORRECTION_PIVOT, 0.0f, &tracer, factor);
        lf_moments_add(&m, exp(-(double)tau[0] * length) * (double)factor[0]);
    }
    return m;
}

/* Slices know rays from their planes, between which a steep one crosses many cells: the density of
 * points must be that of all of them. Rays at 45 to 79 degrees clip an edge of one voxel: 4000
 * draws know each to 2 %, and were known to 38 % where points were as dense as for straight ones.
 */
static void what_comes_along_oblique_rays_is_right_and_quiet(void **state)
{
    (void)state;
    static lf_media media;
    int64_t lookups = 0;
    double worst = 0.0;
    lf_scene *scene = lf_test_grid_scene(
        "{ 'camera': { 'position': [-1, 0, 1], 'target': [-1, 0, 0], 'fov_y': 158, 'aspect': 1, "
        "'cone': 0, 'views': 5 }, " LF_TEST_VOLUMES("") ", 'lights': {} }",
        lf_test_grid(lf_test_full, 64, 16, 64), 0.02, 0.0, 50.0f, false);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    lf_assert_ok(lf_media_init(&media, &lf_test_rows(r)->frame), NULL);
    for (int i = 0; i < 24; i++) {
        const float lens[2] = {0.5f, 0.5f};
        lf_row_plane plane;
        lf_rig_row_plane(&lf_test_rows(r)->rig, 0.5f * SIDE, lens, &plane);
        const lf_media_plane at = {.rig = &lf_test_rows(r)->rig,
                                   .plane = &plane,
                                   .kernels = lf_kernels_get(),
                                   .phase = {(float)(i % 5) / 5.0f, (float)(i % 7) / 7.0f}};
        lf_media_cut(&media, &lf_test_rows(r)->frame, lf_test_rows(r)->seen.volumes, &at, &lookups);
        /* Through the edge of the box at X = 1.64, Z = 0.36. */
        float slope = 1.0f + 0.17f * (float)i, x = 1.58f + 0.002f * (float)i;
        double truth;
        lf_moments m = oblique(&media, r, &plane, x - slope * 0.37f, slope, &truth);
        double noise = lf_moments_error(&m) / truth;
        print_message("slope %.2f: %.5f +- %.5f of the truth %.4g\n", (double)slope, m.mean / truth,
                      noise, truth);
        worst = truth > 1e-3 && noise > worst ? noise : worst;
        assert_true(truth < 1e-3 ||
                    fabs(m.mean - truth) < 5.0 * lf_moments_error(&m) + 2e-3 * truth);
    }
    print_message("worst relative error of a mean %.4f\n", worst);
    assert_true(worst < 0.03);
    lf_media_finish(&media);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* What collides just before one camera of a rig inside a grid is far to the side for the others. */
static void a_rig_inside_a_grid_comes_to_an_end(void **state)
{
    (void)state;
    const char *text =
        "{ 'quiltd': 1, 'camera': { 'position': [0, 0, 1], 'fov_y': 24, 'cone': 40, 'views': 9 }, "
        "'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }, 'volumes': { 'v': { "
        "'shape': 'box', 'density': 1, 'albedo': 0 } } }";
    lf_scene *scene =
        lf_test_grid_scene(text, lf_test_grid(lf_test_rough, 60, 20, 60), 0.1, 0.2, 100.0f, false);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", 120, 12, NULL);
    lf_render_stats stats;
    lf_test_passes(r, 9);
    lf_renderer_stats(r, &stats);
    printf("%.0f look-ups a base path\n", (double)stats.volume_lookups / (double)stats.base_paths);
    assert_true(stats.volume_lookups < 20000 * stats.base_paths);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Of B and q: never fewer than four times a pivot's, never more than were measured to be of use,
 * and always these where a fit keeps what they say. */
static void points_of_exits_grow_with_the_paths_of_a_visit(void **state)
{
    (void)state;
    static const float few[] = {0.02f, 1.0f, 4.0f, 16.0f}, more[] = {17.0f, 20.0f, 32.0f};
    for (int i = 0; i < 4; i++)
        assert_true(lf_correction_exit_density(few[i], false) == 8.0f);
    for (int i = 0; i < 3; i++)
        assert_true(lf_correction_exit_density(more[i], false) == 0.5f * more[i]);
    assert_true(lf_correction_exit_density(45.0f, false) == 16.0f);
    assert_true(lf_correction_exit_density(1.0f, true) == 16.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_of_one_voxel_scatter_what_a_grazing_sun_gives_them),
        cmocka_unit_test(weights_that_cancel_leave_no_sparks),
        cmocka_unit_test(what_comes_through_rough_voxels_is_what_brute_force_says),
        cmocka_unit_test(a_rig_inside_a_grid_comes_to_an_end),
        cmocka_unit_test(what_comes_along_oblique_rays_is_right_and_quiet),
        cmocka_unit_test(points_of_exits_grow_with_the_paths_of_a_visit),
    };
    return cmocka_run_group_tests_name("correction", tests, NULL, lf_test_finish);
}
