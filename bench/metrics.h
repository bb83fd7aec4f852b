/* Error metrics of a picture against a reference: the numbers of `quiltbench error`.
 *
 * All use linear float RGB, every channel of every pixel with equal weight. r is the reference, x
 * the picture:
 * - relMSE: mean of (x - r)^2 / (r^2 + epsilon).
 * - bias: mean of x - r. Its standard error is estimated from the scatter of N x N blocks, because
 *   neighbouring pixels share paths.
 * - blocks: root mean square of (X - R) / R over whole N x N blocks with means X and R. R^2 is
 *   raised by 1e-4 times the squared mean of the reference, so that black blocks do not divide
 *   by 0.
 *
 * Pixels that are not finite in either picture are counted and skipped. Pure; an lf_metrics belongs
 * to one thread. */
#ifndef LF_BENCH_METRICS_H
#define LF_BENCH_METRICS_H

#include "base/image.h"

#define LF_WORST_BLOCKS 5

typedef struct lf_worst_block {
    int view, x, y; /* pixel of the top left corner */
    double relative, picture, reference;
} lf_worst_block;

typedef struct lf_metrics {
    /* parameters */
    int block; /* N */
    double epsilon;
    /* results, valid after lf_metrics_finish */
    int64_t n_pixels;    /* finite in both */
    int64_t n_nonfinite; /* in the picture */
    int64_t n_nonfinite_reference;
    int64_t n_holes; /* exactly black in the picture but not in the reference */
    int64_t n_blocks;
    double picture_mean, reference_mean;
    double relative_mean; /* picture_mean / reference_mean - 1 */
    double bias, bias_se;
    double rmse, rel_mse;
    double block_rms;
    int n_worst;
    lf_worst_block worst[LF_WORST_BLOCKS]; /* largest |relative| first */
    /* sums while adding */
    double sum_square, sum_relative, sum_picture, sum_reference;
    size_t n_stored;
    struct lf_block_mean *stored; /* owned until finish */
    size_t capacity;
} lf_metrics;

void lf_metrics_begin(lf_metrics *metrics, int block, double epsilon);
/* Adds one view: width x height pixels of 3 floats, rows `stride` floats apart. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_metrics_add(lf_metrics *metrics, int view, int width, int height,
                                      const float *reference, size_t reference_stride,
                                      const float *picture, size_t picture_stride);
/* Computes the results and releases memory. Call it after a failed add too. */
void lf_metrics_finish(lf_metrics *metrics);

#endif
