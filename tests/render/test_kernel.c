/* Every instruction set's kernels equal the plain C ones bit for bit, and those equal what they
 * stand for. */
#include "tests/testing.h"

#include "render/scene/grid.h"
#include "tests/render/fans.h"

static void every_instruction_set_equals_plain_c_bit_for_bit(void **state)
{
    (void)state;
    uint64_t seed = 7;
    lf_slice slice;
    assert_true(make_slice(&slice, 11));
    /* planes that stand partly behind the cameras */
    for (int i = 0; i < NZ; i += 3)
        slice.behind[i] = lf_test_uniform(&seed);
    for (int i = 1; lf_kernels_at(i); i++) {
        for (int trial = 0; trial < 500; trial++) {
            lf_fan fan;
            float tau[2][LANES], sigma[2][LANES], d[2][LANES], scale[LANES];
            bool pivot = trial % 2 == 0;
            make_fan(&fan, pivot, &seed);
            const lf_kernels *k[2] = {lf_kernels_at(0), lf_kernels_at(i)};
            for (int j = 0; j < 2; j++) {
                memset(tau[j], 0, sizeof tau[j]);
                k[j]->march(&slice, LANES, fan.x0, fan.slope, fan.z_end, tau[j],
                            pivot ? sigma[j] : NULL);
                for (int l = 0; l < LANES; l++)
                    scale[l] = l % 6 == 5 ? 0.0f : 1.0f + (float)l;
            }
            assert_memory_equal(tau[0], tau[1], sizeof tau[0]);
            if (pivot)
                assert_memory_equal(sigma[0], sigma[1], sizeof sigma[0]);
            float a = k[0]->densities(LANES, scale, tau[0], d[0]),
                  b = k[1]->densities(LANES, scale, tau[1], d[1]);
            assert_memory_equal(&a, &b, sizeof a);
            assert_memory_equal(d[0], d[1], sizeof d[0]);
        }
    }
    lf_slice_finish(&slice);
}

/* Moments beside depths, which stay those of march. */
static void moments_are_the_same_in_every_instruction_set(void **state)
{
    (void)state;
    uint64_t seed = 41;
    int met = 0;
    lf_slice slice;
    assert_true(make_slice(&slice, 13));
    for (int i = 0; i < NZ; i += 3)
        slice.behind[i] = lf_test_uniform(&seed);
    for (int trial = 0; trial < 500; trial++) {
        lf_fan fan;
        lf_body body = make_body(&seed);
        float length[LANES], plain[2][LANES] = {{0}}, tau[2][2][LANES], out[2][2][3][LANES];
        memset(tau, 0, sizeof tau);
        make_fan(&fan, trial % 2 == 0, &seed);
        for (int k = 0; k < LANES; k++)
            length[k] = sqrtf(1.2f + fan.slope[k] * fan.slope[k]);
        const lf_feature_rays rays = {LANES, fan.x0, fan.slope, fan.z_end, length, 4.0f};
        lf_kernels_c.march(&slice, LANES, fan.x0, fan.slope, fan.z_end, plain[0], NULL);
        lf_kernels_c.through(&body, LANES, fan.x0, fan.slope, fan.z_end, plain[1]);
        for (int i = 0; lf_kernels_at(i); i++) {
            int j = i > 0;
            float *const sums[3] = {out[j][0][0], out[j][0][1], out[j][0][2]};
            memset(tau[j], 0, sizeof tau[j]);
            lf_kernels_at(i)->moments(&slice, &rays, tau[j][0], sums);
            lf_kernels_at(i)->within(&body, &rays, tau[j][1],
                                     (float *const[]){out[j][1][0], out[j][1][1], out[j][1][2]});
            assert_memory_equal(tau[j], plain, sizeof plain);
            assert_memory_equal(out[0], out[j], sizeof out[0]);
        }
        for (int k = 0; k < LANES; k++)
            met += out[0][0][0][k] > 0.0f && out[0][1][0][k] > 0.0f;
    }
    assert_true(met > 1000);
    lf_slice_finish(&slice);
}

/* A grid of 20^3 voxels, a fifth of them 0, some bricks empty. */
static lf_grid *make_grid(uint64_t *seed)
{
    enum { SIDE = 20 };
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {SIDE, SIDE, SIDE};
    const int first[3] = {0, 0, 0}, last[3] = {SIDE - 1, SIDE - 1, 5};
    lf_grid *grid = NULL;
    lf_assert_ok(lf_grid_create(size, identity, &grid, NULL), NULL);
    lf_grid_mark(grid, first, last);
    lf_assert_ok(lf_grid_allocate(grid, NULL), NULL);
    for (int i = 0; i < SIDE * SIDE * 6; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        lf_grid_fill(grid, at, at, lf_max(lf_test_uniform(seed) - 0.2f, 0.0f));
    }
    lf_grid_finish(grid);
    return grid;
}

/* Look-ups along lines that leave the grid, and what they are held against. */
static void grids_are_the_same_in_every_instruction_set(void **state)
{
    (void)state;
    uint64_t seed = 23;
    lf_slice slice;
    int met = 0;
    assert_true(make_slice(&slice, 11));
    lf_volume volume = {.kind = LF_VOLUME_GRID, .grid = make_grid(&seed), .sigma_scale = 3.0f};
    for (int trial = 0; trial < 1000; trial++) {
        lf_fan fan;
        float points[LANES], sigma[2][LANES], factor[2][LANES];
        make_fan(&fan, trial % 2 == 0, &seed);
        lf_probe probe = {.slice = &slice,
                          .volume = &volume,
                          .z = 2.8f + 3.5f * lf_test_uniform(&seed),
                          .my2 = 1.1f,
                          .inverse = 0.1f};
        for (int i = 0; i < 3; i++) {
            probe.line.origin[i] = 20.0f * lf_test_uniform(&seed) - (i == 2 ? 3.0f : 0.0f);
            probe.line.across[i] = 20.0f * lf_test_uniform(&seed) - 10.0f;
        }
        for (int k = 0; k < LANES; k++)
            points[k] = 4.0f * lf_test_uniform(&seed) - 2.0f;
        for (int i = 0; lf_kernels_at(i); i++) {
            const lf_kernels *kernels = lf_kernels_at(i);
            int j = i > 0;
            for (int k = 0; k < LANES; k++)
                factor[j][k] = 1.0f;
            kernels->sample(&volume, &probe.line, LANES, points, sigma[j]);
            kernels->compare(&probe, LANES, fan.x0, fan.slope, fan.z_end, factor[j]);
            assert_memory_equal(sigma[0], sigma[j], sizeof sigma[0]);
            assert_memory_equal(factor[0], factor[j], sizeof factor[0]);
        }
        for (int k = 0; k < LANES; k++) {
            const float *o = probe.line.origin, *a = probe.line.across, x = points[k];
            float truth =
                lf_grid_linear(volume.grid, o[0] + x * a[0], o[1] + x * a[1], o[2] + x * a[2]);
            assert_true(sigma[0][k] == volume.sigma_scale * truth);
            met += truth > 0.0f;
        }
    }
    assert_true(met > 1000);
    lf_grid_unref(volume.grid);
    lf_slice_finish(&slice);
}

static void shapes_are_as_deep_in_every_instruction_set(void **state)
{
    (void)state;
    uint64_t seed = 17;
    int met = 0;
    for (int trial = 0; trial < 2000; trial++) {
        lf_fan fan;
        float tau[2][LANES] = {{0}};
        lf_body body = make_body(&seed);
        make_fan(&fan, trial % 2 == 0, &seed);
        lf_kernels_c.through(&body, LANES, fan.x0, fan.slope, fan.z_end, tau[0]);
        for (int k = 0; k < LANES; k++)
            met += tau[0][k] > 0.0f;
        for (int i = 1; lf_kernels_at(i); i++) {
            memset(tau[1], 0, sizeof tau[1]);
            lf_kernels_at(i)->through(&body, LANES, fan.x0, fan.slope, fan.z_end, tau[1]);
            assert_memory_equal(tau[0], tau[1], sizeof tau[0]);
        }
    }
    assert_true(met > 2000 * LANES / 10);
}

static void a_fan_is_as_deep_as_its_rays_alone(void **state)
{
    (void)state;
    uint64_t seed = 3;
    lf_slice slice;
    assert_true(make_slice(&slice, 5));
    for (int trial = 0; trial < 200; trial++) {
        lf_fan fan;
        float tau[LANES], z;
        make_fan(&fan, false, &seed);
        memset(tau, 0, sizeof tau);
        lf_kernels_c.march(&slice, LANES, fan.x0, fan.slope, fan.z_end, tau, NULL);
        for (int k = 0; k < 45; k++)
            lf_assert_close(
                (double)tau[k],
                (double)lf_slice_march(&slice, fan.x0[k], fan.slope[k], fan.z_end[k], INFINITY, &z),
                1e-5, 1e-6);
    }
    lf_slice_finish(&slice);
}

static void a_march_stops_where_the_depth_is_reached(void **state)
{
    (void)state;
    lf_slice slice;
    assert_true(make_slice(&slice, 5));
    for (int i = 1; i < 40; i++) {
        float z, again, stop = 0.5f * (float)i;
        float reached = lf_slice_march(&slice, 0.1f, 0.02f, INFINITY, stop, &z);
        if (reached < stop)
            break;
        lf_assert_close((double)lf_slice_march(&slice, 0.1f, 0.02f, z, INFINITY, &again),
                        (double)stop, 2e-5, 1e-6);
    }
    lf_slice_finish(&slice);
}

static void densities_are_ratios_that_neither_overflow_nor_vanish(void **state)
{
    (void)state;
    const float offset[] = {0.0f, 50.0f, 1e3f, 1e4f};
    for (size_t o = 0; o < sizeof offset / sizeof offset[0]; o++) {
        float scale[LF_LANES], tau[LF_LANES], d[LF_LANES];
        double sum = 0.0;
        for (int k = 0; k < LF_LANES; k++) {
            scale[k] = 1.0f + 0.5f * (float)k;
            tau[k] = offset[o] + 0.25f * (float)k;
        }
        for (int k = 0; k < LF_LANES; k++)
            sum += (double)scale[k] * exp(-(double)(tau[k] - offset[o]));
        lf_assert_close((double)lf_kernels_c.densities(LF_LANES, scale, tau, d), sum, 1e-6, 0.0);
        for (int k = 0; k < LF_LANES; k++)
            lf_assert_close((double)d[k], (double)scale[k] * exp(-(double)(tau[k] - offset[o])),
                            1e-6, 0.0);
    }
}

static void no_view_gives_no_density(void **state)
{
    (void)state;
    float scale[LF_LANES] = {0}, tau[LF_LANES] = {0}, d[LF_LANES];
    assert_true(lf_kernels_c.densities(LF_LANES, scale, tau, d) == 0.0f);
    for (int k = 0; k < LF_LANES; k++)
        assert_true(d[k] == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_instruction_set_equals_plain_c_bit_for_bit),
        cmocka_unit_test(moments_are_the_same_in_every_instruction_set),
        cmocka_unit_test(grids_are_the_same_in_every_instruction_set),
        cmocka_unit_test(shapes_are_as_deep_in_every_instruction_set),
        cmocka_unit_test(a_fan_is_as_deep_as_its_rays_alone),
        cmocka_unit_test(a_march_stops_where_the_depth_is_reached),
        cmocka_unit_test(densities_are_ratios_that_neither_overflow_nor_vanish),
        cmocka_unit_test(no_view_gives_no_density),
    };
    return cmocka_run_group_tests_name("kernel", tests, NULL, NULL);
}
