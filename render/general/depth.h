/* Optical depths along any ray, exact but for rounding; private to render/. A grid is taken cell by
 * cell: interpolated, it is a cubic of the distance in each, which Gauss's rule of two points
 * integrates exactly; with edges it is constant. Bricks that hold nothing are stepped over. Where
 * transport/track.h estimates a transmittance, weights want the number itself. */
#ifndef LF_RENDER_DEPTH_H
#define LF_RENDER_DEPTH_H

#include "render/transport/track.h"

/* Of all volumes of the tracer's scene, from o along the unit vector w as far as `end` (INFINITY:
 * out of the scene); counts look-ups. Not of colours, and of volumes where they stand. */
double lf_depth_along(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, double end);

#endif
