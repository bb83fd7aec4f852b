/* The error of the denoised image; private to render/. docs/developer/reconstruction.md, "The
 * stated error", has the formulas. */
#ifndef LF_RENDER_SHOWN_ERROR_H
#define LF_RENDER_SHOWN_ERROR_H

#include "render/reconstruct/reconstruct.h"

/* The contribution of one row. p_h is the shown image by half h alone, and y_h = B + q x + (N - W
 * x)/n of the half, x the prediction of its fit. Means over the fitted view pixels and channels,
 * divided by an estimate of I^2 + 1e-2. */
typedef struct lf_shown_row {
    double variance; /* of s_a s_b (p_a - p_b)^2, s the halves' shares of the samples */
    double bias;     /* of (y_a - p_a) (y_b - p_b) */
} lf_shown_row;

/* Correction of the bias because shares follow the noise. likely: what a cell adds to its own
 * share, times its difference from the value that all neighbouring cells, including itself, give.
 * most: from the value that the others give. */
typedef struct lf_shown_chosen {
    double likely, most;
} lf_shown_chosen;

/* rows [n]: an upper bound of the relMSE of the shown image at confidence 1 - alpha; *out_estimate
 * is its estimate. */
double lf_shown_error_bound(const lf_shown_row *rows, int n, const lf_shown_chosen *chosen,
                            double alpha, double *out_estimate);

/* lf_shown_error_bound for the rows of a film by the last fit, on the pool. Negative, and
 * *out_estimate too: there is no fit, a half has not visited a row, no memory, or cancelled. Not
 * while rows are visited. */
double lf_reconstruct_error(lf_reconstruction *r, const lf_film *film, double alpha,
                            double *out_estimate, const lf_cancel *cancel);

#endif
