/* Tangent frames for the normal maps of the scene's own materials; private to render/. */
#ifndef LF_RENDER_SCENE_TANGENTS_H
#define LF_RENDER_SCENE_TANGENTS_H

#include "render/import/scene/mesh_import.h"

/* Makes data->tangents of a mesh if materials of the scene on it have normal maps. Tangents for the
 * file's own materials stay, except at corners of triangles of the others. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_scene_tangents(const lf_scene_desc *scene, const lf_mesh_desc *mesh,
                                         lf_mesh_data *data, lf_error *err);

/* Key of everything that determines them. A new reference; NULL = out of memory. */
json_t *lf_scene_tangents_key(const lf_scene_desc *scene, const lf_mesh_desc *mesh);

#endif
