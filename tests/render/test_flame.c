/* Volumes that emit, against pictures that are known: shapes that glow and absorb, in vacuum,
 * behind what absorbs, and before a surface; grids of a known integral; furnaces in which emission
 * makes up for what is absorbed, so that everything is 1; the light that falls on a wall. By both
 * integrators and every answer; replicates are seeds, and blocks of 8 x 8 pixels are compared by
 * Student's t. Negative controls: emission that is 1 % off is rejected, wherever a test is
 * statistical. */
#include "tests/testing.h"

#include "render/transport/flame.h"
#include "tests/render/grids.h"

enum { width = 32, height = 24, n_views = 5, block = 8 };

#define CAMERA(more)                                                                               \
    "'quiltd': 1, 'camera': { 'position': [0, 0, 5], 'fov_y': 24, 'aspect': 1.3333333333, "        \
    "'views': 5, 'cone': 30" more " }"
#define LENS ", 'lens_radius': 0.2, 'focus_distance': 4.5"

static const lf_estimator estimators[] = {LF_ESTIMATOR_MWIS, LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};
static const char *const integrators[] = {"mvpt", "vpt"};

/* Blocks that are compared in all, at most. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 3 * 2 * 61 * 16)

/* Truth along the pinhole ray of these slopes; x0: where its camera stands along X. */
typedef double (*truth_fn)(double x0, double mx, double my);

/* Means over pixels, by points of a grid. */
static double *truth_picture(const lf_renderer *r, truth_fn truth)
{
    enum { side = 8 };
    const lf_rig *rig = &lf_test_rows(r)->rig;
    double *out = malloc(sizeof *out * n_views * width * height), *p = out;
    for (int row = 0; row < height; row++) {
        for (int view = 0; view < n_views; view++) {
            for (int column = 0; column < width; column++, p++) {
                *p = 0.0;
                for (int i = 0; i < side * side; i++) {
                    double mx, my;
                    lf_test_slopes(r, view, column + (i % side + 0.5) / side,
                                   row + (i / side + 0.5) / side, &mx, &my);
                    *p += truth((double)rig->b[view], mx, my) / (side * side);
                }
            }
        }
    }
    return out;
}

/* The least p of all integrators and answers. */
static double least_p(lf_scene *scene, truth_fn truth, int passes, int replicates, double rounding,
                      double factor)
{
    double least = 2.0;
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, integrators[i], width, height, NULL);
        double *expected = truth_picture(r, truth);
        for (int j = 0; j < n_views * width * height; j++)
            expected[j] *= factor;
        for (int e = 0; e < 3; e++) {
            lf_blocks blocks;
            int where = 0;
            lf_blocks_init(&blocks, n_views, width, height, block);
            for (int k = 0; k < replicates; k++) {
                lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
                lf_test_passes(r, passes);
                lf_blocks_add_picture(&blocks, r, estimators[e]);
            }
            double p = lf_blocks_p(&blocks, expected, rounding, &where);
            if (!(p > LEVEL) && factor == 1.0)
                print_message("%s %s: block %d is %.6g +- %.2g\n", integrators[i],
                              lf_estimator_name(estimators[e]), where, blocks.moments[where].mean,
                              lf_moments_error(&blocks.moments[where]));
            least = fmin(least, p);
            lf_blocks_finish(&blocks);
        }
        free(expected);
        lf_renderer_destroy(r);
    }
    return least;
}

/* Takes the scene. The truth holds, and one that is 1 % off does not. */
static void assert_scene(lf_scene *scene, truth_fn truth, int passes, int replicates,
                         double rounding)
{
    double p = least_p(scene, truth, passes, replicates, rounding, 1.0);
    if (!(p > LEVEL))
        fail_msg("p %.2g", p);
    assert_true(least_p(scene, truth, passes, replicates, rounding, 1.01) < LEVEL);
    lf_scene_unref(scene);
}

static void assert_known(const char *text, truth_fn truth, int passes, int replicates,
                         double rounding)
{
    assert_scene(lf_test_scene(text), truth, passes, replicates, rounding);
}

/* ------------------------------------------------------------------------------------ shapes -- */

#define SLAB(density, albedo, more)                                                                \
    "'slab': { 'shape': 'box', 'density': " density ", 'albedo': " albedo ", "                     \
    "'emission': [2, 2, 2], 'transform': { 'scale': [60, 60, 0.5] }" more " }"

static double length_of(double mx, double my)
{
    return sqrt(1.0 + mx * mx + my * my);
}

/* The slab is 1 thick and faces the cameras. */
static double slab(double x0, double mx, double my)
{
    (void)x0;
    return 2.0 / 1.5 * (1.0 - exp(-1.5 * length_of(mx, my)));
}

static double slab_in_vacuum(double x0, double mx, double my)
{
    (void)x0;
    return 2.0 * length_of(mx, my);
}

static void a_slab_that_absorbs_and_emits_is_its_closed_form(void **state)
{
    (void)state;
    assert_known("{" CAMERA("") ", 'volumes': {" SLAB("1.5", "0", "") "} }", slab, 5, 4, 1e-4);
    assert_known("{" CAMERA("") ", 'volumes': {" SLAB("0", "1", "") "} }", slab_in_vacuum, 5, 4,
                 1e-4);
}

/* A lens changes the slopes of a pixel's rays, not their mean. */
static void a_slab_is_its_closed_form_through_a_lens(void **state)
{
    (void)state;
    assert_known("{" CAMERA(LENS) ", 'volumes': {" SLAB("0", "1", "") "} }", slab_in_vacuum, 5, 24,
                 1e-3);
}

/* The chord of the unit ball, 5 before the middle camera. */
static double chord(double x0, double mx, double my)
{
    double a = 1.0 + mx * mx + my * my, b = x0 * mx - 5.0, c = x0 * x0 + 24.0, d = b * b - a * c;
    return d > 0.0 ? 2.0 * sqrt(d / a) : 0.0;
}

static double ball(double x0, double mx, double my)
{
    return 2.0 / 3.0 * (1.0 - exp(-3.0 * chord(x0, mx, my)));
}

static void a_ball_that_absorbs_and_emits_is_its_closed_form(void **state)
{
    (void)state;
    assert_known("{" CAMERA("") ", 'volumes': { 'ball': { 'shape': 'sphere', 'density': 3, "
                                "'albedo': 0, 'emission': 2 } } }",
                 ball, 15, 32, 2e-3);
    assert_known("{" CAMERA("") ", 'volumes': { 'ball': { 'shape': 'sphere', 'density': 0, "
                                "'emission': 1 } } }",
                 chord, 15, 32, 2e-3);
}

/* Another slab, of half the depth, in the front half of the first and before it. */
static double slab_behind_smoke(double x0, double mx, double my)
{
    (void)x0;
    double s = length_of(mx, my), front = exp(-0.25 * s),
           both = 2.0 / 2.5 * (1.0 - exp(-2.5 * 0.5 * s)),
           rest = exp(-2.5 * 0.5 * s) * 2.0 / 1.5 * (1.0 - exp(-1.5 * 0.5 * s));
    return front * (both + rest);
}

static void a_slab_that_reaches_into_smoke_is_its_closed_form(void **state)
{
    (void)state;
    assert_known(
        "{" CAMERA("") ", 'volumes': {" SLAB(
            "1.5", "0",
            "") ", 'smoke': { 'shape': 'box', "
                "'density': 1, 'albedo': 0, 'transform': { 'scale': [60, 60, 0.375], 'translate': "
                "[0, 0, 0.375] } } } }",
        slab_behind_smoke, 5, 32, 1e-4);
}

/* A black wall in the middle of the slab. */
static double half_a_slab(double x0, double mx, double my)
{
    (void)x0;
    return 2.0 / 1.5 * (1.0 - exp(-1.5 * 0.5 * length_of(mx, my)));
}

static void a_surface_hides_what_is_behind_it(void **state)
{
    (void)state;
    assert_known(
        "{" CAMERA("") ", 'volumes': {" SLAB(
            "1.5", "0",
            "") "}, 'meshes': { 'wall': { "
                "'shape': 'quad', 'material': 'black', 'transform': { 'scale': 60, 'rotate': [90, "
                "0, 0] } } }, 'materials': { 'black': { 'albedo': 0 } } }",
        half_a_slab, 5, 4, 1e-4);
}

/* ------------------------------------------------------------------------------------- paths -- */

/* Emission (1 - albedo) sigma: in a white furnace every radiance is 1. */
static double one(double x0, double mx, double my)
{
    (void)x0, (void)mx, (void)my;
    return 1.0;
}

#define FURNACE(lens, g)                                                                           \
    "{" CAMERA(                                                                                    \
        lens) ", 'volumes': { 'fog': { 'shape': 'sphere', 'density': 3, 'albedo': 0.6, "           \
              "'g': " g                                                                            \
              ", 'emission': 1.2 } }, 'meshes': { 'ground': { 'shape': 'quad', 'material': "       \
              "'white', 'transform': { 'scale': 3, 'translate': [0, -0.7, 0] } } }, 'materials': " \
              "{ 'white': "                                                                        \
              "{ 'albedo': 1 } }, 'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } } }"

static void emission_makes_up_for_absorption_in_a_furnace(void **state)
{
    (void)state;
    assert_known(FURNACE("", "0"), one, 15, 32, 1e-4);
    assert_known(FURNACE(LENS, "0.6"), one, 15, 32, 1e-4);
}

/* A wall of albedo 1/2 behind the cameras' black window sees a slab in vacuum on all its other
 * side: the mean of 1 / cos over a cosine lobe is 2. */
static double wall(double x0, double mx, double my)
{
    (void)x0;
    return length_of(mx, my) + 0.5 * 2.0;
}

static void a_wall_is_lit_by_what_emits_in_vacuum_before_it(void **state)
{
    (void)state;
    assert_known(
        "{" CAMERA(
            "") ", 'volumes': { 'slab': { 'shape': 'box', 'density': 0, "
                "'emission': 1, 'transform': { 'scale': [6e4, 6e4, 0.5] } } }, 'meshes': { 'wall': "
                "{ "
                "'shape': 'quad', 'transform': { 'scale': 60, 'rotate': [90, 0, 0], 'translate': "
                "[0, 0, -1] } } } }",
        wall, 15, 48, 1e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slab_that_absorbs_and_emits_is_its_closed_form),
        cmocka_unit_test(a_slab_is_its_closed_form_through_a_lens),
        cmocka_unit_test(a_ball_that_absorbs_and_emits_is_its_closed_form),
        cmocka_unit_test(a_slab_that_reaches_into_smoke_is_its_closed_form),
        cmocka_unit_test(a_surface_hides_what_is_behind_it),
        cmocka_unit_test(emission_makes_up_for_absorption_in_a_furnace),
        cmocka_unit_test(a_wall_is_lit_by_what_emits_in_vacuum_before_it),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
