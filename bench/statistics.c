#include "bench/statistics.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;
    return (x > y) - (x < y);
}

lf_spread lf_spread_of(const double *values, int n)
{
    double sorted[LF_MAX_SEEDS];
    assert(n >= 1 && n <= LF_MAX_SEEDS);
    memcpy(sorted, values, (size_t)n * sizeof *values);
    qsort(sorted, (size_t)n, sizeof *sorted, compare_doubles);
    return (lf_spread){0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]), sorted[0], sorted[n - 1]};
}

/* P(-t < T < t) for whole degrees of freedom: Abramowitz and Stegun 26.7.3 and 26.7.4. */
static double student_within(double t, int degrees)
{
    double theta = atan(t / sqrt(degrees));
    double c = cos(theta);
    bool odd = degrees % 2 == 1;
    double term = odd ? c : 1;
    double sum = degrees > 1 ? term : 0;
    for (int k = odd ? 3 : 2; k < degrees; k += 2) {
        term *= c * c * (k - 1) / k;
        sum += term;
    }
    return odd ? 2 / M_PI * (theta + sin(theta) * sum) : sin(theta) * sum;
}

double lf_student_quantile(double p, int degrees)
{
    double low = 0;
    double high = 1;
    double within = fabs(2 * p - 1);
    assert(p > 0 && p < 1 && degrees >= 1);
    while (student_within(high, degrees) < within && high < 1e15)
        high *= 2;
    for (int i = 0; i < 100; i++) {
        double middle = 0.5 * (low + high);
        *(student_within(middle, degrees) < within ? &low : &high) = middle;
    }
    return p < 0.5 ? -high : high;
}

/* Mean of n numbers and its standard error; NaN for n < 2. */
static double mean_of(const double *values, int n, double *out_error)
{
    double sum = 0;
    double square = 0;
    for (int i = 0; i < n; i++)
        sum += values[i];
    for (int i = 0; i < n; i++)
        square += (values[i] - sum / n) * (values[i] - sum / n);
    *out_error = n > 1 ? sqrt(square / (n - 1) / n) : (double)NAN;
    return sum / n;
}

lf_interval lf_mean_interval(const double *values, int n, double confidence)
{
    double error;
    double mean = mean_of(values, n, &error);
    double half = n > 1 ? lf_student_quantile(0.5 + 0.5 * confidence, n - 1) * error : (double)NAN;
    return (lf_interval){mean, mean - half, mean + half};
}

/* False: one of them is not positive. */
static bool logs_of(const double *values, size_t stride, int n, double *out)
{
    for (int i = 0; i < n; i++) {
        double value = values[(size_t)i * stride];
        if (!(value > 0) || !isfinite(value))
            return false;
        out[i] = log(value);
    }
    return true;
}

lf_interval lf_log_interval(const double *values, int n, double confidence)
{
    double logs[LF_MAX_SEEDS];
    assert(n >= 1 && n <= LF_MAX_SEEDS);
    if (!logs_of(values, 1, n, logs))
        return (lf_interval){NAN, NAN, NAN};
    lf_interval of_logs = lf_mean_interval(logs, n, confidence);
    return (lf_interval){exp(of_logs.estimate), exp(of_logs.low), exp(of_logs.high)};
}

lf_fit lf_fit_line(const double *x, const double *y, int n)
{
    double unused;
    double mx = mean_of(x, n, &unused);
    double my = mean_of(y, n, &unused);
    double xx = 0;
    double xy = 0;
    double rest = 0;
    lf_fit line;
    for (int i = 0; i < n; i++) {
        xx += (x[i] - mx) * (x[i] - mx);
        xy += (x[i] - mx) * (y[i] - my);
    }
    line.slope = xy / xx;
    line.intercept = my - line.slope * mx;
    for (int i = 0; i < n; i++) {
        double d = y[i] - line.intercept - line.slope * x[i];
        rest += d * d;
    }
    line.error = n > 2 ? sqrt(rest / (n - 2) / xx) : (double)NAN;
    return line;
}

double lf_time_of_error(const double *times, const double *errors, int n, double error,
                        bool *out_beyond)
{
    double t[LF_MAX_SEEDS];
    double e[LF_MAX_SEEDS];
    int i = 0;
    assert(n >= 1 && n <= LF_MAX_SEEDS);
    *out_beyond = false;
    if (!(error > 0) || !logs_of(times, 1, n, t) || !logs_of(errors, 1, n, e))
        return NAN;
    double wanted = log(error);
    while (i + 1 < n &&
           !((e[i] >= wanted && wanted >= e[i + 1]) || (e[i] <= wanted && wanted <= e[i + 1])))
        i++;
    if (i + 1 < n && e[i] != e[i + 1])
        return exp(t[i] + (wanted - e[i]) / (e[i + 1] - e[i]) * (t[i + 1] - t[i]));
    *out_beyond = true;
    int end = wanted > e[0] ? 0 : n - 1;
    double distance = (wanted - e[end]) / lf_fit_line(t, e, n).slope;
    return fabs(distance) <= log(LF_BEYOND) ? exp(t[end] + distance) : (double)NAN;
}

void lf_correlation_add(lf_correlation *cross, size_t n, const float *a, const float *b,
                        const float *na, const float *nb)
{
    for (size_t i = 0; i < n; i++) {
        cross->ab += (double)a[i] * (double)b[i] - (double)na[i] * (double)nb[i];
        cross->aa += (double)a[i] * (double)a[i] - (double)na[i] * (double)na[i];
        cross->bb += (double)b[i] * (double)b[i] - (double)nb[i] * (double)nb[i];
    }
}

double lf_correlation_value(const lf_correlation *cross)
{
    if (!(cross->aa > 0) || !(cross->bb > 0))
        return NAN;
    return fmin(1, fmax(-1, cross->ab / sqrt(cross->aa * cross->bb)));
}

lf_tile_bound lf_worst_tile(const double *ratio, int n_seeds, int n_tiles, double confidence,
                            double must)
{
    lf_tile_bound bound = {.worst = -1, .low = INFINITY, .estimate = NAN, .least = INFINITY};
    double logs[LF_MAX_SEEDS];
    assert(n_seeds >= 1 && n_seeds <= LF_MAX_SEEDS);
    for (int i = 0; i < n_tiles; i++)
        bound.n_judged +=
            n_seeds >= LF_TILE_SEEDS && logs_of(ratio + i, (size_t)n_tiles, n_seeds, logs);
    if (bound.n_judged == 0)
        return (lf_tile_bound){.worst = -1, .low = NAN, .estimate = NAN, .least = NAN};
    double t = lf_student_quantile(pow(confidence, 1.0 / bound.n_judged), n_seeds - 1);
    for (int i = 0; i < n_tiles; i++) {
        double error;
        if (!logs_of(ratio + i, (size_t)n_tiles, n_seeds, logs))
            continue;
        double mean = mean_of(logs, n_seeds, &error);
        bound.least = fmin(bound.least, exp(mean));
        bound.n_surely_less += exp(mean + t * error) < must;
        if (exp(mean - t * error) < bound.low) {
            bound.low = exp(mean - t * error);
            bound.estimate = exp(mean);
            bound.worst = i;
        }
    }
    return bound;
}
