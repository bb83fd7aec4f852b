/* The sun that a mirror throws on a wall, held against straight lines from the wall to the mirrored
 * sun (tests/stat/mirror_sun.h), which share no code with render/. Only light paths find the small
 * suns: no path from the camera meets a sun without an angle, and few meet one of half a degree. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/mirror_sun.h"

enum { width = 24, height = 18, block = 6, n_views = 5, blocks_of_views = 12 * n_views + 1 };

static const char *const integrators[] = {"mvpt", "vpt"};

/* blocks of three suns with two integrators */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 3 * 2 * blocks_of_views)

/* What the wall, which is 5 away, shows: the sun, and share times what comes from the mirror. Edges
 * of a sun without an angle are sharp: more points, which cost little then. */
static double *truth_picture(const lf_renderer *r, double angle, double share)
{
    lf_mirror_sun sun = lf_mirror_sun_scene(angle);
    int side = angle > 0.0 ? 4 : 24;
    sun.rings = 6;
    double *out = malloc(sizeof *out * n_views * width * height), *p = out;
    for (int row = 0; row < height; row++) {
        for (int view = 0; view < n_views; view++) {
            for (int column = 0; column < width; column++, p++) {
                double sum = 0.0, b = (double)lf_test_rows(r)->rig.b[view];
                for (int i = 0; i < side * side; i++) {
                    double mx, my;
                    lf_test_slopes(r, view, column + (i % side + 0.5) / side,
                                   row + (i / side + 0.5) / side, &mx, &my);
                    sum += lf_mirror_sun_reflected(&sun, b + 5.0 * mx, 5.0 * my) / (side * side);
                }
                *p = LF_MIRROR_SUN_WALL / M_PI * (lf_mirror_sun_direct(&sun) + share * sum);
            }
        }
    }
    return out;
}

/* p of all blocks with a sun of this angle against share times what the mirror throws. */
static double p_of(double angle, const char *integrator, int cycles, double share, int *out_where,
                   lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(
        lf_test_scene_patched("sun-off-mirror", "{'lights': {'sun': {'angle': %.17g}}}", angle));
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    double *truth = truth_picture(r, angle, share);
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < 10; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    double p = lf_blocks_p(out, truth, 1e-3, out_where);
    free(truth);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return p;
}

static void assert_sun(double angle, int cycles)
{
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks;
        int where = 0;
        double p = p_of(angle, integrators[i], cycles, 1.0, &where, &blocks);
        if (!(p > LEVEL))
            fail_msg("%s: block %d is %.6g +- %.2g, p %.2g", integrators[i], where,
                     blocks.moments[where].mean, lf_moments_error(&blocks.moments[where]), p);
        lf_blocks_finish(&blocks);
    }
}

/* A sun so wide that paths from the camera find it, too. */
static void a_mirror_throws_a_wide_sun(void **state)
{
    (void)state;
    assert_sun(20.0, 16);
}

static void a_mirror_throws_a_sun_without_an_angle(void **state)
{
    (void)state;
    assert_sun(0.0, 4);
}

static void a_mirror_throws_a_sun_of_half_a_degree(void **state)
{
    (void)state;
    assert_sun(0.53, 24);
}

/* A mirror that throws a tenth more or less. */
static void other_mirrors_are_rejected(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        lf_blocks blocks;
        assert_true(p_of(i * 0.53, "mvpt", 32, 0.9 + 0.2 * i, NULL, &blocks) < 1e-6);
        lf_blocks_finish(&blocks);
    }
}

int main(void)
{
    lf_test_light_paths(LF_LIGHT_PATHS_AUTO);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mirror_throws_a_wide_sun),
        cmocka_unit_test(a_mirror_throws_a_sun_without_an_angle),
        cmocka_unit_test(a_mirror_throws_a_sun_of_half_a_degree),
        cmocka_unit_test(other_mirrors_are_rejected),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
