/* Fits; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_SOLVE_H
#define LF_RENDER_RECONSTRUCT_SOLVE_H

#include "render/reconstruct/lattice.h"

/* Least squares of N/W on features with the weights W, a plane a channel, from where the moments
 * are seen. Features are centred and scaled to a variance of about 1; ridge 4/W + 1e-3 (W counts
 * pivots). depth: of a finest cell, in
 * pixels at Z = D. Without weight: 0. */
void lf_solve(const lf_moments *moments, double depth, lf_plane out[3]);

/* The nodes of a band: each half and both, from the cells around. */
void lf_solve_band(lf_reconstruction *r, int level, int number);

#endif
