/* Which views share a prefix with the view that drew it; private to render/. One file a kind, a
 * line in the table of selection.c.
 *
 * What the views' lobes at the pivot differ by is their total variation distance, 0 to 1, seen
 * through two directions (Fraboni et al. 2022, equation 24), as the caller gives it. Weights are
 * made over what is selected, c_j q_j / sum_{k selected} c_k q_k (equation 23).
 *
 *   tv         each view is taken or left by a draw of its own, with probability 1 - TV(base, view)
 *              (section 4.3). AS PRINTED, and inconsistent: which views stand in the sum depends on
 *              the base, so that weights do not sum to 1 over the bases, and N/W converges to a
 *              value that is off by what docs/developer/papers.md says.
 *   none       all views, always.
 *   partition  the line of cameras is cut where D_k = sum of TV(l - 1, l), l = 1..k, passes whole
 *              numbers behind one uniform offset: views share with probability max(0, 1 - |D_i -
 *              D_j|), and whatever was drawn, groups do not depend on the base, so that weights sum
 *              to 1: mis and cv are unbiased, mwis is consistent. Not in the paper. */
#ifndef LF_RENDER_SELECTION_H
#define LF_RENDER_SELECTION_H

#include <stdbool.h>

#include "render/papers/papers.h"
#include "render/transport/path/track.h"

/* What is selected from: n views in their order along the cameras' line. */
typedef struct lf_selected_views {
    int n, base;
    double (*distance)(const void *lobes, int a, int b); /* 0..1, the same either way */
    const void *lobes;
} lf_selected_views;

typedef struct lf_selection {
    const char *name; /* as in --selection */
    const char *what; /* in a few words */
    /* out[n]; that of the base is true. Random numbers are the tracer's. */
    void (*select)(const lf_selected_views *views, lf_tracer *tracer, bool *out);
} lf_selection;

extern const lf_selection lf_selection_tv, lf_selection_none, lf_selection_partition;

/* The first is the default, the paper's own; NULL behind the last. */
const lf_selection *lf_selection_at(int index);

/* Equation 24 with the two directions in which the lobes of a phase function are highest: straight
 * on from either view, or straight back. along and across: the lobe's value there towards its own
 * view's direction and towards the other's. */
static inline double lf_lobe_distance(double along, double across)
{
    return along + across > 0.0 ? fabs(along - across) / (along + across) : 0.0;
}

/* Equation 24 as it stands, of two lobes' pdfs in two directions (surfaces: the mirror directions
 * of both views). Lobes that are 0 in both are as unlike as can be to one that is not. */
static inline double lf_total_variation(const double p[2], const double q[2])
{
    double sum_p = p[0] + p[1], sum_q = q[0] + q[1];
    if (!(sum_p > 0.0 && sum_q > 0.0))
        return sum_p > 0.0 || sum_q > 0.0;
    return 0.5 * (fabs(p[0] / sum_p - q[0] / sum_q) + fabs(p[1] / sum_p - q[1] / sum_q));
}

#endif
