/* Fits; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_SOLVE_H
#define LF_RENDER_RECONSTRUCT_SOLVE_H

#include "render/reconstruct/lattice.h"

/* The nodes of a band: each half and both, from the cells around. */
void lf_solve_band(lf_reconstruction *r, int level, int number);

#endif
