/* What the integrators of this folder do alike; private to render/general/. */
#ifndef LF_RENDER_ALIKE_H
#define LF_RENDER_ALIKE_H

#include <math.h>

#include "render/integrator.h"
#include "render/rows/rig.h"
#include "render/transport/light.h"
#include "render/transport/sampler.h"

/* What all of them support; those that have surfaces, more. */
#define LF_REFERENCE_SUPPORT                                                                       \
    (LF_TRAITS_PLAIN_MEDIA | LF_TRAITS_LIGHT | LF_TRAIT_LENS | LF_TRAIT_VIEW_BLUR)

/* Which pixels a visit takes: each with probability subsets / n_views, each once in any n_views
 * passes. Column u = first, first + column_step, … takes the views u + start + j, j < subsets;
 * start is uniform in a half's first visit and runs on. */
typedef struct lf_visit_lattice {
    int start, first, views;
} lf_visit_lattice;

/* n, index: native samples a view pixel and visits of the row's half before; key: its own. */
static inline lf_visit_lattice lf_visit_lattice_of(const lf_visit_order *order, uint64_t key,
                                                   double n, uint32_t index, int views)
{
    return (lf_visit_lattice){
        .start =
            (int)((lf_hash64(key, 7) >> 32) % (uint64_t)views) + (int)(llround(n * views) % views),
        .first = (int)((lf_hash64(lf_hash64(key, 3), index) >> 32) % (uint64_t)order->column_step),
        .views = views};
}

static inline int lf_visit_lattice_view(const lf_visit_lattice *lattice, int column, int j)
{
    return (column + lattice->start + j) % lattice->views;
}

/* What a ray of a rig finds that meets nothing; my: the slope of its row's plane. */
static inline lf_vec3 lf_rig_sky(const lf_rig *rig, const lf_scene *seen, lf_vec3 w, float my)
{
    if (seen->backdrop.given)
        return lf_backdrop_at(&seen->backdrop, lf_rig_height_between(rig, my));
    return lf_light_seen(seen, w);
}

#endif
