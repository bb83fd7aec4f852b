/* Instancing for meshes of a glTF file that are shown more than once (the parts of lf_mesh_data),
 * if there would be many copies. One thread. */
#ifndef LF_RENDER_GLTF_SHARE_H
#define LF_RENDER_GLTF_SHARE_H

#include "render/import/reader/gltf_build.h"

/* Up to this number of triangles, copies are made instead. */
#define LF_GLTF_COPIED 1000000

/* Whether a file of build->n_triangles (counted per use) should be instanced: nothing in it moves,
 * deforms or emits, and at least one mesh is shown twice. */
bool lf_gltf_is_shared(lf_gltf_build *build);

/* lf_gltf_visit for each mesh once, in its own space. parts (may be NULL): receives the position of
 * each of the file's meshes in build->data. */
LF_NODISCARD lf_status lf_gltf_visit_once(lf_gltf_build *build, lf_gltf_visit_fn *visit,
                                          lf_mesh_part *parts, lf_error *err);

/* Makes the parts and instances of build->data, which it owns. Instances with a singular transform,
 * or too far away, are dropped with a warning. LF_E_FORMAT: all are dropped. LF_E_NOMEM: more than
 * LF_MAX_INSTANCES. */
LF_NODISCARD lf_status lf_gltf_put_instances(lf_gltf_build *build, const lf_mesh_part *parts,
                                             lf_error *err);

#endif
