/* All meshes of a scene, several at once; private to render/. */
#ifndef LF_RENDER_MESHES_IMPORT_H
#define LF_RENDER_MESHES_IMPORT_H

#include "render/import/scene/mesh_import.h"

/* Fills zeroed data[ends[0]->n_meshes], files by lf_mesh_import and shapes by lf_mesh_shape_make,
 * with the names of ends[0]; each is released with lf_mesh_data_finish in any case. What is
 * elsewhere when the shutter closes is read a second time; where that comes to other triangles the
 * mesh stands still, and has a warning. The first in the scene's order that fails is *out_wrong,
 * and its status and error are what comes back; that stays untouched where there is no memory for
 * all of them: LF_E_NOMEM. */
LF_NODISCARD lf_status lf_meshes_import(lf_ends ends, const lf_scene_file *file,
                                        const lf_roots *roots, lf_mesh_data *data, int *out_wrong,
                                        lf_error *err);

#endif
