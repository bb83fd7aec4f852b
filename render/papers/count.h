/* How many base samples a pixel expects, where a map says so; private to render/. The maps are
 * those of rows/adaptive.h: made behind a pilot, of the rows beside a row and never of itself. */
#ifndef LF_RENDER_COUNT_H
#define LF_RENDER_COUNT_H

#include "render/papers/state.h"

/* c of a view's pixel in the worker's row; 1 without a map. */
static inline double lf_expected_count(const lf_general *g, const lf_general_worker *w, int view,
                                       int column)
{
    return w->mapped ? (double)w->expected[(size_t)view * (size_t)g->rig.width + (size_t)column]
                     : 1.0;
}

/* What a pixel gets of a visit. */
typedef struct lf_count_share {
    uint32_t begin, end; /* numbers of its samples */
    float alone;         /* of each, what one weighs that only its own pixel receives */
} lf_count_share;

/* A pixel that expects c samples a cycle has floor(phase + c n) of them after n cycles, phase
 * uniform: its own number on average, never one away from it. */
lf_count_share lf_count_share_of(double expected, double phase, double n, double share);

#endif
