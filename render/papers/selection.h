/* Which views share a prefix with the view that drew it; private to render/. One file per kind, and
 * a line in the table of selection.c.
 *
 * The difference between the views' lobes at the pivot is their total variation distance, 0 to 1,
 * evaluated in two directions (Fraboni et al. 2022, equation 24) by the caller. Weights are
 * normalised over the selected views, c_j q_j / sum_{k selected} c_k q_k (equation 23).
 *
 * tv: each view is selected by its own random decision, with probability 1 - TV(base, view)
 * (section 4.3). AS PRINTED, and inconsistent: the views in the sum depend on the base, so that
 * weights do not sum to 1 over the bases. N/W converges to a wrong value; docs/developer/papers.md
 * gives the error.
 *
 * none: all views, always.
 *
 * partition: the line of cameras is cut where L_k = sum of TV(l - 1, l), l = 1..k, plus one uniform
 * offset passes whole numbers. Views share with probability max(0, 1 - |L_i - L_j|). Groups do not
 * depend on the base, so that weights sum to 1: mis and cv are unbiased, mwis is consistent. Not in
 * the paper. */
#ifndef LF_RENDER_SELECTION_H
#define LF_RENDER_SELECTION_H

#include <stdbool.h>

#include "render/papers/papers.h"
#include "render/transport/path/track.h"

/* The input: n views in their order along the cameras' line. */
typedef struct lf_selected_views {
    int n, base;
    double (*distance)(const void *lobes, int a, int b); /* 0..1, symmetric */
    const void *lobes;
} lf_selected_views;

typedef struct lf_selection {
    const char *name; /* as in --selection */
    const char *what; /* one-line description */
    /* Sets out[n]; the base's is true. Random numbers are the tracer's. */
    void (*select)(const lf_selected_views *views, lf_tracer *tracer, bool *out);
} lf_selection;

extern const lf_selection lf_selection_tv, lf_selection_none, lf_selection_partition;

/* The first is the default, the paper's own; NULL after the last. */
const lf_selection *lf_selection_at(int index);

/* Equation 24 with the two directions of the maxima of a phase function's lobes: straight ahead
 * from either view, or straight back. along and across: the lobe's value towards its own view's
 * direction and towards the other's. */
static inline double lf_lobe_distance(double along, double across)
{
    return along + across > 0.0 ? fabs(along - across) / (along + across) : 0.0;
}

/* Equation 24 as printed, for two lobes' pdfs in two directions (on surfaces: the mirror directions
 * of both views). A lobe that is 0 in both has the distance 1 to a lobe that is not. */
static inline double lf_total_variation(const double p[2], const double q[2])
{
    double sum_p = p[0] + p[1], sum_q = q[0] + q[1];
    if (!(sum_p > 0.0 && sum_q > 0.0))
        return sum_p > 0.0 || sum_q > 0.0;
    return 0.5 * (fabs(p[0] / sum_p - q[0] / sum_q) + fabs(p[1] / sum_p - q[1] / sum_q));
}

#endif
