/* Builds a mesh from the visible parts of a glTF file. One thread. */
#ifndef LF_RENDER_GLTF_BUILD_H
#define LF_RENDER_GLTF_BUILD_H

#include "render/import/reader/gltf_node.h"
#include "render/import/reader/gltf_primitive.h"
#include "render/import/reader/mesh_build.h"

/* Meshes of visible nodes. Materials are numbered as in the file, followed by up to two default
 * materials. */
typedef struct lf_gltf_build {
    lf_gltf *gltf;
    const lf_mesh_desc *desc;
    const lf_gltf_nodes *nodes;
    const lf_gltf_mesh *meshes;
    lf_mesh_data *data;
    uint32_t only;               /* 1 + the only mesh that lf_gltf_visit visits; 0: all */
    size_t n_materials;          /* of the file */
    uint32_t plain, plain_white; /* default materials; plain_white is for vertices with colours */
    int64_t n_vertices, n_triangles, n_beside;
    int64_t n_unmapped;      /* parts without the texture coordinates of one of their textures */
    int64_t n_wrong_normals; /* triangles dropped for an index without a vertex */
    int64_t n_odd; /* vertices with an attribute besides the position that is NaN or out of range */
    bool has_normals, has_colours, has_uvs; /* at least one visible part has them */
    uint32_t *same; /* lf_mesh_complete_twins, if desc requests smooth normals; lf_free */
} lf_gltf_build;

/* The number of a primitive's material. */
uint32_t lf_gltf_build_material(const lf_gltf_build *build, const lf_gltf_primitive *primitive);
/* A primitive, at a node that shows it. */
typedef struct lf_gltf_use {
    const lf_gltf_node *node;
    const lf_affine *to_world; /* of the node, or of one of its instances */
    const lf_gltf_mesh *mesh;
    const lf_gltf_primitive *primitive;
} lf_gltf_use;
/* Calls visit for each, until one fails. */
typedef lf_status lf_gltf_visit_fn(lf_gltf_build *build, const lf_gltf_use *place, void *context,
                                   lf_error *err);
LF_NODISCARD lf_status lf_gltf_visit(lf_gltf_build *build, lf_gltf_visit_fn *visit, void *context,
                                     lf_error *err);
/* Fills build->data, which has its materials, except what lf_mesh_complete does. n_vertices and
 * n_triangles must be counted. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_fill(lf_gltf_build *build, lf_error *err);

#endif
