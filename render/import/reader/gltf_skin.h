/* Skins of glTF (specification, section 3.7.3.3). One thread. */
#ifndef LF_RENDER_GLTF_SKIN_H
#define LF_RENDER_GLTF_SKIN_H

#include "render/import/reader/gltf_node.h"
#include "render/import/reader/gltf_primitive.h"
#include "render/import/reader/mesh_build.h"

typedef struct lf_gltf_skin {
    size_t n;
    lf_affine *joints; /* [n]: from the bind pose to the world */
} lf_gltf_skin;

/* Opens skins[number]. LF_E_FORMAT, LF_E_NOMEM. Release with lf_gltf_skin_close, also after a
 * failure. */
LF_NODISCARD lf_status lf_gltf_skin_open(lf_gltf *gltf, const lf_gltf_nodes *nodes, uint32_t number,
                                         lf_gltf_skin *out, lf_error *err);
/* Accepts a zeroed struct. */
void lf_gltf_skin_close(lf_gltf_skin *skin);
/* The transform of a vertex: the weighted mean of its joints. */
lf_mesh_place lf_gltf_skin_node(const lf_gltf_skin *skin, const lf_gltf_primitive *primitive,
                                size_t vertex);

#endif
