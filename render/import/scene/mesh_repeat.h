/* Converts instances of a mesh to copies; private to render/. */
#ifndef LF_RENDER_MESH_REPEAT_H
#define LF_RENDER_MESH_REPEAT_H

#include "render/import/scene/mesh_import.h"

/* Maximum number of triangles of the copies. */
#define LF_MAX_REPEATED 4000000

/* Replaces data by one copy per instance; afterwards it has no instances. For emissive meshes,
 * because lights support only plain triangles. Mirrored instances reverse triangles, as for
 * mirrored files. LF_E_NOMEM: more than LF_MAX_REPEATED triangles, or no memory; data is then
 * unchanged. */
LF_NODISCARD lf_status lf_mesh_repeat(lf_mesh_data *data);

#endif
