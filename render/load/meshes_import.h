/* All meshes of a scene, several at once; private to render/. */
#ifndef LF_RENDER_MESHES_IMPORT_H
#define LF_RENDER_MESHES_IMPORT_H

#include "render/load/mesh_import.h"

/* Fills zeroed data[desc->n_meshes], files by lf_mesh_import and shapes by lf_mesh_shape_make, with
 * the names of desc; each is released with lf_mesh_data_finish in any case. The first in the
 * scene's order that fails is *out_wrong, and its status and error are what comes back; that stays
 * untouched where there is no memory for all of them: LF_E_NOMEM. */
LF_NODISCARD lf_status lf_meshes_import(const lf_scene_desc *desc, const char *folder,
                                        const lf_roots *roots, lf_mesh_data *data, int *out_wrong,
                                        lf_error *err);

#endif
