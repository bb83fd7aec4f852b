/* Builds a mesh vertex by vertex, in world coordinates; used by all readers. One thread. */
#ifndef LF_RENDER_MESH_BUILD_H
#define LF_RENDER_MESH_BUILD_H

#include "render/import/scene/mesh_import.h"

/* The transform of a part of a file. */
typedef struct lf_mesh_place {
    lf_affine to_world;
    double normals[3][3]; /* transforms normals, up to their length */
    bool mirrored;        /* it reverses the orientation of faces */
} lf_mesh_place;

lf_mesh_place lf_mesh_place_of(const lf_affine *to_world);

/* Allocates vertices and triangles of data, which has none yet but has its materials. LF_E_NOMEM:
 * too many, or no memory. */
LF_NODISCARD lf_status lf_mesh_allocate(lf_mesh_data *data, int64_t n_vertices, int64_t n_triangles,
                                        bool normals, lf_error *err);
/* Appends a vertex; normal may be NULL. An unusable vertex becomes NaN, an unusable normal 0, until
 * lf_mesh_complete. */
void lf_mesh_put_vertex(lf_mesh_data *data, const lf_mesh_place *place, const double position[3],
                        const float *normal);
/* Appends a triangle of existing vertices, with its material, unless no ray can meet it. */
void lf_mesh_put_triangle(lf_mesh_data *data, const lf_mesh_place *place, const uint32_t corners[3],
                          unsigned material);
/* same[i] of n vertices from `first` on: the first of them with the same position. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_find_same(const lf_mesh_data *data, size_t first, size_t n,
                                         uint32_t *same, lf_error *err);
/* Called when all vertices and triangles are appended; n_triangles is the expected number. Makes
 * smooth normals if desc requests them, gives a normal to every vertex without one, and warns of
 * dropped triangles. LF_E_FORMAT: all were dropped. */
LF_NODISCARD lf_status lf_mesh_complete(lf_mesh_data *data, const lf_mesh_desc *desc,
                                        int64_t n_triangles, lf_error *err);
/* lf_mesh_complete for vertices that differ only in attributes: twins[v] is the first vertex with
 * the position of v, and shares its smooth normal; NULL: none do. */
LF_NODISCARD lf_status lf_mesh_complete_twins(lf_mesh_data *data, const lf_mesh_desc *desc,
                                              int64_t n_triangles, const uint32_t *twins,
                                              lf_error *err);

#endif
