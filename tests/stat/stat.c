#include "tests/stat/stat.h"

#include <math.h>

double lf_sidak(double alpha, int n)
{
    return -expm1(log1p(-alpha) / n);
}

/* Below x = a + 1 the series of the lower function converges, above it the continued fraction of
 * the upper one (Abramowitz and Stegun 6.5.29, 6.5.31; the fraction evaluated forwards after
 * Lentz). */
double lf_gamma_q(double a, double x)
{
    if (!(x > 0.0))
        return 1.0;
    double scale = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double k = a + 1.0; term > sum * 1e-16; k += 1.0)
            sum += term *= x / k;
        return 1.0 - sum * scale;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for (int i = 1; i < 100000; i++) {
        double an = -(double)i * (i - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        double step = c * d;
        h *= step;
        if (fabs(step - 1.0) < 1e-15)
            break;
    }
    return h * scale;
}

/* Continued fraction of Abramowitz and Stegun 26.5.8, for x < (a + 1) / (a + b + 2). */
static double beta_fraction(double a, double b, double x)
{
    double c = 1.0, d = 1.0 / (1.0 - (a + b) * x / (a + 1.0)), h = d;
    for (int m = 1; m < 10000; m++) {
        double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / (1.0 + even * d);
        c = 1.0 + even / c;
        h *= c * d;
        double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / (1.0 + odd * d);
        c = 1.0 + odd / c;
        h *= c * d;
        if (fabs(c * d - 1.0) < 1e-15)
            break;
    }
    return h;
}

double lf_beta_i(double a, double b, double x)
{
    if (!(x > 0.0))
        return 0.0;
    if (!(x < 1.0))
        return 1.0;
    double scale = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));
    if (x < (a + 1.0) / (a + b + 2.0))
        return scale * beta_fraction(a, b, x) / a;
    return 1.0 - scale * beta_fraction(b, a, 1.0 - x) / b;
}

double lf_p_normal(double z)
{
    return erfc(fabs(z) * sqrt(0.5));
}

double lf_p_student(double t, double degrees)
{
    return lf_beta_i(0.5 * degrees, 0.5, degrees / (degrees + t * t));
}

double lf_p_chi2(double x, double degrees)
{
    return lf_gamma_q(0.5 * degrees, 0.5 * x);
}

double lf_moments_variance(const lf_moments *m)
{
    return m->n > 1.0 ? m->m2 / (m->n - 1.0) : 0.0;
}

double lf_moments_error(const lf_moments *m)
{
    return sqrt(lf_moments_variance(m) / m->n);
}

static double p_constant(double a, double b)
{
    return fabs(a - b) <= 1e-6 * fmax(fabs(a), fabs(b)) ? 1.0 : 0.0;
}

double lf_p_mean(const lf_moments *m, double truth)
{
    double error = lf_moments_error(m);
    if (!(error > 1e-12 * fabs(m->mean)))
        return p_constant(m->mean, truth);
    return lf_p_student((m->mean - truth) / error, m->n - 1.0);
}

double lf_p_welch(const lf_moments *a, const lf_moments *b)
{
    double va = lf_moments_variance(a) / a->n, vb = lf_moments_variance(b) / b->n, v = va + vb;
    if (!(sqrt(v) > 1e-12 * fmax(fabs(a->mean), fabs(b->mean))))
        return p_constant(a->mean, b->mean);
    double degrees = v * v / (va * va / (a->n - 1.0) + vb * vb / (b->n - 1.0));
    return lf_p_student((a->mean - b->mean) / sqrt(v), degrees);
}
