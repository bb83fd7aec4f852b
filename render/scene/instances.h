/* An instanced mesh: stored once, with one transform per instance; private to render/. Its vertices
 * are in its own coordinates, around the middle of its box. lf_mesh.box is the box of all
 * instances. Memory per instance: 48 bytes, its box (lf_box_tree), and its part of Embree's BVH.
 *
 * Embree sees one user geometry. Its callback transforms the ray into the mesh's space in double
 * precision and starts it near the mesh, so that rounding does not grow with the distance. Hits
 * have the mesh as geomID, the triangle as primID, and the instance as instID[0]. Immutable once
 * built. */
#ifndef LF_RENDER_INSTANCES_H
#define LF_RENDER_INSTANCES_H

#include "render/scene/affine.h"
#include "render/scene/box_tree.h"

/* Triangles of a mesh that belong together. */
typedef struct lf_instanced_part {
    uint32_t first, n;     /* of the mesh's triangles */
    lf_box_tree triangles; /* in the mesh's space, numbered from first on */
    RTCScene embree;       /* a BVH of the same triangles */
    double radius;         /* of a ball around its origin that contains it */
} lf_instanced_part;

typedef struct lf_instances {
    int n, n_parts;
    float (*map)[3][4];       /* [n] own coordinates -> scene-local */
    uint32_t *part_of;        /* [n] part of each instance; NULL: the only part */
    lf_instanced_part *parts; /* [n_parts] each with the origin in the middle of its box */
    lf_box_tree boxes;        /* of the instances, scene-local */
    float most, least;        /* largest and smallest scale factor of the transforms */
    float reach;              /* the largest radius of an instance, scene units */
    uint32_t first;           /* number of instances of earlier meshes */
} lf_instances;

static inline lf_instanced_part *lf_instanced_part_at(const lf_instances *instances, uint32_t place)
{
    return &instances->parts[instances->part_of ? instances->part_of[place] : 0];
}

/* Builds the parts of a mesh. The mesh's arrays, .n maps, and .first and .n of each part must be
 * set. Sets mesh->box. device: Embree's. LF_E_NOMEM, LF_E_CANCELLED; release with
 * lf_instances_destroy also after a failure. */
LF_NODISCARD lf_status lf_instances_build(lf_instances *instances, lf_mesh *mesh, RTCDevice device);
/* Accepts NULL. */
void lf_instances_destroy(lf_instances *instances);

/* Adds its instances to a scene as geometry number mesh->geom_id; both must stay at their
 * addresses. false: Embree failed. */
bool lf_instances_attach(const lf_mesh *mesh, RTCDevice device, RTCScene scene);

/* The transform of an instance. */
lf_affine lf_instance_map(const lf_instances *instances, uint32_t place);

#endif
