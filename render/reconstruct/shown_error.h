/* How far the shown picture is from the truth; private to render/.
 * docs/developer/reconstruction.md, "The stated error", has the formulas. */
#ifndef LF_RENDER_SHOWN_ERROR_H
#define LF_RENDER_SHOWN_ERROR_H

#include "render/reconstruct/reconstruct.h"

/* What one row tells, with p_h the shown picture by half h alone and y_h = B + q x + (N - W x)/n of
 * the half, x what its fit says: means over the view pixels that are fitted, and channels, over
 * what stands for I^2 + 1e-2. */
typedef struct lf_shown_row {
    double variance; /* of s_a s_b (p_a - p_b)^2, s the halves' shares of the samples */
    double bias;     /* of (y_a - p_a) (y_b - p_b) */
} lf_shown_row;

/* What the bias lacks because shares follow the noise: what a cell adds to its own share, times how
 * far it is from what all cells around say of it, itself among them; at most: from what the others
 * say. */
typedef struct lf_shown_chosen {
    double likely, most;
} lf_shown_chosen;

/* rows [n]: an upper bound of the relMSE of the shown picture at confidence 1 - alpha;
 * *out_estimate gets its estimate. */
double lf_shown_error_bound(const lf_shown_row *rows, int n, const lf_shown_chosen *chosen,
                            double alpha, double *out_estimate);

/* The same of the rows of a film by the last fit, on the pool. Negative, and *out_estimate too:
 * there is no fit, a half has not visited a row, no memory, or it was cancelled. Not while rows are
 * visited. */
double lf_reconstruct_error(lf_reconstruction *r, const lf_film *film, double alpha,
                            double *out_estimate, const lf_cancel *cancel);

#endif
