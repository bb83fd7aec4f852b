/* Every instruction set's kernels equal the plain C ones bit for bit, and those equal what they stand for. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "render/kernel.h"
#include "render/sampler.h"

enum { NX = 97, NZ = 61, LANES = 48 };

typedef struct lf_fan {
    float x0[LANES], slope[LANES], z_end[LANES];
} lf_fan;

static float uniform(uint64_t *state)
{
    *state = lf_hash64(*state, 1);
    return (float)(*state >> 40) * 0x1p-24f;
}

/* A slice with empty planes, empty margins and rough contents. */
static void make_slice(lf_slice *slice, uint64_t seed)
{
    *slice = (lf_slice){.nx = NX, .nz = NZ, .x_min = -1.3f, .inv_dx = NX / 2.6f, .z0 = 3.0f, .dz = 0.05f, .first = NZ, .last = -1};
    slice->inv_dz = 1.0f / slice->dz;
    slice->stride = NX + LF_SLICE_PADDING;
    slice->sigma = lf_calloc((size_t)NZ * (size_t)slice->stride, sizeof *slice->sigma);
    slice->behind = lf_calloc(NZ, sizeof *slice->behind);
    slice->spans = lf_calloc(NZ, sizeof *slice->spans);
    assert_non_null(slice->sigma);
    assert_non_null(slice->behind);
    assert_non_null(slice->spans);
    for (int s = 0; s < NZ; s++) {
        bool empty = s < 4 || s > NZ - 3 || s % 7 == 0;
        slice->spans[s] = (lf_plane_span){INFINITY, -INFINITY};
        if (empty)
            continue;
        int lo = 5 + (int)(20.0f * uniform(&seed)), hi = NX - 5 - (int)(20.0f * uniform(&seed));
        for (int i = lo; i <= hi; i++)
            slice->sigma[s * slice->stride + i] = 20.0f * uniform(&seed);
        slice->spans[s] = (lf_plane_span){slice->x_min + (float)(lo - 1) / slice->inv_dx, slice->x_min + (float)(hi + 1) / slice->inv_dx};
        slice->first = s < slice->first ? s : slice->first;
        slice->last = s;
    }
}

static void free_slice(lf_slice *slice)
{
    lf_slice_finish(slice);
}

/* 45 rays from a line of cameras through one point, as pivots and exits have them. */
static void make_fan(lf_fan *fan, float x, float z, bool same_end, uint64_t *seed)
{
    for (int k = 0; k < LANES; k++) {
        int view = k < 45 ? k : 44;
        fan->x0[k] = -2.0f + 4.0f * (float)view / 44.0f;
        fan->slope[k] = (x - fan->x0[k]) / z;
        fan->z_end[k] = same_end ? z : (k % 5 == 0 ? INFINITY : 2.5f + 4.0f * uniform(seed));
    }
}

static void every_instruction_set_equals_plain_c_bit_for_bit(void **state)
{
    (void)state;
    uint64_t seed = 7;
    lf_slice slice;
    make_slice(&slice, 11);
    for (int i = 1; lf_kernels_at(i); i++) {
        for (int trial = 0; trial < 500; trial++) {
            lf_fan fan;
            float tau[2][LANES], sigma[2][LANES], d[2][LANES], scale[LANES];
            bool pivot = trial % 2 == 0;
            make_fan(&fan, 3.0f * uniform(&seed) - 1.5f, 2.8f + 3.5f * uniform(&seed), pivot, &seed);
            const lf_kernels *k[2] = {lf_kernels_at(0), lf_kernels_at(i)};
            for (int j = 0; j < 2; j++) {
                memset(tau[j], 0, sizeof tau[j]);
                k[j]->march(&slice, LANES, fan.x0, fan.slope, fan.z_end, tau[j], pivot ? sigma[j] : NULL);
                for (int l = 0; l < LANES; l++)
                    scale[l] = l % 6 == 5 ? 0.0f : 1.0f + (float)l;
            }
            assert_memory_equal(tau[0], tau[1], sizeof tau[0]);
            if (pivot)
                assert_memory_equal(sigma[0], sigma[1], sizeof sigma[0]);
            float a = k[0]->densities(LANES, scale, tau[0], d[0]), b = k[1]->densities(LANES, scale, tau[1], d[1]);
            assert_memory_equal(&a, &b, sizeof a);
            assert_memory_equal(d[0], d[1], sizeof d[0]);
        }
    }
    free_slice(&slice);
}

static void a_fan_is_as_deep_as_its_rays_alone(void **state)
{
    (void)state;
    uint64_t seed = 3;
    lf_slice slice;
    make_slice(&slice, 5);
    for (int trial = 0; trial < 200; trial++) {
        lf_fan fan;
        float tau[LANES], z;
        make_fan(&fan, 3.0f * uniform(&seed) - 1.5f, 2.8f + 3.5f * uniform(&seed), false, &seed);
        memset(tau, 0, sizeof tau);
        lf_kernels_c.march(&slice, LANES, fan.x0, fan.slope, fan.z_end, tau, NULL);
        for (int k = 0; k < 45; k++)
            lf_assert_close((double)tau[k], (double)lf_slice_march(&slice, fan.x0[k], fan.slope[k], fan.z_end[k], INFINITY, &z),
                            1e-5, 1e-6);
    }
    free_slice(&slice);
}

static void a_march_stops_where_the_depth_is_reached(void **state)
{
    (void)state;
    lf_slice slice;
    make_slice(&slice, 5);
    for (int i = 1; i < 40; i++) {
        float z, again, stop = 0.5f * (float)i;
        float reached = lf_slice_march(&slice, 0.1f, 0.02f, INFINITY, stop, &z);
        if (reached < stop)
            break;
        lf_assert_close((double)lf_slice_march(&slice, 0.1f, 0.02f, z, INFINITY, &again), (double)stop, 2e-5, 1e-6);
    }
    free_slice(&slice);
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
            lf_assert_close((double)d[k], (double)scale[k] * exp(-(double)(tau[k] - offset[o])), 1e-6, 0.0);
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
        cmocka_unit_test(a_fan_is_as_deep_as_its_rays_alone),
        cmocka_unit_test(a_march_stops_where_the_depth_is_reached),
        cmocka_unit_test(densities_are_ratios_that_neither_overflow_nor_vanish),
        cmocka_unit_test(no_view_gives_no_density),
    };
    return cmocka_run_group_tests_name("kernel", tests, NULL, NULL);
}
