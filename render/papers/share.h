/* What is behind a pivot, for all views that share it; private to render/. One light sample, and
 * one direction from the uniform mixture of the lobes of the views that share (Fraboni et al. 2022,
 * 3.2), in balance with each other; delta lobes are nobody's but the base's. */
#ifndef LF_RENDER_SHARE_H
#define LF_RENDER_SHARE_H

#include "render/papers/prefix.h"

/* Whether others can have anything of the pivot: it scatters, by more than delta lobes, or it
 * emits. */
bool lf_share_possible(const lf_general *g, const lf_prefix *p);

/* Draws the suffix, and adds to N and W of every view with a weight what it brings there. */
void lf_share_spread(const lf_general *g, lf_general_worker *w, const lf_prefix *p);

/* To N and W of the base's own pixel, with the weight of what is alone. */
void lf_share_alone(const lf_general *g, lf_general_worker *w, const lf_prefix *p, lf_vec3 y);

/* What the delta lobes at the pivot bring to the base's own pixel, into M of the film. */
void lf_share_deltas(const lf_general *g, lf_general_worker *w, const lf_prefix *p);

#endif
