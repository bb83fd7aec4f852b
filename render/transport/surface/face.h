/* Triangles that are known to be hit by many rays; private to render/. */
#ifndef LF_RENDER_FACE_H
#define LF_RENDER_FACE_H

#include "render/transport/surface/surface.h"

/* A triangle, prepared for many hits. */
typedef struct lf_face {
    const lf_mesh *mesh;
    const lf_material *material;
    uint32_t triangle, place; /* place: as in lf_hit */
    lf_vec3 a, n;             /* a corner; unit normal */
    lf_vec3 to_uv[2];         /* p - a -> barycentric coordinates */
    lf_vec3 smooth[3];        /* shading normal at a, and its derivative by each of the two */
} lf_face;
void lf_face_init(lf_face *face, const lf_scene *scene, int mesh, uint32_t triangle);
/* The hit of a ray along the unit vector w that is known to meet the triangle at p, without t. */
void lf_face_hit(const lf_face *face, lf_vec3 p, lf_vec3 w, lf_hit *hit);
/* Only the shading normal of that hit; w need not be unit. */
lf_vec3 lf_face_normal(const lf_face *face, lf_vec3 p, lf_vec3 w);

#endif
