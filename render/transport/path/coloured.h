/* Homogeneous media with coloured extinction, for a path with throughput beta. The distance to a
 * collision is drawn for one channel, chosen in proportion to beta, and weighted for all channels
 * (one-sample balance heuristic; Veach 1997, 9.2.4). No channel grows beyond the sum of all.
 * Private to render/transport/. */
#ifndef LF_RENDER_COLOURED_H
#define LF_RENDER_COLOURED_H

#include "render/transport/path/track.h"

/* Beer's law per channel. */
lf_vec3 lf_coloured_transmittance(lf_vec3 sigma_t, float t);

/* Draws a distance; INFINITY if the chosen channel has no extinction. */
float lf_coloured_segment(lf_tracer *tracer, lf_vec3 sigma_t, lf_vec3 beta);
/* Factors of the path's throughput: for a collision at the drawn distance t (keeps: albedo times
 * sigma_t), and for a drawn distance longer than t. */
lf_vec3 lf_coloured_collision(lf_vec3 beta, lf_vec3 sigma_t, lf_vec3 keeps, float t);
lf_vec3 lf_coloured_passage(lf_vec3 beta, lf_vec3 sigma_t, float t);

/* The attenuation of light from points along a segment by a medium. */
struct lf_dimming {
    lf_vec3 sigma_t;
    lf_vec3 beta;  /* throughput at the start of the segment */
    bool is_drawn; /* a drawn distance may end the segment; false: it only attenuates */
};

/* Factor of light from distance t. */
lf_vec3 lf_dimming_at(const lf_dimming *dimming, float t);
/* Its integral over t0 .. t1: in closed form, or an unbiased estimate if distances are drawn. */
lf_vec3 lf_dimming_between(const lf_dimming *dimming, lf_tracer *tracer, float t0, float t1);

#endif
