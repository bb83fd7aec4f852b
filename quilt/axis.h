/* Private to quilt/: resampling along one axis of a picture. */
#ifndef LF_QUILT_AXIS_H
#define LF_QUILT_AXIS_H

#include "base/status.h"

/* Weighted source samples of each output sample along one axis. */
typedef struct lf_axis_filter {
    int n_out, max_taps;
    int *first;    /* [n_out] source index of the first tap */
    int *n_taps;   /* [n_out] 1..max_taps */
    float *weight; /* [n_out][max_taps], sum 1 */
    float *inside; /* [n_out] fraction of the sample's footprint inside the source, 0..1 */
} lf_axis_filter;

/* Output sample i covers `footprint` source samples around start + i * step. In source coordinates
 * sample s covers [s, s + 1]. Area average if footprint > 1, otherwise linear interpolation at the
 * middle; clamped to the source's n_in samples. */
LF_NODISCARD lf_status lf_axis_filter_init(lf_axis_filter *filter, int n_in, int n_out,
                                           double start, double step, double footprint);
void lf_axis_filter_finish(lf_axis_filter *filter);
/* Resamples a line of n_in RGB pixels to n_out. */
void lf_axis_filter_line(const lf_axis_filter *filter, const float *line, float *out);
/* The n output pixels from the first on alone; line has the same origin. */
void lf_axis_filter_part(const lf_axis_filter *filter, int first, int n, const float *line,
                         float *out);

#endif
