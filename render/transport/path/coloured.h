/* Homogeneous media whose extinction has a colour, along which a path carries beta. A way until it
 * is met is drawn for one channel, chosen in proportion to beta, and weighed for all (one-sample
 * balance; Veach 1997, 9.2.4): none grows beyond what all had together. Private to
 * render/transport/. */
#ifndef LF_RENDER_COLOURED_H
#define LF_RENDER_COLOURED_H

#include "render/transport/path/track.h"

/* Beer's law of each channel. */
lf_vec3 lf_coloured_transmittance(lf_vec3 sigma_t, float t);

/* A way, INFINITY where the channel meets nothing. */
float lf_coloured_segment(lf_tracer *tracer, lf_vec3 sigma_t, lf_vec3 beta);
/* What the light of all is to be multiplied by where that way has led to a collision (keeps: albedo
 * times sigma_t) or where it was longer than t. */
lf_vec3 lf_coloured_collision(lf_vec3 beta, lf_vec3 sigma_t, lf_vec3 keeps, float t);
lf_vec3 lf_coloured_passage(lf_vec3 beta, lf_vec3 sigma_t, float t);

/* What a medium leaves of light from points along a segment. */
struct lf_dimming {
    lf_vec3 sigma_t;
    lf_vec3 beta;  /* what the path carries where the segment begins */
    bool is_drawn; /* the segment ends where a way says, if nowhere before; else it only dims */
};

/* Of light from t. */
lf_vec3 lf_dimming_at(const lf_dimming *dimming, float t);
/* Its integral over t0 .. t1: in closed form, or where ways are drawn an unbiased estimate. */
lf_vec3 lf_dimming_between(const lf_dimming *dimming, lf_tracer *tracer, float t0, float t1);

#endif
