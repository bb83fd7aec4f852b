/* Triangles as seen from a point: solid angle, and uniform directions over it; private to render/.
 * In double precision, because solid angles down to LF_SPHERICAL_MIN are differences of angles. */
#ifndef LF_RENDER_SPHERICAL_H
#define LF_RENDER_SPHERICAL_H

#include <stdbool.h>

#include "render/scene/vec.h"

/* Steradians; a smaller triangle is nearly flat, and uniform sampling of its area is as good. */
#define LF_SPHERICAL_MIN 1e-3

typedef struct lf_spherical {
    double corner[3][3]; /* unit, from the point to the triangle's corners */
    double solid_angle;
} lf_spherical;

/* The triangle a, b, c as seen from p (Van Oosterom and Strackee 1983). false: smaller than
 * LF_SPHERICAL_MIN, or p is so near its plane that rounding decides the side. Depends only on the
 * arguments, so that a sampler and its pdf decide alike. */
bool lf_spherical_init(lf_spherical *s, lf_vec3 p, lf_vec3 a, lf_vec3 b, lf_vec3 c);

/* A unit direction uniform over the solid angle, u[2] in [0,1) (Arvo 1995). */
void lf_spherical_draw(const lf_spherical *s, const float u[2], double out_w[3]);

#endif
