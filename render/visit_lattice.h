/* Which pixels of a row a visit samples, when it distributes them among the views; private to
 * render/. */
#ifndef LF_RENDER_VISIT_LATTICE_H
#define LF_RENDER_VISIT_LATTICE_H

#include <math.h>

#include "render/integrator.h"
#include "render/transport/sampler.h"

/* The pixels of a visit. Each pixel is taken with probability subsets / n_views, and once in any
 * n_views passes, however they are divided into visits. Column u = first, first + column_step, …
 * takes the views step (u + start + j) mod n_views, j < subsets. start is uniform in a half's first
 * visit and continues from there in later visits. */
typedef struct lf_visit_lattice {
    int start, first;
    int step; /* coprime to views */
    int views;
} lf_visit_lattice;

/* The key of the random numbers of one half of a row; random is from lf_visit_order. */
static inline uint64_t lf_visit_key(uint64_t random, int row, int half)
{
    return lf_hash64(lf_hash64(random, (uint64_t)row), (uint64_t)half);
}

/* n, index: native samples per view pixel and visits of the row's half so far; key: lf_visit_key.
 */
static inline lf_visit_lattice lf_visit_lattice_of(const lf_visit_order *order, uint64_t key,
                                                   double n, uint32_t index, int views)
{
    return (lf_visit_lattice){
        .start =
            (int)((lf_hash64(key, 7) >> 32) % (uint64_t)views) + (int)(llround(n * views) % views),
        .first = (int)((lf_hash64(lf_hash64(key, 3), index) >> 32) % (uint64_t)order->column_step),
        .step = 1,
        .views = views};
}

static inline int lf_visit_lattice_view(const lf_visit_lattice *lattice, int column, int j)
{
    return (int)((int64_t)lattice->step * (column + lattice->start + j) % lattice->views);
}

#endif
