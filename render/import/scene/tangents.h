/* Frames for normal maps. One thread. */
#ifndef LF_RENDER_TANGENTS_H
#define LF_RENDER_TANGENTS_H

#include "render/import/scene/mesh_import.h"

/* Whether a material has a normal map. */
bool lf_mesh_wants_tangents(const lf_mesh_data *data);

/* Makes data->tangents of a mesh that is complete (lf_mesh_complete) and wants them; else there are
 * none afterwards. A tangent points to where the normal map's picture goes right, the bitangent to
 * where it goes up: each is the mean of a vertex's triangles, weighted by their angles there, of
 * those whose material has a normal map. Tangents that are there already (the file's) are kept
 * where they are usable, made unit and across the normal. A mesh without normals has those of its
 * faces in their stead: better give it normals. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_tangents(lf_mesh_data *data, lf_error *err);

#endif
