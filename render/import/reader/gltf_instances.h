/* EXT_mesh_gpu_instancing: many instances of a mesh in one node. One thread. */
#ifndef LF_RENDER_GLTF_INSTANCES_H
#define LF_RENDER_GLTF_INSTANCES_H

#include "render/import/reader/gltf_accessor.h"
#include "render/scene/affine.h"

#define LF_GLTF_INSTANCING "EXT_mesh_gpu_instancing"

typedef struct lf_gltf_instances {
    size_t n;
    lf_gltf_accessor translation, rotation, scale; /* each is optional */
} lf_gltf_instances;

/* For a node with the extension. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_instances_open(lf_gltf *gltf, const json_t *node,
                                              lf_gltf_instances *out, lf_error *err);
/* The transform of an instance in its node. */
lf_affine lf_gltf_instance(const lf_gltf_instances *instances, size_t number);

#endif
