/* Duplicate triangles; private to render/. */
#ifndef LF_RENDER_MESH_DOUBLES_H
#define LF_RENDER_MESH_DOUBLES_H

#include "render/import/scene/mesh_import.h"

/* Removes every triangle that has the same three corners, in any order, as an earlier one in the n
 * meshes. Rounding would decide which of the two a ray hits, and both would emit. The first stays.
 * Corners are the same if they round to the same 2^-40 of the largest distance from origin along an
 * axis. A mesh that loses triangles, possibly all, gets a warning, which begins with `where` and
 * lists names. LF_E_NOMEM: nothing is changed. *out_compared (may be NULL): number of compared
 * pairs; at most the number of triangles, except with a probability of 2^-32 per pair. */
LF_NODISCARD lf_status lf_mesh_drop_doubles(lf_mesh_data *data, int n, const double origin[3],
                                            const char *where, int64_t *out_compared);

#endif
