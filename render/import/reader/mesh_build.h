/* A mesh put together vertex by vertex, in world coordinates, whoever read it. One thread. */
#ifndef LF_RENDER_MESH_BUILD_H
#define LF_RENDER_MESH_BUILD_H

#include "render/import/scene/mesh_import.h"

/* Where a part of a file stands. */
typedef struct lf_mesh_place {
    lf_affine to_world;
    double normals[3][3]; /* takes normals there, up to their length */
    bool mirrored;        /* it turns every face inside out */
} lf_mesh_place;

lf_mesh_place lf_mesh_place_of(const lf_affine *to_world);

/* Room for vertices and triangles, of which data has none yet; its materials are there already.
 * LF_E_NOMEM: too many, or no memory. */
LF_NODISCARD lf_status lf_mesh_allocate(lf_mesh_data *data, int64_t n_vertices, int64_t n_triangles,
                                        bool normals, lf_error *err);
/* Appends a vertex; normal may be NULL. One that is unusable becomes NaN, a normal that is becomes
 * 0, until lf_mesh_complete. */
void lf_mesh_put_vertex(lf_mesh_data *data, const lf_mesh_place *place, const double position[3],
                        const float *normal);
/* Appends a triangle of vertices that are there, and the material that it has, unless no ray can
 * meet it. */
void lf_mesh_put_triangle(lf_mesh_data *data, const lf_mesh_place *place, const uint32_t corners[3],
                          unsigned material);
/* same[i] of n vertices from `first` on: the first of them that has its position. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_find_same(const lf_mesh_data *data, size_t first, size_t n,
                                         uint32_t *same, lf_error *err);
/* When all are there, of which there should have been n_triangles: smooth normals if desc says so,
 * one for every vertex that has none, and a warning of what was left out. LF_E_FORMAT: all was. */
LF_NODISCARD lf_status lf_mesh_complete(lf_mesh_data *data, const lf_mesh_desc *desc,
                                        int64_t n_triangles, lf_error *err);
/* The same of vertices that were kept apart for what lies on them: twins[v] is the first that
 * stands where v does and shares its smooth normal; NULL: each is its own. */
LF_NODISCARD lf_status lf_mesh_complete_twins(lf_mesh_data *data, const lf_mesh_desc *desc,
                                              int64_t n_triangles, const uint32_t *twins,
                                              lf_error *err);

#endif
