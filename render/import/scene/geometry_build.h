/* Meshes into Embree; private to render/. */
#ifndef LF_RENDER_GEOMETRY_BUILD_H
#define LF_RENDER_GEOMETRY_BUILD_H

#include "render/import/scene/mesh_import.h"

/* What decides about the meshes' shape, but for the moment of what moves: their order, names,
 * files, shapes, transforms, normals, and whether each has a material of its own (which one it is
 * does not matter, but what it needs of vertices does), which animation (but not whether it is a
 * catcher); and what the lights of desc that are faces look like. A new reference; NULL = out of
 * memory. */
json_t *lf_geometry_key(const json_t *doc, const lf_scene_desc *desc, const char *folder);
/* That of geometry which moves from one key to the other; uses up both, of which one may be NULL.
 * It is the first one where they are equal. */
json_t *lf_geometry_key_between(json_t *open, json_t *close);

/* Whether geometry was made from the same key, what moves in its files stands where the ends have
 * it, and its files, opened again under roots, are unchanged. */
bool lf_geometry_matches(const lf_geometry *geometry, const json_t *key, lf_ends ends,
                         const lf_roots *roots);

/* Takes the vertices of the meshes of ends[0] into Embree, origin subtracted in double. data is
 * used up (arrays are taken over, the rest released by the caller); key gets a reference more.
 * LF_E_NOMEM. On LF_OK the caller owns a reference. */
LF_NODISCARD lf_status lf_geometry_build(lf_mesh_data *data, lf_ends ends, const double origin[3],
                                         json_t *key, lf_geometry **out_geometry, lf_error *err);

#endif
