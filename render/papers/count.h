/* The expected base samples of a pixel, from a map; private to render/. The maps are as in
 * rows/adaptive.h: made after a pilot, from the neighbouring rows and never from the row itself. */
#ifndef LF_RENDER_COUNT_H
#define LF_RENDER_COUNT_H

#include "render/papers/state.h"

/* The count c of a view's pixel in the worker's row; 1 without a map. */
static inline double lf_expected_count(const lf_general *g, const lf_general_worker *w, int view,
                                       int column)
{
    return w->mapped ? (double)w->expected[(size_t)view * (size_t)g->rig.width + (size_t)column]
                     : 1.0;
}

/* A pixel's samples in a visit. */
typedef struct lf_count_share {
    uint32_t begin, end; /* range of sample numbers */
    float alone;         /* weight of each sample that only its own pixel receives */
} lf_count_share;

/* A pixel with c expected samples per cycle has floor(phase + c n) of them after n cycles, phase
 * uniform: correct on average, and never off by one or more. */
lf_count_share lf_count_share_of(double expected, double phase, double n, double share);

#endif
