/* Probabilities for tests. A test that compares random numbers states how often it fails although
 * all is well: a program's false alarms are LF_FALSE_ALARM in all, shared out by Sidak's rule.
 * Seeds are fixed unless QUILTD_SEED says otherwise (make verify; lf_test_seed in testing.h), so
 * that a result repeats. */
#ifndef LF_TESTS_STAT_H
#define LF_TESTS_STAT_H

#include <stdint.h>

/* Probability that a program of tests fails by chance when run with a fresh seed. */
#define LF_FALSE_ALARM 1e-3

/* Level of each of n independent tests so that together they fail by chance with probability alpha.
 */
double lf_sidak(double alpha, int n);

/* Regularised upper incomplete gamma function Q(a, x), a > 0, x >= 0. */
double lf_gamma_q(double a, double x);
/* Regularised incomplete beta function I_x(a, b). */
double lf_beta_i(double a, double b, double x);

/* Two-sided p-values: of a standard normal variable, and of Student's t. */
double lf_p_normal(double z);
double lf_p_student(double t, double degrees);
/* P(chi^2 with this many degrees of freedom > x). */
double lf_p_chi2(double x, double degrees);

/* Running mean and variance (Welford). */
typedef struct lf_moments {
    double n, mean, m2;
} lf_moments;

static inline void lf_moments_add(lf_moments *m, double x)
{
    double d = x - m->mean;
    m->n += 1.0;
    m->mean += d / m->n;
    m->m2 += d * (x - m->mean);
}

/* Of the values, and of their mean. */
double lf_moments_variance(const lf_moments *m);
double lf_moments_error(const lf_moments *m);
/* p that a sample's mean is `truth`: Student's t. A sample without spread is compared for equality
 * (relative 1e-6). */
double lf_p_mean(const lf_moments *m, double truth);
/* p that two samples have one mean (Welch 1947). */
double lf_p_welch(const lf_moments *a, const lf_moments *b);

#endif
