/* Triangles that stand in one place; private to render/. */
#ifndef LF_RENDER_MESH_DOUBLES_H
#define LF_RENDER_MESH_DOUBLES_H

#include "render/import/scene/mesh_import.h"

/* Removes every triangle that has the three corners of one before it, in this mesh or another of
 * the n, in whatever order: which of the two a ray would find is a matter of rounding, while both
 * would shine. The first stays; corners are the same when they round to the same 2^-40 of the
 * largest distance from origin along an axis. A mesh that loses triangles gets a warning, which
 * begins with where and tells their names; it may be left with none. LF_E_NOMEM: nothing is
 * changed. *out_compared (may be NULL): how many pairs of triangles were compared, which is no more
 * than there are triangles, but for a chance in 2^32 a pair. */
LF_NODISCARD lf_status lf_mesh_drop_doubles(lf_mesh_data *data, int n, const double origin[3],
                                            const char *where, int64_t *out_compared);

#endif
