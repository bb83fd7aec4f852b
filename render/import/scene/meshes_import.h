/* Imports all meshes of a scene, several at once; private to render/. */
#ifndef LF_RENDER_MESHES_IMPORT_H
#define LF_RENDER_MESHES_IMPORT_H

#include "render/import/scene/mesh_import.h"

/* Fills zeroed data[ends[0]->n_meshes], from files by lf_mesh_import and from shapes by
 * lf_mesh_shape_make, with the names of ends[0]. Release each with lf_mesh_data_finish, also after
 * a failure. A mesh that differs at shutter close is read a second time. If it then has different
 * triangles, it is static and gets a warning. On failure, *out_wrong is the first failing mesh in
 * the scene's order, and status and error are its own. *out_wrong is unchanged without memory for
 * all of them: LF_E_NOMEM. */
LF_NODISCARD lf_status lf_meshes_import(lf_ends ends, const lf_scene_file *file,
                                        const lf_roots *roots, lf_mesh_data *data, int *out_wrong,
                                        lf_error *err);

#endif
