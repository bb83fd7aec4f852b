/* Catchers: what a surface gets of the light of lights, beside what it would get with nothing in
 * the way, and what it reflects of things; private to render/. The light of lights is what the
 * plate or backdrop behind a catcher is lit by; a mesh that shines is a thing, whose light is
 * reflected. */
#ifndef LF_RENDER_CATCHER_H
#define LF_RENDER_CATCHER_H

#include "render/transport/path/track.h"

/* The nearest surface that a ray of the camera along w, which need not be unit, sees, catchers
 * among them; hit->t is not set. *out_passed: an unbiased estimate of what media leave on the way
 * to a catcher; 0: no catcher is seen. */
void lf_trace_caught(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, lf_hit *hit, float *out_passed);

/* Adds an unbiased estimate of the irradiance at a surface (mean of the channels; of its side that
 * was hit) to out[0], and of that without any surface or medium before the lights to out[1]: a
 * light sample and a direction by the cosine, weighed by the balance heuristic (Veach and Guibas
 * 1995); both sums from the same ones. Light that other surfaces send back, and that of volumes, is
 * in neither; nor is, where the surface reflects, that of meshes that shine. u[5] in [0, 1). */
void lf_catcher_light(lf_tracer *tracer, const lf_hit *hit, const float u[5], double out[2]);

/* An unbiased estimate of the radiance that a surface, hit along the unit vector w, sends back of
 * what comes from things, on its side that was hit: of int f |cos| L over directions, L along each
 * being what the first event there sends (emission of surfaces, all that is scattered there as in
 * lf_path_scattered; of volumes along the way what they emit, too), and 0 where that is an escape,
 * a catcher or a lamp of the scene's lights. Every delta lobe is followed, one direction of the
 * others drawn, and one light: of meshes that shine, by the balance heuristic. Paths end behind
 * vertex max_depth, the surface being the first. u[3] in [0, 1). */
lf_vec3 lf_catcher_reflection(lf_tracer *tracer, const lf_hit *hit, lf_vec3 w, const float u[3],
                              int max_depth);

#endif
