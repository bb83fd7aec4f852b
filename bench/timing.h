/* Times of repetitions, and their quantiles. */
#ifndef LF_BENCH_TIMING_H
#define LF_BENCH_TIMING_H

#define LF_TIMING_MAX 1000

typedef struct lf_timing {
    int n;
    double value[LF_TIMING_MAX];
} lf_timing;

/* Adds a value; values after LF_TIMING_MAX are dropped. */
void lf_timing_add(lf_timing *timing, double value);
/* The quantile by nearest rank: the smallest value with at least `share` (0..1) of all values not
 * above it. 0.5 = the median, 0 = the smallest. NaN: no values. */
double lf_timing_quantile(const lf_timing *timing, double share);

#endif
