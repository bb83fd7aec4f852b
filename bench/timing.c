#include "bench/timing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void lf_timing_add(lf_timing *timing, double value)
{
    if (timing->n < LF_TIMING_MAX)
        timing->value[timing->n++] = value;
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;
    return (x > y) - (x < y);
}

double lf_timing_quantile(const lf_timing *timing, double share)
{
    double sorted[LF_TIMING_MAX];
    int rank = (int)ceil(share * timing->n) - 1;
    if (timing->n == 0)
        return NAN;
    memcpy(sorted, timing->value, (size_t)timing->n * sizeof *sorted);
    qsort(sorted, (size_t)timing->n, sizeof *sorted, rising);
    return sorted[rank < 0 ? 0 : rank < timing->n ? rank : timing->n - 1];
}
