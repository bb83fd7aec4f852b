/* Puts what a glTF file shows together into a mesh. One thread. */
#ifndef LF_RENDER_GLTF_BUILD_H
#define LF_RENDER_GLTF_BUILD_H

#include "render/import/reader/gltf_node.h"
#include "render/import/reader/gltf_primitive.h"
#include "render/import/reader/mesh_build.h"

/* What nodes show. Materials are numbered as in the file; behind them may come two that are made
 * up. */
typedef struct lf_gltf_build {
    lf_gltf *gltf;
    const lf_mesh_desc *desc;
    const lf_gltf_nodes *nodes;
    const lf_gltf_mesh *meshes;
    lf_mesh_data *data;
    uint32_t only;               /* 1 + the mesh that lf_gltf_visit keeps to; 0: all */
    size_t n_materials;          /* of the file */
    uint32_t plain, plain_white; /* in place of none; the other where vertices have colours */
    int64_t n_vertices, n_triangles, n_beside;
    int64_t n_unmapped;      /* parts that lack the texture coordinates of a picture of theirs */
    int64_t n_wrong_normals; /* triangles left out for an index without a vertex */
    int64_t n_odd; /* vertices with a number beside their position that is none, or out of range */
    bool has_normals, has_colours, has_uvs; /* some that is shown has */
    uint32_t *same; /* lf_mesh_complete_twins, where desc wants smooth ones; lf_free */
} lf_gltf_build;

/* Which material a primitive gets. */
uint32_t lf_gltf_build_material(const lf_gltf_build *build, const lf_gltf_primitive *primitive);
/* A primitive at a place where it is shown. */
typedef struct lf_gltf_use {
    const lf_gltf_node *node;
    const lf_affine *to_world; /* of the node, or of one of its instances */
    const lf_gltf_mesh *mesh;
    const lf_gltf_primitive *primitive;
} lf_gltf_use;
/* Calls for each, until one fails. */
typedef lf_status lf_gltf_visit_fn(lf_gltf_build *build, const lf_gltf_use *place, void *context,
                                   lf_error *err);
LF_NODISCARD lf_status lf_gltf_visit(lf_gltf_build *build, lf_gltf_visit_fn *visit, void *context,
                                     lf_error *err);
/* Fills build->data, which has its materials, but for what lf_mesh_complete does. n_vertices and
 * n_triangles are counted first. LF_E_FORMAT, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_fill(lf_gltf_build *build, lf_error *err);

#endif
