/* The sun that a mirror throws on a wall, held against straight lines from the wall to the mirrored
 * sun (tests/stat/mirror_sun.h), which share no code with render/. Only light paths find the small
 * suns: no path from the camera meets a sun without an angle, and few meet one of half a degree, or
 * a bright texel of a sky. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"
#include "tests/stat/mirror_sun.h"

enum { width = 24, height = 18, block = 6, n_views = 5, blocks_of_views = 12 * n_views + 1 };

static const char *const integrators[] = {"mvpt", "vpt"};

/* blocks of three suns and a sky with two integrators */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 4 * 2 * blocks_of_views)
/* in place of an angle: the sky */
#define SKY (-1.0)

/* What the wall, which is 5 away, shows: the sun, and share times what comes from the mirror. Edges
 * of a sun without an angle are sharp: more points, which cost little then. */
static double *truth_picture(const lf_renderer *r, double angle, double share)
{
    lf_mirror_sun sun = lf_mirror_sun_scene(angle);
    const lf_mirror_sky sky = lf_mirror_sky_scene();
    const bool in_sky = angle < 0.0;
    const double direct = in_sky ? lf_mirror_sky_direct(&sky) : lf_mirror_sun_direct(&sun);
    int side = angle != 0.0 ? 4 : 24;
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
                    const double x = b + 5.0 * mx, y = 5.0 * my;
                    sum += in_sky ? lf_mirror_sky_reflected(&sun, &sky, x, y)
                                  : lf_mirror_sun_reflected(&sun, x, y);
                }
                *p = LF_MIRROR_SUN_WALL / M_PI * (direct + share * sum / (side * side));
            }
        }
    }
    return out;
}

/* The scene with its sun in a sky picture. */
static lf_scene *load_sky(void)
{
    const lf_mirror_sky sky = lf_mirror_sky_scene();
    char *folder = lf_test_folder();
    FILE *file = fopen(lf_test_path(folder, "sky.hdr"), "wb");
    assert_non_null(file);
    fprintf(file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", sky.rows, 2 * sky.rows);
    for (int i = 0; i < 2 * sky.rows * sky.rows; i++) {
        const bool bright = i == 2 * sky.rows * sky.row + sky.column;
        /* radiance 3392 = 212 / 256 2^12 */
        const unsigned char texel[2][4] = {{0, 0, 0, 0}, {212, 212, 212, 140}};
        assert_int_equal(fwrite(texel[bright], 4, 1, file), 1);
    }
    assert_int_equal(fclose(file), 0);
    lf_scene *scene = lf_test_scene_in(
        folder,
        lf_test_scene_patched("sun-off-mirror", "{'lights': {'sun': null, 'sky': {'type': "
                                                "'environment', 'file': 'sky.hdr'}}}"),
        NULL);
    lf_test_folder_remove(folder);
    return scene;
}

static lf_scene *load(double angle)
{
    return angle < 0.0 ? load_sky()
                       : lf_test_scene(lf_test_scene_patched(
                             "sun-off-mirror", "{'lights': {'sun': {'angle': %.17g}}}", angle));
}

/* p of all blocks with a sun of this angle against share times what the mirror throws. */
static double p_of(double angle, const char *integrator, int cycles, double share, int *out_where,
                   lf_blocks *out)
{
    lf_scene *scene = load(angle);
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

static void a_mirror_throws_a_bright_texel_of_a_sky(void **state)
{
    (void)state;
    assert_sun(SKY, 24);
}

/* A mirror that throws a tenth more or less, or 15 % less of a sky. */
static void other_mirrors_are_rejected(void **state)
{
    (void)state;
    const double angle[3] = {0.0, 0.53, SKY}, share[3] = {0.9, 1.1, 0.85};
    for (int i = 0; i < 3; i++) {
        lf_blocks blocks;
        assert_true(p_of(angle[i], "mvpt", 32, share[i], NULL, &blocks) < 1e-6);
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
        cmocka_unit_test(a_mirror_throws_a_bright_texel_of_a_sky),
        cmocka_unit_test(other_mirrors_are_rejected),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
