/* A mesh that stands in many places (instances): kept once, with a map for each; private to
 * render/. Its vertices are in coordinates of its own, about the middle of its box, and lf_mesh.box
 * is that of all its places. Of a million places 48 bytes each are kept, their boxes (lf_box_tree),
 * and Embree's hierarchy over those: one user geometry, whose callback brings the ray into the
 * mesh's own space in double precision, near to it, so that what rays are rounded by does not grow
 * with the way that they have come. Hits carry the mesh as geomID, the triangle as primID, and the
 * place as instID[0]. Immutable once built. */
#ifndef LF_RENDER_PLACED_H
#define LF_RENDER_PLACED_H

#include "render/scene/affine.h"
#include "render/scene/box_tree.h"

typedef struct lf_placed {
    int n;
    float (*map)[3][4];    /* [n] own coordinates -> scene-local */
    lf_box_tree boxes;     /* of the places, scene-local */
    lf_box_tree triangles; /* of the mesh's own, in its space */
    RTCScene embree;       /* ... which are in here */
    double radius;         /* of a ball about its origin that holds it */
    float most, least;     /* what lengths of its own are multiplied by, at most and at least */
    uint32_t first;        /* places of the meshes before it */
} lf_placed;

/* Of a mesh whose arrays are there, .n maps included, which are *placed's from then on; sets
 * mesh->box and mesh->placed. device: Embree's. LF_E_NOMEM; the mesh is then to be released with
 * lf_placed_destroy all the same. */
LF_NODISCARD lf_status lf_placed_build(lf_placed *placed, lf_mesh *mesh, RTCDevice device);
/* Accepts NULL. */
void lf_placed_destroy(lf_placed *placed);

/* Adds its places to a scene as geometry number mesh->geom_id; both must stay where they are.
 * false: Embree refuses. */
bool lf_placed_attach(const lf_mesh *mesh, RTCDevice device, RTCScene scene);

/* The map of a place. */
lf_affine lf_placed_map(const lf_placed *placed, uint32_t place);

#endif
