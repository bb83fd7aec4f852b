/* Meshes into Embree; private to render/. */
#ifndef LF_RENDER_GEOMETRY_BUILD_H
#define LF_RENDER_GEOMETRY_BUILD_H

#include "render/import/scene/mesh_import.h"

/* Key of everything that determines the meshes' geometry, except the time of animations. It
 * includes order, names, files, shapes, transforms, normals, the animation, and whether each mesh
 * has a material of the scene. Of the material it includes only the needed vertex data, and it
 * excludes whether a mesh is a catcher. It also includes the shapes of desc's area lights. A new
 * reference; NULL = out of memory. */
json_t *lf_geometry_key(const json_t *doc, const lf_scene_desc *desc, const char *folder);
/* The key of geometry that moves between two keys; consumes both; one may be NULL. If they are
 * equal, it is the first. */
json_t *lf_geometry_key_between(json_t *open, json_t *close);

/* Whether geometry was made from the same key, its animations are at the times of the ends, and its
 * files, opened again under roots, are unchanged. */
bool lf_geometry_matches(const lf_geometry *geometry, const json_t *key, lf_ends ends,
                         const lf_roots *roots);

/* Builds Embree's geometry from the vertices of the meshes of ends[0], with origin subtracted in
 * double. Consumes data (arrays are moved; the caller releases the rest). Takes a reference to key.
 * LF_E_NOMEM. On LF_OK the caller owns a reference. */
LF_NODISCARD lf_status lf_geometry_build(lf_mesh_data *data, lf_ends ends, const double origin[3],
                                         json_t *key, lf_geometry **out_geometry, lf_error *err);

#endif
