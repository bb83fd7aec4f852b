/* Materials of files that Assimp reads. */
#ifndef LF_RENDER_ASSIMP_MATERIAL_H
#define LF_RENDER_ASSIMP_MATERIAL_H

#include "render/import/reader/source_material.h"

struct aiScene;

/* Converts the file's materials to out->materials, in the file's order, and adds warnings about
 * features of used materials that are lost: textures, transparency, … Materials that Assimp invents
 * for meshes without one become grey. LF_E_FORMAT: too many; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_materials(const struct aiScene *scene, lf_mesh_data *out,
                                         lf_error *err);

#endif
