#include "tests/testing.h"

#include "base/alloc.h"
#include "render/render.h"
#include "render/scene/grid.h"
#include "render/scene/scene.h"

static const int SIZE[3] = {19, 8, 16}; /* 8 and 16: voxels on the borders of bricks; 19: neither */

/* A value between 0 and 1 that changes from voxel to voxel; a third of them are 0. */
static float pattern(int x, int y, int z)
{
    unsigned h = ((unsigned)x * 73u ^ (unsigned)y * 19u ^ (unsigned)z * 83u) % 96u;
    return h < 32u ? 0.0f : (float)h / 96.0f;
}

static double voxel(int x, int y, int z)
{
    if (x < 0 || y < 0 || z < 0 || x >= SIZE[0] || y >= SIZE[1] || z >= SIZE[2])
        return 0.0;
    return (double)pattern(x, y, z);
}

/* Eight voxels, weighted, in double: the definition. */
static double trilinear(double x, double y, double z)
{
    int i = (int)floor(x), j = (int)floor(y), k = (int)floor(z);
    double sum = 0.0;
    for (int c = 0; c < 8; c++) {
        int dx = c & 1, dy = c >> 1 & 1, dz = c >> 2;
        double w =
            (dx ? x - i : 1 - (x - i)) * (dy ? y - j : 1 - (y - j)) * (dz ? z - k : 1 - (z - k));
        sum += w * voxel(i + dx, j + dy, k + dz);
    }
    return sum;
}

static lf_grid *make_grid(void)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {SIZE[0], SIZE[1], SIZE[2]};
    lf_grid *grid = NULL;
    lf_error err;
    lf_assert_ok(lf_grid_create(size, identity, &grid, &err), &err);
    for (int round = 0; round < 2; round++) {
        for (int z = 0; z < SIZE[2]; z++) {
            for (int y = 0; y < SIZE[1]; y++) {
                for (int x = 0; x < SIZE[0]; x++) {
                    const int at[3] = {x, y, z};
                    if (round == 0 && pattern(x, y, z) > 0.0f)
                        lf_grid_mark(grid, at, at);
                    if (round == 1 && pattern(x, y, z) > 0.0f)
                        lf_grid_fill(grid, at, at, pattern(x, y, z));
                }
            }
        }
        if (round == 0)
            lf_assert_ok(lf_grid_allocate(grid, &err), &err);
    }
    lf_grid_finish(grid);
    return grid;
}

static int set_up(void **state)
{
    *state = make_grid();
    return 0;
}

static int tear_down(void **state)
{
    lf_grid_unref(*state);
    return 0;
}

/* 0..1, the same numbers every time. */
static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

/* In the grid and beside it. */
static void random_point(uint64_t *seed, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)(-2.0 + uniform(seed) * (SIZE[i] + 3.0));
}

static void linear_look_ups_equal_eight_weighted_voxels(void **state)
{
    const lf_grid *grid = *state;
    uint64_t seed = 1;
    int above = 0;
    for (int n = 0; n < 200000; n++) {
        float p[3];
        random_point(&seed, p);
        float value = lf_grid_linear(grid, p[0], p[1], p[2]);
        lf_assert_close(value, trilinear((double)p[0], (double)p[1], (double)p[2]), 0, 1e-6);
        above += value > 0.0f;
    }
    assert_true(above > 100000);
}

static void linear_look_ups_hit_the_voxels_at_whole_numbers(void **state)
{
    const lf_grid *grid = *state;
    for (int z = -2; z <= SIZE[2] + 1; z++)
        for (int y = -2; y <= SIZE[1] + 1; y++)
            for (int x = -2; x <= SIZE[0] + 1; x++)
                assert_true((double)lf_grid_linear(grid, (float)x, (float)y, (float)z) ==
                            voxel(x, y, z));
}

static void look_ups_at_the_rim_and_outside_are_safe(void **state)
{
    const lf_grid *grid = *state;
    static const float far[] = {-1.0f, -1e30f, 1e30f, INFINITY, -INFINITY, NAN};
    for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
        assert_true(lf_grid_linear(grid, far[i], 3, 3) == 0.0f);
        assert_true(lf_grid_linear(grid, 3, far[i], 3) == 0.0f);
        assert_true(lf_grid_nearest(grid, 3, 3, far[i]) == 0.0f);
    }
    float last = (float)SIZE[0], before = nextafterf(last, 0.0f), first = nextafterf(-1.0f, 0.0f);
    assert_true(lf_grid_linear(grid, last, 3, 3) == 0.0f);
    assert_true(lf_grid_linear(grid, before, 3, 3) < 1e-4f);
    assert_true(lf_grid_linear(grid, first, 3, 3) < 1e-4f);
    assert_true(lf_grid_nearest(grid, nextafterf(last - 0.5f, 0.0f), 3, 3) ==
                (float)voxel(SIZE[0] - 1, 3, 3));
}

static void nearest_look_ups_return_the_voxel_they_are_in(void **state)
{
    const lf_grid *grid = *state;
    uint64_t seed = 2;
    for (int n = 0; n < 100000; n++) {
        float p[3];
        random_point(&seed, p);
        double expected =
            voxel((int)floorf(p[0] + 0.5f), (int)floorf(p[1] + 0.5f), (int)floorf(p[2] + 0.5f));
        assert_true((double)lf_grid_nearest(grid, p[0], p[1], p[2]) == expected);
    }
}

/* The brick that a point of volume space is in (render/scene/scene.h). */
static size_t brick_at(const lf_grid *grid, const float p[3])
{
    int b[3];
    for (int i = 0; i < 3; i++)
        b[i] = ((int)floorf(p[i]) + 1) / LF_BRICK;
    return ((size_t)b[2] * (size_t)grid->bricks[1] + (size_t)b[1]) * (size_t)grid->bricks[0] +
           (size_t)b[0];
}

static void no_look_up_exceeds_the_majorant_of_its_brick(void **state)
{
    const lf_grid *grid = *state;
    uint64_t seed = 3;
    int close = 0;
    for (int n = 0; n < 400000; n++) {
        float p[3];
        for (int i = 0; i < 3; i++) {
            /* Half of the points lie on or beside the borders of bricks. */
            double v = -1.0 + uniform(&seed) * (SIZE[i] + 1.0);
            p[i] = (float)(n & 1 ? v
                                 : fmin(round((v + 1) / 8) * 8 - 1 + (uniform(&seed) - 0.5) * 1e-3,
                                        SIZE[i] - 1e-3));
            p[i] = fmaxf(p[i], -0.9999f);
        }
        float max = grid->brick_max[brick_at(grid, p)],
              linear = lf_grid_linear(grid, p[0], p[1], p[2]);
        assert_true(linear <= max);
        assert_true(lf_grid_nearest(grid, p[0], p[1], p[2]) <= max);
        assert_true(max <= grid->max_value);
        close += linear > 0.7f * max;
    }
    assert_true(close > 100); /* the bound is not idle */
}

static void a_majorant_without_the_neighbours_would_be_exceeded(void **state)
{
    (void)state;
    /* Voxel 7 is value 8 of brick 0 and value 0 of brick 1: just before it, brick 0 is asked and
     * its own cells hold nothing. */
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {16, 1, 1};
    const int at[3] = {7, 0, 0};
    lf_grid *grid = NULL;
    lf_assert_ok(lf_grid_create(size, identity, &grid, NULL), NULL);
    lf_grid_mark(grid, at, at);
    lf_assert_ok(lf_grid_allocate(grid, NULL), NULL);
    lf_grid_fill(grid, at, at, 1.0f);
    lf_grid_finish(grid);
    assert_true(lf_grid_linear(grid, 6.99f, 0, 0) > 0.98f);
    assert_true(grid->brick_max[0] >= 1.0f);
    assert_true(grid->brick_max[1] >= 1.0f);
    assert_true(grid->brick_max[2] == 0.0f);
    lf_grid_unref(grid);
}

/* Of a few voxels far apart: what every brick has near it, by looking at each voxel. Voxel v is
 * value v + 1 of the bricks' common lattice. */
static void bricks_know_what_is_near(void **state)
{
    (void)state;
    enum { N = 40 };
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {70, 50, 41};
    int at[N][3], n_near = 0, n_empty = 0;
    float value[N];
    uint64_t seed = 11;
    lf_grid *grid = NULL;
    lf_assert_ok(lf_grid_create(size, identity, &grid, NULL), NULL);
    for (int n = 0; n < N; n++) {
        for (int i = 0; i < 3; i++)
            at[n][i] = (int)(uniform(&seed) * (double)size[i]);
        value[n] = (float)(n + 1);
        lf_grid_mark(grid, at[n], at[n]);
    }
    lf_assert_ok(lf_grid_allocate(grid, NULL), NULL);
    for (int n = 0; n < N; n++)
        lf_grid_fill(grid, at[n], at[n], value[n]);
    lf_grid_finish(grid);
    for (int b = 0; b < grid->bricks[0] * grid->bricks[1] * grid->bricks[2]; b++) {
        const int place[3] = {b % grid->bricks[0], b / grid->bricks[0] % grid->bricks[1],
                              b / grid->bricks[0] / grid->bricks[1]};
        float expected = 0.0f;
        for (int n = 0; n < N; n++) {
            bool near = true;
            for (int i = 0; i < 3; i++)
                near = near && at[n][i] + 1 >= LF_BRICK * place[i] - LF_BRICK_REACH &&
                       at[n][i] + 1 <= LF_BRICK * (place[i] + 1) + LF_BRICK_REACH;
            expected = near ? fmaxf(expected, value[n]) : expected;
        }
        assert_true(grid->brick_near[b] == expected);
        n_near += expected > 0.0f;
        n_empty += grid->index[b] == 0;
    }
    assert_in_range(n_near, 50, 300);
    assert_true(n_empty > 100);
    lf_grid_unref(grid);
}

static void boxes_fill_as_single_voxels_do(void **state)
{
    (void)state;
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {40, 33, 24};
    const int first[3] = {3, 0, 7}, last[3] = {30, 32, 16};
    lf_grid *grid = NULL;
    lf_assert_ok(lf_grid_create(size, identity, &grid, NULL), NULL);
    lf_grid_mark(grid, first, last);
    lf_assert_ok(lf_grid_allocate(grid, NULL), NULL);
    lf_grid_fill(grid, first, last, 0.5f);
    lf_grid_finish(grid);
    for (int z = -1; z <= 24; z++) {
        for (int y = -1; y <= 33; y++) {
            for (int x = -1; x <= 40; x++) {
                bool inside = x >= 3 && x <= 30 && y >= 0 && y <= 32 && z >= 7 && z <= 16;
                assert_true(lf_grid_linear(grid, (float)x, (float)y, (float)z) ==
                            (inside ? 0.5f : 0.0f));
            }
        }
    }
    lf_grid_unref(grid);
}

static void grids_beyond_the_limits_are_refused(void **state)
{
    (void)state;
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t none[3] = {0, 1, 1}, wide[3] = {LF_GRID_MAX_SIDE + 1, 1, 1},
                  big[3] = {LF_GRID_MAX_SIDE, LF_GRID_MAX_SIDE, 64};
    lf_grid *grid = NULL;
    lf_error err;
    lf_assert_status(lf_grid_create(none, identity, &grid, &err), LF_E_FORMAT, &err);
    lf_assert_status(lf_grid_create(wide, identity, &grid, &err), LF_E_FORMAT, &err);
    lf_assert_status(lf_grid_create(big, identity, &grid, &err), LF_E_NOMEM, &err);
    assert_null(grid);
}

/* -------------------------------------------------------------------------------- in a scene -- */

static lf_scene *scene_of(const char *json)
{
    json_error_t problem;
    json_t *doc = json_loads(json, 0, &problem);
    lf_scene *scene = NULL;
    lf_error err;
    assert_non_null(doc);
    lf_assert_ok(lf_scene_from_json(doc, ".", "test", NULL, NULL, &scene, &err), &err);
    json_decref(doc);
    return scene;
}

static void a_fog_ball_is_homogeneous_inside_its_ellipsoid(void **state)
{
    (void)state;
    lf_scene *scene =
        scene_of("{\"volumes\": {\"fog\": {\"shape\": \"sphere\", \"density\": 2.5, \"albedo\": "
                 "[0.1, 0.5, 1],"
                 "\"g\": -0.25, \"transform\": {\"scale\": [3, 1, 2], \"rotate\": [0, 90, 0]}}}}");
    const lf_volume *v = &scene->volumes[0];
    /* A quarter turn about y takes x to -z: half axes 2, 1, 3. */
    assert_true(lf_volume_sigma_t(v, lf_v3(0, 0, 2.99f)) == 2.5f);
    assert_true(lf_volume_sigma_t(v, lf_v3(1.99f, 0, 0)) == 2.5f);
    assert_true(lf_volume_sigma_t(v, lf_v3(2.01f, 0, 0)) == 0.0f);
    assert_true(lf_volume_sigma_t(v, lf_v3(0, 1.01f, 0)) == 0.0f);
    assert_true(lf_volume_sigma_t(v, lf_v3(1.5f, 0, 2.5f)) == 0.0f);
    assert_true(v->sigma_max == 2.5f && v->g == -0.25f);
    assert_true(v->albedo.x == 0.1f && v->albedo.y == 0.5f && v->albedo.z == 1.0f);
    lf_assert_close(v->bounds_max.x, 2, 1e-5, 0);
    lf_assert_close(v->bounds_max.y, 1, 1e-5, 0);
    lf_assert_close(v->bounds_min.z, -3, 1e-5, 0);
    assert_true(scene->has_view_lobes);
    lf_scene_unref(scene);
}

static void a_turned_fog_box_keeps_its_corners(void **state)
{
    (void)state;
    lf_scene *scene = scene_of(
        "{\"volumes\": {\"fog\": {\"shape\": \"box\", \"transform\": {\"rotate\": [0, 0, 45]}}}}");
    const lf_volume *v = &scene->volumes[0];
    assert_true(lf_volume_sigma_t(v, lf_v3(1.4f, 0, 0.99f)) == 1.0f);
    assert_true(lf_volume_sigma_t(v, lf_v3(0.9f, 0.9f, 0)) == 0.0f);
    lf_assert_close(v->bounds_max.x, sqrt(2.0), 1e-5, 0);
    lf_assert_close(v->bounds_max.z, 1, 1e-5, 0);
    assert_false(scene->has_view_lobes);
    lf_scene_unref(scene);
}

static void extinction_far_from_the_origin_is_exact(void **state)
{
    (void)state;
    lf_scene *scene = scene_of("{\"volumes\": {\"fog\": {\"shape\": \"box\","
                               "\"transform\": {\"translate\": [1000000.25, 0, -3000000]}}}}");
    const lf_volume *v = &scene->volumes[0];
    assert_true(scene->origin[0] == 1000000.0 && scene->origin[1] == 0.0 &&
                scene->origin[2] == -3000000.0);
    assert_true(lf_volume_sigma_t(v, lf_v3(1.2499f, 0, 0)) == 1.0f);
    assert_true(lf_volume_sigma_t(v, lf_v3(1.2501f, 0, 0)) == 0.0f);
    assert_true(lf_volume_sigma_t(v, lf_v3(-0.7499f, 0, 0)) == 1.0f);
    assert_true(lf_volume_sigma_t(v, lf_v3(-0.7501f, 0, 0)) == 0.0f);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_look_ups_equal_eight_weighted_voxels),
        cmocka_unit_test(linear_look_ups_hit_the_voxels_at_whole_numbers),
        cmocka_unit_test(look_ups_at_the_rim_and_outside_are_safe),
        cmocka_unit_test(nearest_look_ups_return_the_voxel_they_are_in),
        cmocka_unit_test(no_look_up_exceeds_the_majorant_of_its_brick),
        cmocka_unit_test(a_majorant_without_the_neighbours_would_be_exceeded),
        cmocka_unit_test(bricks_know_what_is_near),
        cmocka_unit_test(boxes_fill_as_single_voxels_do),
        cmocka_unit_test(grids_beyond_the_limits_are_refused),
        cmocka_unit_test(a_fog_ball_is_homogeneous_inside_its_ellipsoid),
        cmocka_unit_test(a_turned_fog_box_keeps_its_corners),
        cmocka_unit_test(extinction_far_from_the_origin_is_exact),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
