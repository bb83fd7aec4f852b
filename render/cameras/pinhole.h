/* Cameras listed one by one, as rays see them; private to render/. Each is a pinhole whose picture
 * is a plane across its axis, at distance 1; or a thin lens, a disk of one radius in all of them:
 * the ray of a film point leaves (lx, ly) of it, along right and up, towards the point at which
 * that of the pinhole meets the plane of focus, F away,
 *
 *     X = lx + (x - lx/F) Z,   Y = ly + (y - ly/F) Z        x, y on the picture's plane.
 *
 * A point of the lens is handed on as it is to the other cameras: as in a rig. Scene-local
 * coordinates. */
#ifndef LF_RENDER_PINHOLE_H
#define LF_RENDER_PINHOLE_H

#include "render/render.h"
#include "render/scene/scene.h"

typedef struct lf_pinhole {
    lf_vec3 eye, right, up, forward;
    /* on the plane: film point (0, 0) and one pixel; dy < 0 */
    float x0, dx, y0, dy;
    float tangent;            /* of half the angle of the whole picture */
    float lens_radius, focus; /* F; a radius of 0: a pinhole */
} lf_pinhole;

/* Those of settings.camera.list into out [n_views]. LF_E_ARG: out of range. origin: as of a rig. */
LF_NODISCARD lf_status lf_pinholes_init(lf_pinhole *out, const lf_render_settings *settings,
                                        const double origin[3], lf_error *err);

/* A uniform point of the lens, from two numbers in [0, 1). */
void lf_pinhole_lens(const lf_pinhole *pinhole, const float u[2], float out_lens[2]);
/* Where rays of that point leave. */
lf_vec3 lf_pinhole_eye(const lf_pinhole *pinhole, const float lens[2]);
/* Of its ray through a film point: unit. */
lf_vec3 lf_pinhole_ray(const lf_pinhole *pinhole, const float lens[2], float u, float v);

/* A point in a camera's picture. */
typedef struct lf_pinhole_sight {
    float u, v;     /* film coordinates */
    float distance; /* of the point */
    lf_vec3 eye, w; /* the lens's point; unit, from there to it */
    /* Area across w at the point for one pixel of the film: what 1 over it is, is the density of
     * native samples there, before what is lost on the way. */
    double area;
} lf_pinhole_sight;

/* false: the point is not before the camera. */
bool lf_pinhole_see(const lf_pinhole *pinhole, const float lens[2], lf_vec3 p,
                    lf_pinhole_sight *out);

#endif
