/* Times of repetitions, and what quiltbench says of them. */
#ifndef LF_BENCH_TIMING_H
#define LF_BENCH_TIMING_H

#define LF_TIMING_MAX 1000

typedef struct lf_timing {
    int n;
    double value[LF_TIMING_MAX];
} lf_timing;

/* At most LF_TIMING_MAX; those behind are dropped. */
void lf_timing_add(lf_timing *timing, double value);
/* The smallest value that a share of all values (0..1) does not pass, by the nearest rank: 0.5 =
 * the median, 0 = the smallest. NaN where there is none. */
double lf_timing_quantile(const lf_timing *timing, double share);

#endif
