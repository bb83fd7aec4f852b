/* Meshes of a glTF file that are shown more than once, kept once with their places (the parts of
 * lf_mesh_data), where copies would be many. One thread. */
#ifndef LF_RENDER_GLTF_SHARE_H
#define LF_RENDER_GLTF_SHARE_H

#include "render/import/reader/gltf_build.h"

/* Triangles up to which copies are made all the same. */
#define LF_GLTF_COPIED 1000000

/* Whether a file of build->n_triangles, counted wherever they are shown, is better kept so: nothing
 * in it moves, bends or shines, and not every mesh that is shown is another. */
bool lf_gltf_is_shared(lf_gltf_build *build);

/* lf_gltf_visit of each mesh once, as it stands by itself. parts (may be NULL): of the file's
 * meshes, where each was put in build->data. */
LF_NODISCARD lf_status lf_gltf_visit_once(lf_gltf_build *build, lf_gltf_visit_fn *visit,
                                          lf_mesh_part *parts, lf_error *err);

/* Makes parts and places of build->data, which are its own; those that flatten space, or lie too
 * far away, are left out with a warning. LF_E_FORMAT: all are. LF_E_NOMEM: more than
 * LF_MAX_INSTANCES.
 */
LF_NODISCARD lf_status lf_gltf_put_instances(lf_gltf_build *build, const lf_mesh_part *parts,
                                             lf_error *err);

#endif
