/* Camera paths of the pilots, which run before the first pass; private to render/rows/. */
#ifndef LF_RENDER_PILOT_PATH_H
#define LF_RENDER_PILOT_PATH_H

#include "render/plane/rig.h"
#include "render/transport/path/suffix_one.h"

/* Traces the ray of a view's film point. out->w, and where the ray meets a surface with a lobe, the
 * pivot there. Sets the tracer's footprint. *out_light: what the camera sees there itself. false:
 * no pivot. Needs tracer->scene. */
bool lf_pilot_pivot(lf_tracer *tracer, const lf_rig *rig, int view, const float film[2],
                    lf_event *out, float *out_light);

/* Draws a suffix into a zeroed one, and follows it. balance: its cosine is not read; NULL:
 * alone. */
void lf_pilot_suffix(lf_tracer *tracer, const lf_event *pivot, lf_sampler *sampler, int max_depth,
                     const lf_light_balance *balance, lf_suffix *out);
/* Its radiance towards the camera; 0 if it is not finite. */
lf_vec3 lf_pilot_radiance(const lf_scene *scene, const lf_event *pivot, const lf_suffix *suffix);

#endif
