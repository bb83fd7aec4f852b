/* What fills solid glass: a homogeneous medium of its own absorption and scattering, each of them a
 * colour per scene unit (milk, smoke in glass, coloured glass). It fills what lies between faces:
 * beyond a face that is entered, and before one that is met from within. Private to
 * render/transport/. Only scenes with LF_TRAITS_FILLED ask. */
#ifndef LF_RENDER_INTERIOR_H
#define LF_RENDER_INTERIOR_H

#include "render/transport/path/coloured.h"
#include "render/transport/path/path.h"

/* The glass in which a path goes on that leaves the event along w; NULL: none. */
const lf_material *lf_interior_beyond(const lf_scene *scene, const lf_event *from, lf_vec3 w);

/* What it leaves of light along a way of this length: Beer's law, of scattering as well. */
lf_vec3 lf_interior_left(const lf_material *in, float t);

/* How far a path that carries beta goes within the glass that it enters, or is in, from `from`
 * along w before it is scattered there: INFINITY where nothing scatters. Sets interior of the
 * segment, whose surface (out->surface, hit) and nest are known. The way is drawn for one channel,
 * chosen in proportion to beta. */
float lf_interior_segment(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                          lf_event *out);
/* Once it is known where the segment ends (out->t, volume LF_INTERIOR where that was the way's
 * end): sets `left`, what the path's light is to be multiplied by, the way being weighed for all
 * channels (one-sample balance; Veach 1997, 9.2.4): none grows beyond what all had together. */
void lf_interior_weigh(lf_vec3 beta, lf_event *out);

/* What it leaves of light that volumes emit along a segment, on which a path carries beta. */
lf_dimming lf_interior_dimming(const lf_material *in, lf_vec3 beta);

#endif
