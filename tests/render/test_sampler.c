#include "tests/testing.h"

#include "render/transport/sampler.h"
#include "tests/stat/chi2.h"
#include "tests/stat/stat.h"

/* Every elementary interval of area 1/n of the unit square holds exactly one of n = 2^m points;
 * false otherwise. */
static bool is_net(float (*points)[2], int m)
{
    for (int a = 0; a <= m; a++) {
        uint8_t hit[1024] = {0};
        int columns = 1 << a, rows = 1 << (m - a);
        for (int i = 0; i < 1 << m; i++) {
            int x = (int)(points[i][0] * (float)columns), y = (int)(points[i][1] * (float)rows);
            if (hit[y * columns + x]++)
                return false;
        }
    }
    return true;
}

static void draw_points(lf_sampler_kind kind, uint64_t key, int n, uint32_t start, int skip,
                        float (*points)[2])
{
    for (int i = 0; i < n; i++) {
        lf_sampler s;
        lf_sampler_init(&s, kind, key, start + (uint32_t)i);
        for (int j = 0; j < skip; j++)
            lf_sampler_1d(&s);
        lf_sampler_2d(&s, points[i]);
    }
}

static void aligned_blocks_of_owen_pairs_are_nets(void **state)
{
    (void)state;
    float points[1024][2];
    for (uint64_t key = 0; key < 20; key++) {
        for (int m = 0; m <= 10; m += 2) {
            uint32_t start = (uint32_t)((key * 7919) << m);
            draw_points(LF_SAMPLER_OWEN, lf_hash64(key, 5), 1 << m, start, (int)(3 * key % 60),
                        points);
            assert_true(is_net(points, m));
        }
    }
}

/* The points of four samples of eight each are a net of 32, from any dimension. */
static void split_points_are_a_net_over_all_samples(void **state)
{
    (void)state;
    float points[32][2];
    for (uint64_t key = 0; key < 20; key++) {
        for (uint32_t i = 0; i < 4; i++) {
            lf_sampler s;
            lf_sampler_init(&s, LF_SAMPLER_OWEN, key, 4 * (uint32_t)key + i);
            s.dimension = 5;
            lf_sampler_split(&s, 8);
            for (int k = 0; k < 8; k++) {
                if (k > 0)
                    lf_sampler_next(&s, 5);
                lf_sampler_2d(&s, points[8 * i + (uint32_t)k]);
            }
        }
        assert_true(is_net(points, 5));
    }
}

static void independent_points_are_no_net(void **state)
{
    (void)state;
    float points[1024][2];
    draw_points(LF_SAMPLER_INDEPENDENT, 3, 1024, 0, 0, points);
    assert_false(is_net(points, 10));
    draw_points(LF_SAMPLER_OWEN, 3, 1024, 0, LF_SAMPLER_DIMENSIONS, points);
    assert_false(is_net(points, 10));
}

static void aligned_blocks_of_one_dimension_are_stratified(void **state)
{
    (void)state;
    for (int dimension = 0; dimension < 64; dimension += 9) {
        uint8_t hit[256] = {0}, radical[256] = {0};
        for (uint32_t i = 0; i < 256; i++) {
            lf_sampler s;
            float x = 0.0f;
            lf_sampler_init(&s, LF_SAMPLER_OWEN, 77, 512 + i);
            for (int j = 0; j <= dimension; j++)
                x = lf_sampler_1d(&s);
            hit[(int)(x * 256.0f)]++;
            radical[(int)(lf_sampler_radical((uint64_t)dimension, 1024 + i) * 256.0f)]++;
        }
        for (int i = 0; i < 256; i++) {
            assert_int_equal(hit[i], 1);
            assert_int_equal(radical[i], 1);
        }
    }
}

/* What a visit draws for its whole row (its offset, the lens, the slices' phase) and for a column
 * of it are such pairs: if one sequence told the other, no mean over both would converge. Of 64
 * cells each is filled as it should be within 5 standard errors. */
static void sequences_of_different_keys_fill_the_square(void **state)
{
    (void)state;
    for (uint64_t key = 0; key < 40; key++) {
        int cell[8][8] = {{0}};
        for (uint32_t i = 0; i < 4096; i++) {
            float x = lf_sampler_radical(lf_hash64(key, 0), i),
                  y = lf_sampler_radical(lf_hash64(key, 1), i);
            cell[(int)(8 * y)][(int)(8 * x)]++;
        }
        for (int i = 0; i < 64; i++)
            assert_in_range(cell[i / 8][i % 8], 64 - 40, 64 + 40);
    }
}

static void partners_share_a_coordinate_and_are_nets(void **state)
{
    (void)state;
    float points[1024][2];
    for (uint64_t key = 0; key < 20; key++) {
        for (uint32_t i = 0; i < 1024; i++) {
            points[i][0] = lf_sampler_radical(key, 2048 + i);
            points[i][1] = lf_sampler_partner(key, lf_hash64(key, 9), 2048 + i);
        }
        assert_true(is_net(points, 10));
        for (uint32_t i = 0; i < 1024; i++)
            points[i][0] = lf_sampler_radical(key + 1, 2048 + i);
        assert_false(is_net(points, 10));
    }
}

static void values_depend_on_key_index_and_dimension_alone(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        float forward[50][70], backward[50][70];
        for (int i = 0; i < 50; i++) {
            lf_sampler s;
            lf_sampler_init(&s, (lf_sampler_kind)kind, 42, (uint32_t)i);
            for (int j = 0; j < 70; j += 2)
                lf_sampler_2d(&s, &forward[i][j]);
        }
        for (int i = 49; i >= 0; i--) {
            lf_sampler s, other;
            lf_sampler_init(&s, (lf_sampler_kind)kind, 42, (uint32_t)i);
            lf_sampler_init(&other, (lf_sampler_kind)kind, 43, (uint32_t)i);
            for (int j = 0; j < 70; j += 2) {
                float unused[2];
                lf_sampler_2d(&other, unused);
                lf_sampler_2d(&s, &backward[i][j]);
                assert_true(unused[0] != backward[i][j] || unused[1] != backward[i][j + 1]);
            }
        }
        assert_memory_equal(forward, backward, sizeof forward);
    }
}

/* One point each of many keys: what a single scrambled point gives is uniform, in the square and in
 * each dimension. */
static double p_of_first_points(lf_sampler_kind kind, uint32_t index, int skip)
{
    enum { n = 200000, side = 16 };
    double observed[side * side] = {0}, expected[side * side];
    for (int i = 0; i < n; i++) {
        float u[2];
        lf_sampler s;
        lf_sampler_init(&s, kind, lf_hash64(lf_test_seed(), (uint64_t)i), index);
        for (int j = 0; j < skip; j++)
            lf_sampler_1d(&s);
        lf_sampler_2d(&s, u);
        assert_true(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
        observed[(int)(u[1] * side) * side + (int)(u[0] * side)] += 1.0;
    }
    for (int i = 0; i < side * side; i++)
        expected[i] = (double)n / (side * side);
    return lf_chi2_p(observed, expected, side * side);
}

static void single_points_are_uniform(void **state)
{
    (void)state;
    const uint32_t index[] = {0, 1, 5, 0x12345678u, 0xffffffffu};
    for (int kind = 0; kind < 2; kind++) {
        for (int i = 0; i < 5; i++) {
            for (int skip = 0; skip < 80; skip += 39)
                assert_true(p_of_first_points((lf_sampler_kind)kind, index[i], skip) >
                            lf_sidak(LF_FALSE_ALARM, 30));
        }
    }
}

/* Covariance of two numbers of one sample over 256 samples: 0 in the mean over keys. Points of
 * different pairs must not know of each other (padding), or integrals over both are wrong. Its
 * variance is a property of the sampler, so it is measured. */
static void dimensions_are_uncorrelated(void **state)
{
    (void)state;
    enum { dimensions = 12 };
    for (int kind = 0; kind < 2; kind++) {
        lf_moments covariance[dimensions][dimensions] = {{{0}}};
        for (uint64_t key = 0; key < 400; key++) {
            double sum[dimensions][dimensions] = {{0}};
            for (uint32_t i = 0; i < 256; i++) {
                lf_sampler s;
                float u[dimensions];
                lf_sampler_init(&s, (lf_sampler_kind)kind, lf_hash64(lf_test_seed() + 5, key), i);
                for (int j = 0; j < dimensions; j += 2)
                    lf_sampler_2d(&s, &u[j]);
                for (int a = 0; a < dimensions * dimensions; a++)
                    sum[a / dimensions][a % dimensions] +=
                        ((double)u[a / dimensions] - 0.5) * ((double)u[a % dimensions] - 0.5);
            }
            for (int a = 0; a < dimensions * dimensions; a++)
                lf_moments_add(&covariance[a / dimensions][a % dimensions],
                               sum[a / dimensions][a % dimensions] / 256.0);
        }
        for (int a = 0; a < dimensions; a++) {
            assert_true(fabs(covariance[a][a].mean - 1.0 / 12.0) < 1e-3);
            for (int b = 0; b < a; b++)
                assert_true(lf_p_mean(&covariance[a][b], 0.0) >
                            lf_sidak(LF_FALSE_ALARM, dimensions * (dimensions - 1)));
        }
    }
}

/* Mean of an integrand with a known integral over many keys: scrambling is unbiased, and the error
 * of a smooth integrand falls faster than that of independent points. */
static void integral(lf_sampler_kind kind, int n_points, lf_moments *m)
{
    for (int key = 0; key < 500; key++) {
        double sum = 0.0;
        for (int i = 0; i < n_points; i++) {
            lf_sampler s;
            float u[2];
            lf_sampler_init(&s, kind, lf_hash64(lf_test_seed() + 9, (uint64_t)key), (uint32_t)i);
            lf_sampler_2d(&s, u);
            sum += exp(-(double)(u[0] * u[0])) * (double)u[1];
        }
        lf_moments_add(m, sum / n_points);
    }
}

static void scrambled_points_integrate_without_bias_and_well(void **state)
{
    (void)state;
    double truth = 0.5 * 0.5 * sqrt(M_PI) * erf(1.0);
    lf_moments owen = {0}, independent = {0}, odd = {0};
    integral(LF_SAMPLER_OWEN, 256, &owen);
    integral(LF_SAMPLER_OWEN, 37, &odd);
    integral(LF_SAMPLER_INDEPENDENT, 256, &independent);
    assert_true(lf_p_mean(&owen, truth) > lf_sidak(LF_FALSE_ALARM, 3));
    assert_true(lf_p_mean(&odd, truth) > lf_sidak(LF_FALSE_ALARM, 3));
    assert_true(lf_p_mean(&independent, truth) > lf_sidak(LF_FALSE_ALARM, 3));
    assert_true(lf_moments_variance(&owen) < 0.01 * lf_moments_variance(&independent));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(aligned_blocks_of_owen_pairs_are_nets),
        cmocka_unit_test(split_points_are_a_net_over_all_samples),
        cmocka_unit_test(independent_points_are_no_net),
        cmocka_unit_test(aligned_blocks_of_one_dimension_are_stratified),
        cmocka_unit_test(sequences_of_different_keys_fill_the_square),
        cmocka_unit_test(partners_share_a_coordinate_and_are_nets),
        cmocka_unit_test(values_depend_on_key_index_and_dimension_alone),
        cmocka_unit_test(single_points_are_uniform),
        cmocka_unit_test(dimensions_are_uncorrelated),
        cmocka_unit_test(scrambled_points_integrate_without_bias_and_well),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
