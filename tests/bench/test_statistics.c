/* The statistics of quiltbench on numbers whose answers are known. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "bench/statistics.h"
#include "tests/stat/stat.h"

/* Standard normal numbers. */
typedef struct source {
    uint64_t state;
} source;

static double uniform(source *s)
{
    s->state += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t z = s->state;
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

static double normal(source *s)
{
    double r = sqrt(-2 * log(uniform(s)));
    return r * cos(2 * M_PI * uniform(s));
}

static void spreads_are_order_statistics(void **state)
{
    (void)state;
    const double odd[] = {5, 1, 3};
    const double even[] = {4, 1, 3, 2};
    lf_assert_close(lf_spread_of(odd, 3).median, 3, 0, 0);
    lf_assert_close(lf_spread_of(even, 4).median, 2.5, 0, 0);
    lf_assert_close(lf_spread_of(even, 4).low, 1, 0, 0);
    lf_assert_close(lf_spread_of(even, 4).high, 4, 0, 0);
}

static void quantiles_of_student_invert_its_distribution(void **state)
{
    (void)state;
    const double levels[] = {1e-6, 1e-3, 0.05, 0.5, 0.999};
    for (int degrees = 1; degrees <= 63; degrees++) {
        for (size_t i = 0; i < sizeof levels / sizeof levels[0]; i++) {
            double t = lf_student_quantile(1 - 0.5 * levels[i], degrees);
            lf_assert_close(lf_p_student(t, degrees), levels[i], 1e-7, 1e-12);
            lf_assert_close(lf_student_quantile(0.5 * levels[i], degrees), -t, 1e-9, 1e-12);
        }
    }
    lf_assert_close(lf_student_quantile(0.975, 7), 2.3646242510, 1e-9, 0); /* any table */
}

/* 2000 intervals of 8 log-normal values: the share that holds the truth is binomial; |z| > 4.06 has
 * probability 5e-5. A narrower one (Student's t taken for the normal) is caught: 90.9 % is 8.4
 * standard errors away. */
static void intervals_cover_as_often_as_they_say(void **state)
{
    (void)state;
    enum { N = 8, TRIALS = 2000 };
    source s = {lf_test_seed()};
    int inside = 0;
    int inside_of_normal = 0;

    for (int trial = 0; trial < TRIALS; trial++) {
        double values[N];
        for (int i = 0; i < N; i++)
            values[i] = exp(1 + 0.7 * normal(&s));
        lf_interval interval = lf_log_interval(values, N, 0.95);
        inside += interval.low <= exp(1) && exp(1) <= interval.high;
        double narrower = 1.959964 / lf_student_quantile(0.975, N - 1);
        inside_of_normal +=
            fabs(log(interval.estimate) - 1) <= narrower * log(interval.high / interval.estimate);
    }
    double error = sqrt(0.95 * 0.05 * TRIALS);
    print_message("95 %%: %d of %d\n", inside, TRIALS);
    assert_true(fabs(inside - 0.95 * TRIALS) < 4.06 * error);
    assert_true(fabs(inside_of_normal - 0.95 * TRIALS) > 4.06 * error);
}

static void what_cannot_be_said_is_not_a_number(void **state)
{
    (void)state;
    const double values[] = {1, -1, 2};
    bool beyond;
    assert_true(isnan(lf_log_interval(values, 3, 0.95).estimate));
    assert_true(isnan(lf_log_interval(values, 1, 0.95).low));
    lf_assert_close(lf_log_interval(values, 1, 0.95).estimate, 1, 0, 0);
    assert_true(isnan(lf_fit_line(values, values, 2).error));
    assert_true(isnan(lf_time_of_error((double[]){1, 2}, values, 2, 0.5, &beyond)));
    assert_true(isnan(lf_correlation_value(&(lf_correlation){.ab = 1, .aa = 1})));
}

static void lines_have_their_slopes_and_standard_errors(void **state)
{
    (void)state;
    /* y = 2 - x + {1, -1, -1, 1}: the residuals are orthogonal to 1 and x; error^2 = 4 / 2 / 5 */
    const double x[] = {0, 1, 2, 3};
    const double y[] = {3, 0, -1, 0};
    lf_fit line = lf_fit_line(x, y, 4);
    lf_assert_close(line.slope, -1, 1e-12, 0);
    lf_assert_close(line.intercept, 2, 1e-12, 0);
    lf_assert_close(line.error, sqrt(0.4), 1e-12, 0);
}

/* error = 3 / time. */
static void equal_errors_are_found_on_the_curve(void **state)
{
    (void)state;
    const double times[] = {1, 2, 4, 8};
    const double errors[] = {3, 1.5, 0.75, 0.375};
    bool beyond = true;
    lf_assert_close(lf_time_of_error(times, errors, 4, 1.0, &beyond), 3, 1e-12, 0);
    assert_false(beyond);
    lf_assert_close(lf_time_of_error(times, errors, 4, 3, &beyond), 1, 1e-12, 0);
    assert_false(beyond);
    lf_assert_close(lf_time_of_error(times, errors, 4, 0.125, &beyond), 24, 1e-12, 0);
    assert_true(beyond);
    lf_assert_close(lf_time_of_error(times, errors, 4, 6, &beyond), 0.5, 1e-12, 0);
    assert_true(beyond);
    /* 4.1 times the last */
    assert_true(isnan(lf_time_of_error(times, errors, 4, 3.0 / 33, &beyond)));
    /* a curve that is not straight: between two points only they count */
    const double bent[] = {3, 1.5, 1, 0.01};
    lf_assert_close(lf_time_of_error(times, bent, 4, 1.2, &beyond),
                    exp(log(2) + log(1.25) / log(1.5) * log(2)), 1e-12, 0);
}

/* Two errors with correlation 0.6, seen against a reference that adds an error of its own to both.
 * A reference whose error was not taken off would give (0.6 + 1) / 2. */
static void correlations_are_freed_of_the_references_error(void **state)
{
    (void)state;
    enum { N = 200000 };
    float *data = lf_calloc(3 * N, sizeof *data);
    float *a = data;
    float *b = data + N;
    float *noise = data + 2 * N;
    source s = {lf_test_seed()};
    lf_correlation cross = {0};
    lf_correlation raw = {0};

    for (int i = 0; i < N; i++) {
        double common = normal(&s);
        double r = normal(&s);
        a[i] = (float)(sqrt(0.6) * common + sqrt(0.4) * normal(&s) - r);
        b[i] = (float)(sqrt(0.6) * common + sqrt(0.4) * normal(&s) - r);
        noise[i] = (float)normal(&s); /* another error with the same variance */
    }
    lf_correlation_add(&cross, N, a, b, noise, noise);
    float *none = lf_calloc(N, sizeof *none);
    lf_correlation_add(&raw, N, a, b, none, none);
    /* the standard error of the first is below 0.01 */
    lf_assert_close(lf_correlation_value(&cross), 0.6, 0, 0.04);
    lf_assert_close(lf_correlation_value(&raw), 0.8, 0, 0.02);
    lf_free(none);
    lf_free(data);
}

enum { SEEDS = LF_TILE_SEEDS, TILES = 300 };

/* Ratios of tiles that are `ratio` with a spread of 0.3 on the logarithm, and `special` in tile 7.
 */
static void draw_tiles(source *s, double ratio, double special, double out[SEEDS][TILES])
{
    for (int seed = 0; seed < SEEDS; seed++)
        for (int tile = 0; tile < TILES; tile++)
            out[seed][tile] = (tile == 7 ? special : ratio) * exp(0.3 * normal(s));
}

static void the_worst_tile_is_the_one_that_was_put_there(void **state)
{
    (void)state;
    static double ratio[SEEDS][TILES];
    source s = {lf_test_seed()};
    draw_tiles(&s, 20, 0.1, ratio);
    lf_tile_bound bound = lf_worst_tile(&ratio[0][0], SEEDS, TILES, 0.99, 0.8);
    assert_int_equal(bound.n_judged, TILES);
    assert_int_equal(bound.worst, 7);
    assert_int_equal(bound.n_surely_less, 1);
    lf_assert_close(log(bound.estimate), log(0.1), 0, 5 * 0.3 / sqrt(SEEDS));
    lf_assert_close(bound.least, bound.estimate, 1e-12, 0);
    assert_true(bound.low < bound.estimate);

    ratio[3][7] = -1; /* the reference was too rough there: not judged, and the rest is */
    bound = lf_worst_tile(&ratio[0][0], SEEDS, TILES, 0.99, 0.8);
    assert_int_equal(bound.n_judged, TILES - 1);
    assert_true(bound.worst != 7);
    assert_int_equal(bound.n_surely_less, 0);
}

/* 8 seeds bound no tile of many, however good all are: what they would say is told by nobody. */
static void few_seeds_bound_no_tile(void **state)
{
    (void)state;
    static double ratio[SEEDS][TILES];
    source s = {lf_test_seed()};
    draw_tiles(&s, 20, 20, ratio);
    assert_true(lf_worst_tile(&ratio[0][0], SEEDS, TILES, 0.99, 0.8).low > 10);
    for (int n = 1; n < SEEDS; n++) {
        lf_tile_bound bound = lf_worst_tile(&ratio[0][0], n, TILES, 0.99, 0.8);
        assert_true(bound.worst == -1 && bound.n_judged == 0 && bound.n_surely_less == 0);
        assert_true(isnan(bound.low) && isnan(bound.estimate) && isnan(bound.least));
    }
}

/* 200 pictures in which all tiles are alike at 1: in 99 % no upper bound lies below it. The count
 * of the others is binomial; more than 10 of 200 has probability 1e-5. Without the correction
 * almost every picture would have one. */
static void bounds_hold_for_all_tiles_at_once(void **state)
{
    (void)state;
    enum { PICTURES = 200 };
    static double ratio[SEEDS][TILES];
    source s = {lf_test_seed()};
    int wrong = 0;
    int wrong_of_one = 0;
    double t = lf_student_quantile(0.99, SEEDS - 1);

    for (int i = 0; i < PICTURES; i++) {
        bool any = false;
        draw_tiles(&s, 1, 1, ratio);
        for (int tile = 0; tile < TILES; tile++) {
            lf_moments of_tile = {0};
            for (int seed = 0; seed < SEEDS; seed++)
                lf_moments_add(&of_tile, log(ratio[seed][tile]));
            any |= of_tile.mean > t * lf_moments_error(&of_tile);
        }
        wrong_of_one += any;
        wrong += lf_worst_tile(&ratio[0][0], SEEDS, TILES, 0.99, 1).n_surely_less > 0;
    }
    print_message("beyond: %d corrected, %d not, of %d\n", wrong, wrong_of_one, PICTURES);
    assert_true(wrong <= 10);
    assert_true(wrong_of_one > 160);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spreads_are_order_statistics),
        cmocka_unit_test(quantiles_of_student_invert_its_distribution),
        cmocka_unit_test(intervals_cover_as_often_as_they_say),
        cmocka_unit_test(what_cannot_be_said_is_not_a_number),
        cmocka_unit_test(lines_have_their_slopes_and_standard_errors),
        cmocka_unit_test(equal_errors_are_found_on_the_curve),
        cmocka_unit_test(correlations_are_freed_of_the_references_error),
        cmocka_unit_test(the_worst_tile_is_the_one_that_was_put_there),
        cmocka_unit_test(few_seeds_bound_no_tile),
        cmocka_unit_test(bounds_hold_for_all_tiles_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
