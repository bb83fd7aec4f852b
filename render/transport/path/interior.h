/* The interior medium of solid glass: homogeneous, with its own absorption and scattering, each a
 * colour per scene unit (milk, smoke in glass, coloured glass). It fills the space between faces:
 * behind a face that a path enters, and in front of a face met from inside. Private to
 * render/transport/; used only in scenes with LF_TRAITS_FILLED. */
#ifndef LF_RENDER_INTERIOR_H
#define LF_RENDER_INTERIOR_H

#include "render/transport/path/coloured.h"
#include "render/transport/path/path.h"

/* The glass that a path is in after it leaves the event along w; NULL: none. */
const lf_material *lf_interior_beyond(const lf_scene *scene, const lf_event *from, lf_vec3 w);

/* Its transmittance over this length: Beer's law, including scattering. */
lf_vec3 lf_interior_left(const lf_material *in, float t);

/* The distance from `from` along w to the first scattering in the glass that the path enters or is
 * in, for a path with throughput beta; INFINITY without scattering. Sets out->interior;
 * out->surface, hit and nest must be set. The distance is drawn for one channel, chosen in
 * proportion to beta. */
float lf_interior_segment(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                          lf_event *out);
/* Called when the end of the segment is known (out->t; volume LF_INTERIOR if the drawn distance
 * ends it). Sets `left`, the factor of the path's throughput, with the distance weighted for all
 * channels (one-sample balance heuristic; Veach 1997, 9.2.4). No channel grows beyond the sum of
 * all. */
void lf_interior_weigh(lf_vec3 beta, lf_event *out);

/* The attenuation of volume emission along a segment, for a path with throughput beta. */
lf_dimming lf_interior_dimming(const lf_material *in, lf_vec3 beta);

#endif
