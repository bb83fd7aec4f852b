/* Triangles that are very large relative to the scene's detail: intersected in double precision;
 * private to render/.
 *
 * Embree works in single precision. It finds a triangle up to some 1e-7 of its size in front of or
 * behind its plane, and points nearer than that to a surface on either side of it. Rays must start
 * at least so far away (lf_geometry.offset). On a ground of two triangles as wide as a town, this
 * offset would be as high as the objects on it. So triangles whose error would be visible are
 * excluded from Embree's triangle meshes. They become a user geometry in the same BVH, whose
 * callback computes from the corners, which are floats and exact. Edges shared by two of them are
 * watertight: their signed volumes (Plücker's side test) have the same bits with opposite sign.
 * Meshes that move while the shutter is open stay in Embree. */
#ifndef LF_RENDER_LARGE_H
#define LF_RENDER_LARGE_H

#include "base/status.h"
#include "render/scene/scene.h"

typedef struct lf_large_triangle {
    uint32_t mesh, triangle;
    double corner[3][3], normal[3]; /* normal: its length is twice the area */
} lf_large_triangle;

typedef struct lf_large {
    lf_large_triangle *triangles; /* sorted by mesh and triangle */
    uint32_t n;
} lf_large;

/* Selects them among all triangles of the meshes. *out_offset is the largest error of any
 * triangle's plane: in single precision, or in double for the large ones. LF_E_NOMEM. The caller
 * frees out->triangles. */
LF_NODISCARD lf_status lf_large_pick(const lf_mesh *meshes, int n_meshes, lf_large *out,
                                     float *out_offset);

/* Adds them to a scene as geometry number id. Hits have that number and an index into triangles.
 * They must stay at their addresses. false: Embree failed. */
bool lf_large_attach(const lf_large *large, RTCDevice device, RTCScene scene, unsigned id);

/* Intersects the ray o + t w, t > 0: t and the barycentric coordinates of the second and third
 * corner; false: no hit. */
bool lf_large_meet(const lf_large_triangle *triangle, const double o[3], const double w[3],
                   double *out_t, double out_uv[2]);

#endif
