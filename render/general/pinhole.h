/* Cameras listed one by one, as rays see them; private to render/. Each is a pinhole whose picture
 * is a plane across its axis, at distance 1. Scene-local coordinates. */
#ifndef LF_RENDER_PINHOLE_H
#define LF_RENDER_PINHOLE_H

#include "render/scene/scene.h"

typedef struct lf_pinhole {
    lf_vec3 eye, right, up, forward;
    /* on the plane: film point (0, 0) and one pixel; dy < 0 */
    float x0, dx, y0, dy;
    float tangent; /* of half the angle of the whole picture */
} lf_pinhole;

/* Those of settings.camera.list into out [n_views]. LF_E_ARG: out of range. origin: as of a rig. */
LF_NODISCARD lf_status lf_pinholes_init(lf_pinhole *out, const lf_render_settings *settings,
                                        const double origin[3], lf_error *err);

/* Of the ray through a film point: unit. */
lf_vec3 lf_pinhole_ray(const lf_pinhole *pinhole, float u, float v);

/* A point in a camera's picture. */
typedef struct lf_pinhole_sight {
    float u, v;     /* film coordinates */
    float distance; /* of the point */
    lf_vec3 w;      /* unit, from the eye to it */
    /* Area across w at the point for one pixel of the film: what 1 over it is, is the density of
     * native samples there, before what is lost on the way. */
    double area;
} lf_pinhole_sight;

/* false: the point is not before the camera. */
bool lf_pinhole_see(const lf_pinhole *pinhole, lf_vec3 p, lf_pinhole_sight *out);

#endif
