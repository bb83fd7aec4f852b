/* Hits on instanced meshes (scene/instances.h), in scene coordinates; private to render/. */
#ifndef LF_RENDER_INSTANCE_HIT_H
#define LF_RENDER_INSTANCE_HIT_H

#include "render/transport/surface/face.h"

/* Fills a hit except t and textured properties: a ray along w meets the triangle of hit->mesh in
 * instance hit->place at the barycentric coordinates u and v. The point is on the triangle except
 * for the rounding of its own coordinates. */
void lf_instance_hit(const lf_scene *scene, lf_mesh const *mesh, uint32_t triangle, uint32_t place,
                     float u, float v, lf_vec3 w, lf_hit *hit);

/* lf_face_init for a triangle of one instance. */
void lf_instance_face_init(lf_face *face, const lf_scene *scene, int mesh, uint32_t triangle,
                           uint32_t place);

/* Twice the area of hit->triangle in hit->place. */
float lf_instance_twice_area(const lf_hit *hit);
/* A direction along the mesh, transformed by the hit's instance; unit. */
lf_vec3 lf_instance_tangent(const lf_hit *hit, lf_vec3 along);
/* Whether that instance is mirrored. */
bool lf_instance_is_mirrored(const lf_hit *hit);

#endif
