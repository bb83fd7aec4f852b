/* Materials of mesh files; private to render/reader/mesh_*.c. */
#ifndef LF_RENDER_ASSIMP_MATERIAL_H
#define LF_RENDER_ASSIMP_MATERIAL_H

#include "render/reader/reader.h"

struct aiScene;

/* Makes out->materials of the file's materials, in its order, and a warning of everything that
 * those of triangles lose: textures, transparency, … Materials that Assimp makes up for meshes
 * without one become grey. LF_E_FORMAT: too many; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_materials(const struct aiScene *scene, lf_mesh_data *out,
                                         lf_error *err);

/* A warning of materials that triangles of an OBJ file name and none of its libraries has, the
 * files that were opened behind it: Assimp makes them up, grey. Where no library could be read
 * there is a warning of that already. */
void lf_mesh_warn_of_libraries(const struct aiScene *scene, const lf_mesh_reading *reading,
                               lf_mesh_data *data);

#endif
