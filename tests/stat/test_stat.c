/* The harness of the statistical tests is itself tested: known values, p-values that are uniform
 * when all is well, and rejection when it is not. */
#include "tests/testing.h"

#include "render/transport/sampler.h"
#include "tests/stat/chi2.h"
#include "tests/stat/kept.h"
#include "tests/stat/stat.h"

static void assert_near(double a, double b, double eps)
{
    if (!(fabs(a - b) <= eps))
        fail_msg("%.12g is not %.12g within %g", a, b, eps);
}

static void gamma_function_has_its_closed_forms(void **state)
{
    (void)state;
    for (double x = 0.01; x < 60.0; x *= 1.7) {
        assert_near(lf_gamma_q(1.0, x), exp(-x), 1e-14);
        assert_near(lf_gamma_q(0.5, x), erfc(sqrt(x)), 1e-14);
        assert_near(lf_gamma_q(3.0, x), exp(-x) * (1.0 + x + 0.5 * x * x), 1e-14);
    }
    assert_near(lf_gamma_q(500.0, 500.0), 0.49405285, 1e-7);
    assert_near(lf_p_chi2(18.307038, 10.0), 0.05, 1e-8);
}

static void students_t_has_its_closed_forms(void **state)
{
    (void)state;
    for (double t = -4.0; t <= 4.0; t += 0.5) {
        assert_near(lf_p_student(t, 1.0), 1.0 - 2.0 / M_PI * atan(fabs(t)), 1e-12);
        assert_near(lf_p_student(t, 2.0), 1.0 - fabs(t) / sqrt(2.0 + t * t), 1e-12);
        assert_near(lf_p_student(t, 1e7), lf_p_normal(t), 1e-6);
    }
    assert_near(lf_p_student(2.2281389, 10.0), 0.05, 1e-8);
}

/* Replicates of a quarter of the cycles have four times the variance: here t = 0.1 / sqrt(0.0041)
 * of 108 degrees. What is off by rounding is the same; a constant that is not is told. */
static void kept_means_are_compared_by_what_both_say_of_the_spread(void **state)
{
    (void)state;
    const lf_moments kept = {100, 1.0, 99 * 0.01}, drawn = {10, 1.1, 9 * 0.04},
                     narrow = {10, 1.1, 0.0}, far = {10, 1.4, 9 * 0.04}, sky = {100, 0.49, 1e-14},
                     rounded = {10, 0.49 + 3e-8, 0.0}, other = {10, 0.491, 0.0};
    assert_near(lf_kept_p(&drawn, &kept, 4.0), lf_p_student(0.1 / sqrt(0.0041), 108.0), 1e-12);
    assert_near(lf_kept_p(&drawn, &kept, 4.0), 0.121, 0.002);
    assert_true(lf_kept_p(&narrow, &kept, 4.0) > 0.05);
    assert_true(lf_kept_p(&far, &kept, 4.0) < 1e-7);
    assert_near(lf_kept_p(&rounded, &sky, 4.0), 1.0, 0.0);
    assert_true(lf_kept_p(&other, &sky, 4.0) < 1e-9);
}

static void sidak_shares_the_level_out(void **state)
{
    (void)state;
    assert_near(1.0 - pow(1.0 - lf_sidak(0.01, 100), 100.0), 0.01, 1e-12);
}

/* Counts of n throws onto cells of rising probability. */
static double throw_dice(uint64_t key, double tilt, int n)
{
    double observed[20] = {0}, expected[20];
    for (int i = 0; i < 20; i++)
        expected[i] = n * (2.0 * i + 1.0) / 400.0;
    lf_sampler s;
    lf_sampler_init(&s, LF_SAMPLER_INDEPENDENT, key, 0);
    for (int i = 0; i < n; i++)
        observed[(int)(20.0 * pow((double)lf_sampler_1d(&s), 0.5 + tilt))] += 1.0;
    return lf_chi2_p(observed, expected, 20);
}

/* Kolmogorov and Smirnov's distance of 1000 p-values from uniform exceeds 1.95 / sqrt(1000) once in
 * a thousand. */
static void p_values_are_uniform_when_the_pdf_is_right(void **state)
{
    (void)state;
    int below[101] = {0};
    for (int i = 0; i < 1000; i++) {
        double p = throw_dice(lf_hash64(lf_test_seed(), (uint64_t)i), 0.0, 2000);
        for (int j = (int)ceil(100.0 * p); j <= 100; j++)
            below[j]++;
    }
    for (int j = 0; j <= 100; j++)
        assert_near(below[j] / 1000.0, j / 100.0, 1.95 / sqrt(1000.0));
}

static void a_wrong_pdf_is_rejected(void **state)
{
    (void)state;
    assert_true(throw_dice(lf_test_seed(), 0.0, 200000) > 1e-6);
    assert_true(throw_dice(lf_test_seed(), 0.01, 200000) < 1e-6);
}

static void counts_where_nothing_is_expected_are_rejected(void **state)
{
    (void)state;
    double observed[3] = {500, 490, 10}, expected[3] = {500, 500, 0};
    assert_true(lf_chi2_p(observed, expected, 3) == 0.0);
}

static void low_cells_are_pooled(void **state)
{
    (void)state;
    double observed[82] = {500, 400}, expected[82] = {495, 400};
    for (int i = 2; i < 82; i++)
        expected[i] = 0.0625;
    /* The eighty small cells expect 5 together and saw none: two cells against one, chi^2 = 25/495
     * + 5. */
    assert_near(lf_chi2_p(observed, expected, 82), lf_p_chi2(25.0 / 495.0 + 5.0, 2.0), 1e-12);
}

static bool sample_hemisphere(const void *context, const float u[3], lf_vec3 *w)
{
    (void)context;
    float r = sqrtf(1.0f - u[0] * u[0]);
    *w = lf_v3(r * cosf(2.0f * LF_PI * u[1]), r * sinf(2.0f * LF_PI * u[1]), u[0]);
    return true;
}

static double hemisphere_pdf(const void *context, lf_vec3 w)
{
    double tilt = *(const double *)context;
    return w.z > 0.0f ? (1.0 + tilt * ((double)w.z - 0.5)) / (2.0 * M_PI) : 0.0;
}

static void directions_are_binned_about_any_axis(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        double tilt = i == 3 ? 0.1 : 0.0, mass;
        lf_vec3 axis = i == 1 ? lf_v3(0.0f, 0.6f, 0.8f) : lf_v3(0.0f, 0.0f, 1.0f);
        lf_chi2_sphere q = {sample_hemisphere,
                            hemisphere_pdf,
                            &tilt,
                            axis,
                            2.0,
                            i == 2 ? 12.0 : 0.1,
                            15,
                            30,
                            400000,
                            lf_test_seed()};
        double p = lf_chi2_sphere_p(&q, &mass);
        assert_near(mass, 1.0, 1e-3);
        if (i == 3)
            assert_true(p < 1e-6);
        else
            assert_true(p > lf_sidak(LF_FALSE_ALARM, 3));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gamma_function_has_its_closed_forms),
        cmocka_unit_test(students_t_has_its_closed_forms),
        cmocka_unit_test(kept_means_are_compared_by_what_both_say_of_the_spread),
        cmocka_unit_test(sidak_shares_the_level_out),
        cmocka_unit_test(p_values_are_uniform_when_the_pdf_is_right),
        cmocka_unit_test(a_wrong_pdf_is_rejected),
        cmocka_unit_test(counts_where_nothing_is_expected_are_rejected),
        cmocka_unit_test(low_cells_are_pooled),
        cmocka_unit_test(directions_are_binned_about_any_axis),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
