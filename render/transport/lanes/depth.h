/* Optical depths along any ray, exact except for rounding, where transport/path/track.h estimates a
 * transmittance: some weights need the exact number. Private to render/. A grid is integrated cell
 * by cell: an interpolated grid is a cubic of the distance in each cell; a grid with edges is
 * constant. Empty bricks are skipped. Not for chromatic media, and only for volumes that do not
 * move. */
#ifndef LF_RENDER_DEPTH_H
#define LF_RENDER_DEPTH_H

#include "render/transport/lanes/depth_kernel.h"
#include "render/transport/path/track.h"

/* The optical depth of all volumes of the tracer's scene, from o along the unit vector w up to
 * `end` (INFINITY: out of the scene); counts look-ups. One ray, in double except for the look-ups,
 * by the two-point Gauss rule: the reference for the functions below. */
double lf_depth_along(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end);

typedef struct lf_depth_ray {
    lf_vec3 o, w;
    double end;
} lf_depth_ray;

/* A ray may stop at this depth: its transmittance is negligible. */
#define LF_DEPTH_ENOUGH 128.0

/* lf_depth_along for many rays in lanes. Each depth does not depend on the other rays, and is
 * bitwise the same for every instruction set. In float: within 5e-6 of the reference (or of 1, if
 * that is larger), plus the effect of moving the ray by 1e-5 voxels, or 1e-7 of the grid's length.
 * Positions are rounded brick by brick (depth_lanes.h). Rays start at their far ends, where a pivot
 * is, so that the rounding of lengths affects the end where they leave the volume. */
void lf_depths_along(lf_tracer *tracer, int n, const lf_depth_ray *rays, double *out_depths);
/* lf_depths_along with a given instruction set. */
void lf_depths_by(const lf_depth_kernel *kernel, lf_tracer *tracer, int n, const lf_depth_ray *rays,
                  double *out_depths);

#endif
