/* A mesh that stands in many places, as copies; private to render/. */
#ifndef LF_RENDER_MESH_REPEAT_H
#define LF_RENDER_MESH_REPEAT_H

#include "render/import/scene/mesh_import.h"

/* Triangles that copies may have. */
#define LF_MAX_REPEATED 4000000

/* Writes data out in each of its places, of which it has none from then on: for what lights are
 * made of, which know triangles alone. Mirrored places turn triangles round, as files that are
 * mirrored are. LF_E_NOMEM: more than LF_MAX_REPEATED triangles, or no memory; data is then
 * unchanged. */
LF_NODISCARD lf_status lf_mesh_repeat(lf_mesh_data *data);

#endif
