/* Cameras listed one by one, as used by rays; private to render/. Each is a pinhole whose image is
 * a plane perpendicular to its axis, at distance 1; or a thin lens, a disk with the same radius in
 * all cameras. The ray of a film point leaves the lens point (lx, ly), along right and up, towards
 * the point where the pinhole ray meets the focus plane, F away:
 *
 *     X = lx + (x - lx/F) Z,   Y = ly + (y - ly/F) Z        x, y on the image plane.
 *
 * Other cameras use the same lens point, as in a rig. Scene-local coordinates. */
#ifndef LF_RENDER_PINHOLE_H
#define LF_RENDER_PINHOLE_H

#include "render/render.h"
#include "render/scene/scene.h"

typedef struct lf_pinhole {
    lf_vec3 eye, right, up, forward;
    /* on the plane: film point (0, 0), and the size of a pixel; dy < 0 */
    float x0, dx, y0, dy;
    float tangent;            /* of half the angle of the whole image */
    float lens_radius, focus; /* focus: F; lens_radius 0: a pinhole */
} lf_pinhole;

/* Fills out [n_views] from settings.camera.list. LF_E_ARG: out of range. origin: as for a rig. */
LF_NODISCARD lf_status lf_pinholes_init(lf_pinhole *out, const lf_render_settings *settings,
                                        const double origin[3], lf_error *err);

/* A uniform point of the lens, from two numbers in [0, 1). */
void lf_pinhole_lens(const lf_pinhole *pinhole, const float u[2], float out_lens[2]);
/* The origin of rays through that lens point. */
lf_vec3 lf_pinhole_eye(const lf_pinhole *pinhole, const float lens[2]);
/* Unit direction of the ray from that lens point through a film point. */
lf_vec3 lf_pinhole_ray(const lf_pinhole *pinhole, const float lens[2], float u, float v);

/* A point projected into a camera's image. */
typedef struct lf_pinhole_sight {
    float u, v;     /* film coordinates */
    float distance; /* from the lens point */
    lf_vec3 eye, w; /* the lens point; unit, from it to the point */
    /* Area perpendicular to w at the point for one pixel of the film. 1/area is the density of
     * native samples there, without attenuation. */
    double area;
} lf_pinhole_sight;

/* false: the point is not in front of the camera. */
bool lf_pinhole_see(const lf_pinhole *pinhole, const float lens[2], lf_vec3 p,
                    lf_pinhole_sight *out);

#endif
