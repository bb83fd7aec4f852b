/* Optical depths along any ray, exact but for rounding; private to render/. A grid is taken cell by
 * cell: interpolated, it is a cubic of the distance in each; with edges it is constant. Bricks that
 * hold nothing are stepped over. Where transport/path/track.h estimates a transmittance, weights
 * want the number itself. Not of colours, and of volumes where they stand. */
#ifndef LF_RENDER_DEPTH_H
#define LF_RENDER_DEPTH_H

#include "render/transport/lanes/depth_kernel.h"
#include "render/transport/path/track.h"

/* Of all volumes of the tracer's scene, from o along the unit vector w as far as `end` (INFINITY:
 * out of the scene); counts look-ups. One ray, in double but for the look-ups, by Gauss's rule of
 * two points: the oracle of those below. */
double lf_depth_along(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end);

typedef struct lf_depth_ray {
    lf_vec3 o, w;
    double end;
} lf_depth_ray;

/* Depths above which a ray may end where it is: nothing is left behind. */
#define LF_DEPTH_ENOUGH 128.0

/* The same of many rays, side by side; each depth is what it is alone, and has the same bits by
 * every instruction set. In float: within 5e-6 of the oracle's (or of 1, whichever is larger), and
 * what rays have that run beside it by 1e-5 voxels, or 1e-7 of the grid's length. Places are
 * rounded brick by brick (depth_lanes.h), and rays start at their far ends, where a pivot is, so
 * that what lengths are rounded by falls where they leave the volume. */
void lf_depths_along(lf_tracer *tracer, int n, const lf_depth_ray *rays, double *out_depths);
/* By one of the instruction sets. */
void lf_depths_by(const lf_depth_kernel *kernel, lf_tracer *tracer, int n, const lf_depth_ray *rays,
                  double *out_depths);

#endif
