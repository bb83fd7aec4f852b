/* Tangent frames for normal maps. One thread. */
#ifndef LF_RENDER_TANGENTS_H
#define LF_RENDER_TANGENTS_H

#include "render/import/scene/mesh_import.h"

/* Whether a material has a normal map. */
bool lf_mesh_wants_tangents(const lf_mesh_data *data);

/* Makes data->tangents of a complete mesh (lf_mesh_complete) that needs them; otherwise it has none
 * afterwards. A tangent points to the right in the normal map's image, the bitangent up. Each is
 * the mean over a vertex's triangles whose material has a normal map, weighted by their angles
 * there. Usable tangents of the file are kept, normalised and made perpendicular to the normal. A
 * mesh without normals uses face normals instead, so give it normals first. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_tangents(lf_mesh_data *data, lf_error *err);

#endif
