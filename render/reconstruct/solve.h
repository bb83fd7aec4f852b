/* Fits; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_SOLVE_H
#define LF_RENDER_RECONSTRUCT_SOLVE_H

#include "render/reconstruct/lattice.h"

/* Fits the nodes of a band: of each half and of both, from the neighbouring cells. */
void lf_solve_band(lf_reconstruction *r, int level, int number);

#endif
