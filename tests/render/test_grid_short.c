/* Grids in 16 bits: every half is exact, what is rounded is as near as is said, and look-ups,
 * kernels and pictures are those of the same values as floats, bit by bit. */
#include "tests/testing.h"

#include <float.h>

#include "render/plane/kernel.h"
#include "tests/render/grids.h"
#include "tests/scene_file.h"
#include "tests/stat/uniform.h"

enum { SIDE = 32, HALVES = 0x7c00 }; /* finite halves that are not negative: SIDE^3 has room */

/* IEEE 754-2008's binary16, by its definition. */
static double half_value(int bits)
{
    int exponent = bits >> 10, mantissa = bits & 0x3ff;
    return exponent == 0 ? ldexp(mantissa, -24) : ldexp(1024 + mantissa, exponent - 25);
}

static float any_half(int x, int y, int z)
{
    int at = (z * SIDE + y) * SIDE + x;
    return at < HALVES ? (float)half_value(at) : 0.0f;
}

static float smoke(int x, int y, int z)
{
    return (float)half_value((int)(lf_hash64((uint64_t)(x + 64 * y), (uint64_t)z) % 0x3c00));
}

static float tenths(int x, int y, int z)
{
    return 0.1f * (float)((x + 3 * y + 7 * z) % 11) * powf(10.0f, -(float)z);
}

/* The same grid as floats, and in 16 bits. */
static void make_both(lf_voxel_fn voxel, int side, lf_grid *out[2])
{
    for (int i = 0; i < 2; i++)
        out[i] = lf_test_grid(voxel, side, side, side);
    lf_grid_shorten(out[1], false);
    assert_true(out[0]->values && !out[0]->shorts && !out[1]->values && out[1]->shorts);
}

static void every_half_is_exact(void **state)
{
    (void)state;
    lf_grid *grid[2];
    make_both(any_half, SIDE, grid);
    for (int i = 0; i < HALVES; i++)
        assert_true((double)lf_grid_nearest(grid[1], (float)(i % SIDE), (float)(i / SIDE % SIDE),
                                            (float)(i / SIDE / SIDE)) == half_value(i));
    assert_true(grid[0]->max_value == grid[1]->max_value);
    lf_grid_unref(grid[0]);
    lf_grid_unref(grid[1]);
}

static void look_ups_are_those_of_floats(void **state)
{
    (void)state;
    lf_grid *grid[2];
    uint64_t seed = 5;
    enum { N = 16 };
    make_both(smoke, 20, grid);
    for (int trial = 0; trial < 5000; trial++) {
        float at[3], x[N], value[2][N];
        lf_line line;
        for (int i = 0; i < 3; i++) {
            at[i] = 24.0f * lf_test_uniform(&seed) - 2.0f;
            line.origin[i] = 20.0f * lf_test_uniform(&seed);
            line.across[i] = 20.0f * lf_test_uniform(&seed) - 10.0f;
        }
        assert_true(lf_grid_linear(grid[0], at[0], at[1], at[2]) ==
                    lf_grid_linear(grid[1], at[0], at[1], at[2]));
        for (int k = 0; k < N; k++)
            x[k] = 2.0f * lf_test_uniform(&seed) - 1.0f;
        for (int i = 0; lf_kernels_at(i); i++) {
            for (int j = 0; j < 2; j++) {
                lf_volume volume = {.kind = LF_VOLUME_GRID, .grid = grid[j], .sigma_scale = 3.0f};
                lf_kernels_at(i)->sample(&volume, &line, N, x, value[j]);
            }
            assert_memory_equal(value[0], value[1], sizeof value[0]);
        }
    }
    lf_grid_unref(grid[0]);
    lf_grid_unref(grid[1]);
}

/* What is no half stays what it is unless it may be rounded. */
static void what_is_rounded_is_near(void **state)
{
    (void)state;
    static const float scales[] = {1.0f, 1e-30f, 1e15f};
    lf_grid *exact = lf_test_grid(tenths, 12, 12, 24);
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++) {
        lf_grid *grid = lf_test_grid(tenths, 12, 12, 24);
        size_t n = ((size_t)grid->n_bricks + 1) * LF_BRICK_STRIDE;
        for (size_t i = 0; i < n; i++)
            grid->values[i] *= scales[s];
        lf_grid_finish(grid);
        lf_grid_shorten(grid, false);
        assert_true(grid->values && !grid->shorts);
        lf_grid_shorten(grid, true);
        assert_true(!grid->values && grid->shorts);
        for (size_t i = 0; i < n; i++) {
            double is = (double)lf_grid_stored(grid, i),
                   was = (double)(exact->values[i] * scales[s]);
            assert_true(fabs(is - was) <= was * 0x1p-11 ||
                        (is == 0 && was < fmax((double)scales[s] * 0x1p-62, (double)FLT_MIN)));
            assert_true(is <= (double)grid->max_value);
        }
        lf_grid_unref(grid);
    }
    exact->values[LF_BRICK_STRIDE] = FLT_MAX; /* there is no room for its exponent */
    lf_grid_shorten(exact, true);
    assert_true(exact->values && !exact->shorts);
    lf_grid_unref(exact);
}

/* Suffixes go one by one. */
static double *picture(lf_grid *grid, const char *integrator, bool nearest)
{
    lf_scene *scene = lf_test_grid_scene(lf_test_scene_text("voxels-in-sun"), lf_grid_ref(grid),
                                         0.08, 0.4, 6.0f, nearest);
    lf_renderer *r = lf_test_renderer(scene, integrator, 24, 18, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.skip = LF_SKIP_ALL & ~LF_SKIP_PATHS;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_test_reseed(r, 3);
    lf_test_cycles(r, 2);
    double *out = lf_test_picture(r, LF_ESTIMATOR_MWIS);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return out;
}

/* By single paths: lanes read floats as shares of bricks' largest (test_suffix). */
static void pictures_are_those_of_floats(void **state)
{
    (void)state;
    lf_grid *grid[2];
    make_both(smoke, 20, grid);
    for (int i = 0; i < 4; i++) {
        double *one = picture(grid[0], i & 1 ? "vpt" : "mvpt", i & 2),
               *other = picture(grid[1], i & 1 ? "vpt" : "mvpt", i & 2);
        assert_memory_equal(one, other, sizeof *one * 5 * 24 * 18);
        assert_true(one[2 * 24 * 5 * 4 + 12] > 0);
        free(one);
        free(other);
    }
    lf_grid_unref(grid[0]);
    lf_grid_unref(grid[1]);
}

/* Files: what is saved as halves is kept so; others are where the scene says it. */
static void scenes_choose_the_precision(void **state)
{
    (void)state;
    static const struct {
        const char *file, *more;
        bool is_short;
    } cases[] = {{"patterns.vdb", ", 'grid': 'half'", true},
                 {"level_set.vdb", "", false},
                 {"level_set.vdb", ", 'precision': 'half'", true}};
    char folder[PATH_MAX];
    lf_scene *last = NULL;
    assert_non_null(realpath(lf_test_built("testdata"), folder));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "{ 'volumes': { 'v': { 'file': '%s'%s } }, 'lights': { 'sky': { 'type': "
                 "'environment', 'radiance': 1 } } }",
                 cases[i].file, cases[i].more);
        lf_scene *scene = lf_test_scene_in(folder, text, last);
        assert_int_equal(!scene->volumes[0].grid->values, cases[i].is_short);
        lf_scene_unref(last);
        last = scene;
    }
    lf_scene_unref(last);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_half_is_exact),
        cmocka_unit_test(look_ups_are_those_of_floats),
        cmocka_unit_test(what_is_rounded_is_near),
        cmocka_unit_test(pictures_are_those_of_floats),
        cmocka_unit_test(scenes_choose_the_precision),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
