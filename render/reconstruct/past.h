/* The last fit of a rig as a first guess for another one's: nodes of the finest lattice, looked up
 * where the old rig saw the place; private to render/reconstruct.
 * docs/developer/reconstruction-extensions.md, "A camera that moves". */
#ifndef LF_RENDER_RECONSTRUCT_PAST_H
#define LF_RENDER_RECONSTRUCT_PAST_H

#include "render/reconstruct/lattice.h"

/* What the past of r says about a cell of the finest lattice, as seen from its middle; false: it
 * has no node near, and out is undefined. Thread: any. */
bool lf_past_recall(const lf_reconstruction *r, int number, const lf_cell *cell, lf_plane out[3]);

#endif
