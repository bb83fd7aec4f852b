/* Shadow catchers: what a surface gets of the light of lights, beside what it would get with
 * nothing in the way; private to render/. */
#ifndef LF_RENDER_CATCHER_H
#define LF_RENDER_CATCHER_H

#include "render/transport/track.h"

/* The nearest surface that a ray of the camera along the unit vector w sees, catchers among them;
 * hit->t is not set. *out_passed: an unbiased estimate of what media leave on the way to a catcher;
 * 0: no catcher is seen. */
void lf_trace_caught(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, lf_hit *hit, float *out_passed);

/* Adds an unbiased estimate of the irradiance at a surface (mean of the channels; of its side that
 * was hit) to out[0], and of that without any surface or medium before the lights to out[1]: a
 * light sample and a direction by the cosine, weighed by the balance heuristic (Veach and Guibas
 * 1995); both sums from the same ones. Light that other surfaces send back, and that of volumes, is
 * in neither. u[5] in [0, 1). */
void lf_catcher_light(lf_tracer *tracer, const lf_hit *hit, const float u[5], double out[2]);

#endif
