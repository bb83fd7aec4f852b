/* The last fit of a rig as a first guess for another rig's fit: nodes of the finest lattice, looked
 * up at the position seen by the old rig; private to render/reconstruct.
 * docs/developer/reconstruction-extensions.md, "A camera that moves". */
#ifndef LF_RENDER_RECONSTRUCT_PAST_H
#define LF_RENDER_RECONSTRUCT_PAST_H

#include "render/reconstruct/lattice.h"

/* The past of r at a cell of the finest lattice, relative to the cell's middle; false: it has no
 * node near, and out is undefined. Thread: any. */
bool lf_past_recall(const lf_reconstruction *r, int number, const lf_cell *cell, lf_plane out[3]);

#endif
