/* From coarse fits to fine ones and to N/W itself; private to render/reconstruct.
 *
 * x begins as the coarsest fit and goes on to each finer one by x += alpha (p - x), p its
 * prediction, alpha in [0, 1] the share of the step that the halves agree on: with d_h = p_h - x_h,
 * what half h would change, and g the other half,
 *
 *     alpha = sum_h sum d_h (N_g - W_g x_h) / sum (W_a + W_b) d^2,
 *
 * d in the denominator of both halves together, sums over the pixels around. Predictions are
 * linear, so that all of it follows from the moments of cells. The last step is to N/W itself.
 * docs/developer/reconstruction.md, "From coarse to fine". */
#ifndef LF_RENDER_RECONSTRUCT_SHRINK_H
#define LF_RENDER_RECONSTRUCT_SHRINK_H

#include "render/reconstruct/lattice.h"

/* A step is three passes over the bands of a level, one worker a band; each pass ends before the
 * next begins.
 *
 * 1. What the step of each cell from the level above to this one is worth. */
void lf_shrink_weigh(lf_reconstruction *r, int level, int number);
/* The same of the step from the finest level to what the past says, which knows the noise of
 * neither half (docs/developer/reconstruction-extensions.md, "A camera that moves"). */
void lf_shrink_weigh_past(lf_reconstruction *r, int number);
/* The same of the step from the finest level to N/W. */
void lf_shrink_weigh_raw(lf_reconstruction *r, int number);
/* For level 1: takes what its cells' children have found in place of its own. */
void lf_shrink_collect(lf_reconstruction *r, int number);
/* 2. The share of it that is taken, from the cells around. */
void lf_shrink_settle(lf_reconstruction *r, int level, int number);
/* The same of the step to N/W, with what could be chance left out; for level 1. */
void lf_shrink_settle_raw(lf_reconstruction *r, int number);
/* 3. Takes it. The finest level, the past and N/W go by the shares of level 1. */
void lf_shrink_take(lf_reconstruction *r, int level, int number);
void lf_shrink_take_past(lf_reconstruction *r, int number);
void lf_shrink_take_raw(lf_reconstruction *r, int number);
/* Of shares of the bounded fit (bright.h): those of level 1 between its cells, for level 0. */
void lf_shrink_take_bright(lf_reconstruction *r, int number);

#endif
