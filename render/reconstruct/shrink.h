/* From coarse fits to fine ones and to N/W itself; private to render/reconstruct.
 *
 * x starts as the coarsest fit and is updated for each finer one by x += alpha (p - x), p its
 * prediction. alpha in [0, 1] is the share of the step that the halves agree on. With d_h = p_h -
 * x_h, the change by half h, and g the other half,
 *
 *     alpha = sum_h sum d_h (N_g - W_g x_h) / sum (W_a + W_b) d^2,
 *
 * d in the denominator is of both halves together; sums are over the neighbouring pixels.
 * Predictions are linear, so everything follows from the moments of cells. The last step is to N/W
 * itself. docs/developer/reconstruction.md, "From coarse to fine". */
#ifndef LF_RENDER_RECONSTRUCT_SHRINK_H
#define LF_RENDER_RECONSTRUCT_SHRINK_H

#include "render/reconstruct/lattice.h"

/* A step is three passes over the bands of a level, one worker per band; each pass ends before the
 * next begins.
 *
 * 1. The value of the step of each cell from the level above to this one. */
void lf_shrink_weigh(lf_reconstruction *r, int level, int number);
/* lf_shrink_weigh for the step from the finest level to the past, which does not depend on the
 * noise of either half (docs/developer/reconstruction-extensions.md, "A camera that moves"). */
void lf_shrink_weigh_past(lf_reconstruction *r, int number);
/* lf_shrink_weigh for the step from the finest level to N/W. */
void lf_shrink_weigh_raw(lf_reconstruction *r, int number);
/* For level 1: replaces the sums of its cells by the sums of their children. */
void lf_shrink_collect(lf_reconstruction *r, int number);
/* 2. The share of the step that is applied, from the neighbouring cells. */
void lf_shrink_settle(lf_reconstruction *r, int level, int number);
/* lf_shrink_settle for the step to N/W, without the part that may be chance; for level 1. */
void lf_shrink_settle_raw(lf_reconstruction *r, int number);
/* 3. Applies it. The finest level, the past and N/W use the shares of level 1. */
void lf_shrink_take(lf_reconstruction *r, int level, int number);
void lf_shrink_take_past(lf_reconstruction *r, int number);
void lf_shrink_take_raw(lf_reconstruction *r, int number);
/* For shares of the bounded fit (bright.h): interpolates the shares of level 1 for level 0. */
void lf_shrink_take_bright(lf_reconstruction *r, int number);

#endif
