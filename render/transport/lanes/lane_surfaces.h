/* What surfaces are to suffixes in lanes: rays that are traced one by one, and all that comes from
 * behind a surface by path.c; private to render/. */
#ifndef LF_RENDER_LANE_SURFACES_H
#define LF_RENDER_LANE_SURFACES_H

#include "render/transport/lanes/suffix.h"
#include "render/transport/path/track.h"

/* Borrows the tracer, whose scene is the lanes' and whose random numbers, width and spread it sets
 * anew for each segment. Thread: the tracer's. */
lf_lane_surfaces lf_lane_surfaces_of(lf_tracer *tracer);

#endif
