/* Triangles that are very large beside the rest: met in double precision; private to render/.
 *
 * Embree works in single precision. It finds a triangle up to some 1e-7 of its size before or
 * behind its plane, and what lies nearer than that to a surface on either side of it: rays have to
 * start so far off (lf_geometry.offset), and on a ground of two triangles as wide as a town the
 * offset would be as high as what stands there. Triangles whose error would be seen in the scene's
 * detail are left out of Embree's own and become a user geometry of the same hierarchy, whose
 * callback decides from the corners, which are floats and exact. Edges shared by two of them are
 * watertight: their signed volumes (Plücker's side test) are the same bits with the other sign.
 * What moves while the shutter is open stays Embree's. */
#ifndef LF_RENDER_LARGE_H
#define LF_RENDER_LARGE_H

#include "base/status.h"
#include "render/scene/scene.h"

typedef struct lf_large_triangle {
    uint32_t mesh, triangle;
    double corner[3][3], normal[3]; /* normal: of twice the area */
} lf_large_triangle;

typedef struct lf_large {
    lf_large_triangle *triangles; /* in the order of mesh and triangle */
    uint32_t n;
} lf_large;

/* Picks them among all triangles of the meshes; *out_offset is what the plane of any triangle can
 * be missed by: in single precision, or in double by the large ones. LF_E_NOMEM. The caller frees
 * out->triangles. */
LF_NODISCARD lf_status lf_large_pick(const lf_mesh *meshes, int n_meshes, lf_large *out,
                                     float *out_offset);

/* Adds them to a scene as geometry number id, whose hits carry that number and an index into
 * triangles; they must stay where they are. false: Embree refuses. */
bool lf_large_attach(const lf_large *large, RTCDevice device, RTCScene scene, unsigned id);

/* Where the ray o + t w, t > 0, meets one: t and the barycentric coordinates of the second and
 * third corner; false: it does not. */
bool lf_large_meet(const lf_large_triangle *triangle, const double o[3], const double w[3],
                   double *out_t, double out_uv[2]);

#endif
