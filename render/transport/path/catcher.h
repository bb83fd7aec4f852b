/* Shadow and reflection catchers: the direct light at a surface with and without occlusion, and the
 * light that it reflects from objects; private to render/. The direct light also lights the
 * backdrop plate behind a catcher. An emissive mesh is an object: its light is reflected. */
#ifndef LF_RENDER_CATCHER_H
#define LF_RENDER_CATCHER_H

#include "render/transport/path/track.h"

/* The nearest surface that a camera ray along w (not necessarily unit) sees, including catchers;
 * hit->t is not set. *out_passed: an unbiased estimate of the transmittance of media up to a
 * catcher; 0: no catcher is seen. */
void lf_trace_caught(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, lf_hit *hit, float *out_passed);

/* Adds an unbiased estimate of the irradiance (mean of the channels) on the side of a surface that
 * was hit to out[0], and the same without any occluding surface or medium to out[1]. Uses a light
 * sample and a cosine-distributed direction with the balance heuristic (Veach and Guibas 1995);
 * both sums use the same samples. Excludes light from other surfaces and from volumes and, if the
 * surface reflects, from emissive meshes. u[5] in [0, 1). */
void lf_catcher_light(lf_tracer *tracer, const lf_hit *hit, const float u[5], double out[2]);

/* An unbiased estimate of the radiance from objects that a surface, hit along the unit vector w,
 * reflects on the side that was hit: int f |cos| L over directions. L is the light from the first
 * event along a direction: emission of surfaces, all light scattered there as in lf_path_scattered,
 * and volume emission along the segment. L is 0 if that event is an escape, a catcher or one of the
 * scene's area lights. Follows every delta lobe, draws one direction of the other lobes, and one
 * light among emissive meshes, with the balance heuristic. Paths end after vertex max_depth; the
 * surface is the first vertex. u[3] in [0, 1). */
lf_vec3 lf_catcher_reflection(lf_tracer *tracer, const lf_hit *hit, lf_vec3 w, const float u[3],
                              int max_depth);

#endif
