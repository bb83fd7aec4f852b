/* The light behind a pivot, for all views that share it; private to render/. One light sample, and
 * one direction from the uniform mixture of the sharing views' lobes (Fraboni et al. 2022, 3.2),
 * combined by the balance heuristic. Delta lobes belong to the base view only. */
#ifndef LF_RENDER_SHARE_H
#define LF_RENDER_SHARE_H

#include "render/papers/prefix.h"

/* Whether other views can receive light from the pivot: it has lobes that are not delta lobes, or
 * it emits. */
bool lf_share_possible(const lf_general *g, const lf_prefix *p);

/* Draws the suffix, and adds its light to N, and the weight to W, of every view with a weight. */
void lf_share_spread(const lf_general *g, lf_general_worker *w, const lf_prefix *p);

/* Adds to N and W of the base's own pixel only, with the weight p->alone. */
void lf_share_alone(const lf_general *g, lf_general_worker *w, const lf_prefix *p, lf_vec3 y);

/* Adds the light of delta lobes at the pivot to the base's own pixel, in M of the film. */
void lf_share_deltas(const lf_general *g, lf_general_worker *w, const lf_prefix *p);

#endif
