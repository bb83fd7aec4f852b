/* Nodes of a glTF file: which ones the default scene shows, and their transforms at a time of an
 * animation (specification, sections 3.5 and 3.11). One thread. */
#ifndef LF_RENDER_GLTF_NODE_H
#define LF_RENDER_GLTF_NODE_H

#include "render/import/reader/gltf_accessor.h"
#include "render/import/scene/clip.h"
#include "render/scene/affine.h"

typedef struct lf_gltf_pose {
    float translation[3], rotation[4], scale[3];
} lf_gltf_pose;
#define LF_GLTF_AT_REST                                                                            \
    {                                                                                              \
        .rotation = {0, 0, 0, 1}, .scale = { 1, 1, 1 }                                             \
    }

/* Applies the scale first, the translation last. */
lf_affine lf_gltf_transform(const lf_gltf_pose *pose);

typedef struct lf_gltf_node {
    bool is_shown, has_matrix;
    /* by KHR_node_visibility, of the node or of a parent: its mesh and its light are disabled */
    bool is_hidden;
    lf_gltf_pose pose;
    lf_affine matrix; /* replaces the pose */
    lf_affine to_world;
    uint32_t parent;     /* LF_GLTF_NONE */
    uint32_t mesh, skin; /* LF_GLTF_NONE */
    size_t n_weights;    /* of morph targets; 0: not animated */
    float *weights;
} lf_gltf_node;

typedef struct lf_gltf_nodes {
    size_t n;
    lf_gltf_node *node;
} lf_gltf_nodes;

struct lf_gltf_playing; /* gltf_animation.h */

/* world: the transform of the file; playing: the animation. LF_E_FORMAT: a cycle, a child of two
 * parents, an index out of range, only hidden meshes; LF_E_NOMEM. Release with lf_gltf_nodes_close,
 * also after a failure. */
LF_NODISCARD lf_status lf_gltf_nodes_open(lf_gltf *gltf, const struct lf_gltf_playing *playing,
                                          const lf_affine *world, lf_gltf_nodes *out,
                                          lf_error *err);
/* Accepts a zeroed struct. */
void lf_gltf_nodes_close(lf_gltf_nodes *nodes);

#endif
