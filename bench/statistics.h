/* The statistics of quiltbench: estimates of errors from a few independent runs. Pure functions.
 *
 * Every run has its own seed; only runs are independent. Views of one run share paths and pixels
 * share rows, so they are never counted as independent.
 *
 * Errors and ratios of errors are positive and skewed. Intervals are therefore Student's t on their
 * logarithms: for n values, the geometric mean times exp(+- t s / sqrt(n)). NaN if no estimate is
 * possible: fewer than two values, or one that is not positive (the reference is then too noisy for
 * the measurement). */
#ifndef LF_BENCH_STATISTICS_H
#define LF_BENCH_STATISTICS_H

#include <stdbool.h>
#include <stddef.h>

#define LF_MAX_SEEDS 128
/* The worst tile is reported for at least this many seeds. */
#define LF_TILE_SEEDS 80

/* n values, 1..LF_MAX_SEEDS. */
typedef struct lf_spread {
    double median, low, high;
} lf_spread;
lf_spread lf_spread_of(const double *values, int n);

/* The p-quantile of Student's t with whole degrees of freedom >= 1, 0 < p < 1. */
double lf_student_quantile(double p, int degrees);

typedef struct lf_interval {
    double estimate, low, high;
} lf_interval;
/* Two-sided interval of the values' expected logarithm, converted back to the scale of the
 * values. */
lf_interval lf_log_interval(const double *values, int n, double confidence);
/* Two-sided interval of the expected value itself. */
lf_interval lf_mean_interval(const double *values, int n, double confidence);

/* y = intercept + slope x by least squares; error is the slope's standard error from the residuals
 * (NaN for n < 3). */
typedef struct lf_fit {
    double slope, intercept, error;
} lf_fit;
lf_fit lf_fit_line(const double *x, const double *y, int n);

/* The time at which a curve of errors over rising times reaches `error`. Interpolates linearly in
 * log-log between points. Beyond the ends it uses the slope of the line fitted to all points,
 * through the end point, for at most LF_BEYOND times the end's time. NaN: not reached, or a point
 * is not positive. */
#define LF_BEYOND 4.0
double lf_time_of_error(const double *times, const double *errors, int n, double error,
                        bool *out_beyond);

/* Sums for the correlation of two errors a, b about 0 (their expected value). The contribution of
 * the reference's own errors na, nb is subtracted. */
typedef struct lf_correlation {
    double ab, aa, bb;
} lf_correlation;
void lf_correlation_add(lf_correlation *cross, size_t n, const float *a, const float *b,
                        const float *na, const float *nb);
/* -1..1; NaN if one of the two has no error beyond the reference's. */
double lf_correlation_value(const lf_correlation *cross);

/* The worst of many tiles. ratio [n_seeds][n_tiles]: > 1 is better. Each tile has a one-sided
 * Student bound over the seeds, on the logarithm, at a level that holds for all tiles at once
 * (Sidak). A tile is judged only if its ratio is positive for every seed. With fewer than
 * LF_TILE_SEEDS seeds none is judged: for heavy-tailed errors, the bounds of hundreds of tiles
 * would need more standard errors than so few seeds give. */
typedef struct lf_tile_bound {
    int n_judged;
    int worst;         /* the tile with the lowest lower bound; -1 = none was judged */
    double low;        /* its lower bound */
    double estimate;   /* geometric mean of its ratios */
    double least;      /* lowest geometric mean of all tiles */
    int n_surely_less; /* tiles whose upper bound is below `must` */
} lf_tile_bound;
lf_tile_bound lf_worst_tile(const double *ratio, int n_seeds, int n_tiles, double confidence,
                            double must);

#endif
