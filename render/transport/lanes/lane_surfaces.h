/* Surfaces for suffixes in lanes: rays are traced one by one, and path.c computes all light from
 * behind a surface; private to render/. */
#ifndef LF_RENDER_LANE_SURFACES_H
#define LF_RENDER_LANE_SURFACES_H

#include "render/transport/lanes/suffix.h"
#include "render/transport/path/track.h"

/* Borrows the tracer, whose scene must be the lanes'. Each segment sets the tracer's random
 * numbers, width and spread. Thread: the tracer's. */
lf_lane_surfaces lf_lane_surfaces_of(lf_tracer *tracer);

#endif
