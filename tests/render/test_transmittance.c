/* The mean of ratio tracking itself, at the tracker's own door, against exp(-tau) in closed form.
 * Where the transmittance is small all of what is seen has passed the roulette several times:
 * giving back 1.9 for 2 there takes 5 % at every throw. */
#include "tests/testing.h"

#include "render/scene/grid.h"
#include "render/transport/path/track.h"
#include "render/transport/sampler.h"
#include "tests/stat/stat.h"

/* Bricks: 6 x 4 x 4. */
enum { size_x = 45, size_yz = 27, comparisons = 24 };

/* Changes along x alone, with empty voxels and an empty brick. */
static float profile(int x)
{
    return x >= 17 && x < 25 ? 0.0f : (float)(x * 37 % 11) / 10.0f;
}

static double profile_sum(void)
{
    double sum = 0.0;
    for (int x = 0; x < size_x; x++)
        sum += (double)profile(x);
    return sum;
}

static lf_grid *make_grid(void)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const int64_t size[3] = {size_x, size_yz, size_yz};
    lf_grid *grid = NULL;
    lf_error err;
    lf_assert_ok(lf_grid_create(size, identity, &grid, &err), &err);
    for (int round = 0; round < 2; round++) {
        for (int x = 0; x < size_x; x++) {
            const int from[3] = {x, 0, 0}, to[3] = {x, size_yz - 1, size_yz - 1};
            if (profile(x) > 0.0f && round == 0)
                lf_grid_mark(grid, from, to);
            else if (profile(x) > 0.0f)
                lf_grid_fill(grid, from, to, profile(x));
        }
        if (round == 0)
            lf_assert_ok(lf_grid_allocate(grid, &err), &err);
    }
    lf_grid_finish(grid);
    return grid;
}

/* A volume whose own space is the scene's. */
static lf_volume make_volume(lf_volume_kind kind, lf_grid *grid, bool nearest, double sigma)
{
    lf_volume v = {.kind = kind,
                   .grid = grid,
                   .nearest = nearest,
                   .sigma_scale = (float)sigma,
                   .sigma_max = (float)sigma};
    for (int i = 0; i < 3; i++)
        v.to_volume[i][i] = 1.0f;
    return v;
}

/* Means of n estimates along the segment from a to b. */
static lf_moments estimates(lf_volume *volumes, int n_volumes, lf_vec3 a, lf_vec3 b, int n)
{
    lf_scene scene = {.n_volumes = n_volumes, .volumes = volumes};
    lf_tracer tracer = {.scene = &scene, .rng = lf_hash64(lf_test_seed(), 0)};
    lf_vec3 d = lf_sub(b, a);
    lf_moments m = {0};
    for (int i = 0; i < n; i++)
        lf_moments_add(&m,
                       (double)lf_track_transmittance(&tracer, a, lf_normalize(d), lf_length(d)));
    return m;
}

/* The mean is the truth, and `error` (relative) is what the standard error is at most; four times
 * that in the mean is rejected. */
static void assert_mean(const char *what, const lf_moments *m, double truth, double error)
{
    double level = lf_sidak(LF_FALSE_ALARM, comparisons);
    if (!(lf_p_mean(m, truth) > level))
        fail_msg("%s: %.6g +- %.2g for %.6g", what, m->mean, lf_moments_error(m), truth);
    if (!(lf_moments_error(m) < error * truth))
        fail_msg("%s: %.2g of %.6g is too much noise to hold anything", what, lf_moments_error(m),
                 truth);
    assert_true(lf_p_mean(m, truth * (1.0 + 8.0 * error)) < level);
}

/* A ray that runs across the profile's planes through most of the bricks, whole in y and z: its
 * depth is the sum of the voxels over the cosine, since the shares of neighbours add up to 1
 * everywhere. */
static const lf_vec3 from = {-3.0f, 2.3f, 22.1f}, to = {51.0f, 24.6f, 1.7f};

static double slant(void)
{
    lf_vec3 d = lf_sub(to, from);
    return (double)lf_length(d) / (double)d.x;
}

static void ratio_tracking_through_many_bricks_is_exp_of_minus_the_depth(void **state)
{
    (void)state;
    static const struct {
        double depth, error;
        int n;
    } cases[] = {{0.01, 5e-4, 40000}, {0.1, 1e-3, 100000}, {0.5, 1e-3, 500000}, {1.0, 2e-3, 500000},
                 {2.0, 3e-3, 600000}, {4.0, 2e-2, 300000}, {8.0, 2e-1, 200000}};
    lf_grid *grid = make_grid();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int nearest = 0; nearest < 2; nearest++) {
            lf_volume v = make_volume(LF_VOLUME_GRID, grid, nearest,
                                      cases[i].depth / (profile_sum() * slant()));
            lf_moments m = estimates(&v, 1, from, to, cases[i].n);
            assert_mean(nearest ? "nearest" : "linear", &m, exp(-cases[i].depth), cases[i].error);
        }
    }
    lf_grid_unref(grid);
}

/* A shape takes exactly exp(-depth); what it leaves is below the roulette's threshold for all of a
 * grid behind it, so that every look-up there is a throw. */
static void a_grid_behind_18_mean_free_paths_of_fog_keeps_its_own_transmittance(void **state)
{
    (void)state;
    static const double depth[] = {0.01, 0.1, 0.5, 2.0};
    static const double error[] = {5e-4, 1e-3, 4e-3, 3e-2};
    lf_grid *grid = make_grid();
    for (int i = 0; i < 4; i++) {
        lf_volume v[2] = {
            make_volume(LF_VOLUME_BOX, NULL, false, 9.0),
            make_volume(LF_VOLUME_GRID, grid, false, depth[i] / (profile_sum() * slant()))};
        v[0].to_volume[0][3] = 2.0f; /* x in -3 … -1: 2 wide, all of it in front of the grid */
        v[0].to_volume[1][1] = v[0].to_volume[2][2] = 1e-3f;
        double truth = exp(-18.0 * slant() - depth[i]);
        lf_moments m = estimates(v, 2, from, to, 300000);
        /* Numbers near 1, for the sake of their squares. */
        m.mean /= truth;
        m.m2 /= truth * truth;
        assert_mean("behind fog", &m, 1.0, error[i]);
    }
    lf_grid_unref(grid);
}

static void shapes_take_exp_of_minus_their_depth_exactly(void **state)
{
    (void)state;
    static const double depth[] = {0.01, 1.0, 20.0};
    for (int i = 0; i < 3; i++) {
        for (int kind = LF_VOLUME_SPHERE; kind <= LF_VOLUME_BOX; kind++) {
            lf_volume v = make_volume(kind, NULL, false, 0.5 * depth[i]);
            lf_moments m = estimates(&v, 1, lf_v3(0.0f, 0.0f, -3.0f), lf_v3(0.0f, 0.0f, 3.0f), 4);
            assert_true(m.m2 == 0.0);
            lf_assert_close(m.mean, exp(-depth[i]), 0, 1e-5);
        }
    }
}

/* From within the empty voxels, x in 17 … 24, towards full ones: t is 1000 there. */
static const lf_vec3 far_start = {20.5f, 13.0f, -1000.0f}, towards_z = {0.0f, 0.0f, 1.0f};

/* So dense that steps are below the rounding of t, at a voxel that is empty but for its neighbours
 * in the brick. */
static void a_ray_that_stands_still_ends(void **state)
{
    (void)state;
    lf_grid *grid = make_grid();
    lf_volume volume = make_volume(LF_VOLUME_GRID, grid, false, 1e12);
    lf_scene scene = {.n_volumes = 1, .volumes = &volume};
    const float half_way = 1013.0f;
    for (int chromatic = 0; chromatic < 2; chromatic++) {
        lf_tracer tracer = {.scene = &scene, .rng = lf_hash64(lf_test_seed(), 7)};
        lf_vec3 channels, one = {1.0f, 1.0f, 1.0f};
        int whose;
        volume.colour = chromatic ? lf_v3(1.0f, 0.5f, 0.25f) : lf_v3(0.0f, 0.0f, 0.0f);
        for (int i = 0; i < 4; i++) {
            tracer.lookups = 0;
            if (chromatic)
                lf_track_channels(&tracer, far_start, towards_z, half_way, one, &whose, &channels);
            else
                lf_track_collision(&tracer, far_start, towards_z, half_way, &whose);
            assert_in_range(tracer.lookups, LF_MOST_STILL, 2 * LF_MOST_STILL);
            tracer.lookups = 0;
            if (chromatic)
                assert_float_equal(
                    lf_track_transmittances(&tracer, far_start, towards_z, half_way).x, 0.0, 0.0);
            else
                assert_float_equal(lf_track_transmittance(&tracer, far_start, towards_z, half_way),
                                   0.0, 0.0);
            assert_in_range(tracer.lookups, LF_MOST_STILL, 2 * LF_MOST_STILL);
        }
    }
    lf_grid_unref(grid);
}

/* However many null collisions it meets: here about 1e6, at voxels that are empty, in bricks whose
 * majorant is that of full ones. */
static void a_ray_that_moves_goes_on(void **state)
{
    (void)state;
    lf_grid *grid = make_grid();
    lf_volume volume = make_volume(LF_VOLUME_GRID, grid, false, 4e4);
    lf_scene scene = {.n_volumes = 1, .volumes = &volume};
    lf_tracer tracer = {.scene = &scene, .rng = lf_hash64(lf_test_seed(), 8)};
    const lf_vec3 near_start = {20.5f, 13.0f, 0.0f};
    int whose;
    assert_float_equal(lf_track_transmittance(&tracer, near_start, towards_z, 26.0f), 1.0, 0.0);
    assert_in_range(tracer.lookups, 500000, 2000000);
    assert_true(isinf(lf_track_collision(&tracer, near_start, towards_z, 26.0f, &whose)));
    volume.colour = lf_v3(1.0f, 0.5f, 0.25f);
    assert_float_equal(lf_track_transmittances(&tracer, near_start, towards_z, 26.0f).x, 1.0, 0.0);
    lf_grid_unref(grid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ratio_tracking_through_many_bricks_is_exp_of_minus_the_depth),
        cmocka_unit_test(a_grid_behind_18_mean_free_paths_of_fog_keeps_its_own_transmittance),
        cmocka_unit_test(shapes_take_exp_of_minus_their_depth_exactly),
        cmocka_unit_test(a_ray_that_stands_still_ends),
        cmocka_unit_test(a_ray_that_moves_goes_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
