/* A mesh that stands in many places (instances): kept once, with a map for each; private to
 * render/. Its vertices are in coordinates of its own, about the middle of its box, and lf_mesh.box
 * is that of all its places. Of a million places 48 bytes each are kept, their boxes (lf_box_tree),
 * and Embree's hierarchy over those: one user geometry, whose callback brings the ray into the
 * mesh's own space in double precision, near to it, so that what rays are rounded by does not grow
 * with the way that they have come. Hits carry the mesh as geomID, the triangle as primID, and the
 * place as instID[0]. Immutable once built. */
#ifndef LF_RENDER_INSTANCES_H
#define LF_RENDER_INSTANCES_H

#include "render/scene/affine.h"
#include "render/scene/box_tree.h"

/* Triangles of a mesh that stand together. */
typedef struct lf_instanced_part {
    uint32_t first, n;     /* of the mesh's triangles */
    lf_box_tree triangles; /* in the mesh's space, numbered from first on */
    RTCScene embree;       /* ... which are in here, too */
    double radius;         /* of a ball about its origin that holds it */
} lf_instanced_part;

typedef struct lf_instances {
    int n, n_parts;
    float (*map)[3][4];       /* [n] own coordinates -> scene-local */
    uint32_t *part_of;        /* [n] which part stands there; NULL: the only one */
    lf_instanced_part *parts; /* [n_parts] each with the origin in the middle of its box */
    lf_box_tree boxes;        /* of the places, scene-local */
    float most, least;        /* what lengths of its own are multiplied by, at most and at least */
    float reach;              /* the largest radius, where it stands */
    uint32_t first;           /* places of the meshes before it */
} lf_instances;

static inline lf_instanced_part *lf_instanced_part_at(const lf_instances *instances, uint32_t place)
{
    return &instances->parts[instances->part_of ? instances->part_of[place] : 0];
}

/* Of a mesh whose arrays are there, .n maps included, and of its parts .first and .n; sets
 * mesh->box. device: Embree's. LF_E_NOMEM, LF_E_CANCELLED; the mesh is then to be released with
 * lf_instances_destroy all the same. */
LF_NODISCARD lf_status lf_instances_build(lf_instances *instances, lf_mesh *mesh, RTCDevice device);
/* Accepts NULL. */
void lf_instances_destroy(lf_instances *instances);

/* Adds its places to a scene as geometry number mesh->geom_id; both must stay where they are.
 * false: Embree refuses. */
bool lf_instances_attach(const lf_mesh *mesh, RTCDevice device, RTCScene scene);

/* The map of a place. */
lf_affine lf_instance_map(const lf_instances *instances, uint32_t place);

#endif
