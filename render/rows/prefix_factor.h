/* Factors of what a view receives of a pivot, and of what comes to it unscattered, beside geometry,
 * surfaces that hide and extinction: a list, made for each plane that a visit cuts, of those that
 * apply there; private to render/rows/. mvpt walks it for all views at once, vpt and native samples
 * for one, B and q for a fan of rays. docs/developer/estimators.md, "4. How a pivot is shared". */
#ifndef LF_RENDER_PREFIX_FACTOR_H
#define LF_RENDER_PREFIX_FACTOR_H

#include "render/rows/unscattered.h"

/* What a factor does not touch is NULL. */
typedef struct lf_prefix_factor {
    /* Whether the visit's plane has it. */
    bool (*applies)(const lf_visit *visit);
    /* Multiplies worker->scale[lanes], which samples are drawn with: by what surfaces between the
     * pivot and the views let through, of scenes that have some; and by what of their light the
     * pivot itself meets. Of mvpt: base rays of one view end by chance on what they meet. */
    void (*between)(const lf_visit *visit, const lf_pivot *pivot);
    void (*at)(const lf_visit *visit, const lf_pivot *pivot);
    /* Multiplies factor[1 or 3 channels][rays->n] by what is received of the pivot along these rays
     * over what samples are drawn with; sampled[rays->n]: the density of its medium as rays were
     * drawn with it, 0: not by this one. false: nothing is there. */
    bool (*received)(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                     const float *sampled, float *factor);
    /* Multiplies worker->factor of the fan's lanes, or channels.factor, by what comes unscattered
     * along its rays up to their ends. */
    void (*along)(const lf_unscattered *e, const lf_unscattered_rays *fan);
} lf_prefix_factor;

/* Finds the list of a plane that has been cut: visit->prefix. */
void lf_prefix_find(lf_visit *visit);

static inline void lf_prefix_between(const lf_visit *visit, const lf_pivot *pivot)
{
    for (int i = 0; i < visit->prefix.n; i++)
        if (visit->prefix.factor[i]->between)
            visit->prefix.factor[i]->between(visit, pivot);
}

static inline void lf_prefix_at(const lf_visit *visit, const lf_pivot *pivot)
{
    for (int i = 0; i < visit->prefix.n; i++)
        if (visit->prefix.factor[i]->at)
            visit->prefix.factor[i]->at(visit, pivot);
}

static inline void lf_prefix_along(const lf_unscattered *e, const lf_unscattered_rays *fan)
{
    const lf_prefix_list *prefix = &e->visit->prefix;
    for (int i = 0; i < prefix->n; i++)
        if (prefix->factor[i]->along)
            prefix->factor[i]->along(e, fan);
}

/* Sets factor[channels][rays->n] to the product of what is received. false: nothing is there. */
bool lf_prefix_received(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                        const float *sampled, float *factor);

/* The ray of one view to a pivot, in all lanes. Stays where it is. */
typedef struct lf_own_ray {
    float x0[LF_LANES], slope[LF_LANES], z_end[LF_LANES];
    lf_rays rays; /* of these */
} lf_own_ray;

void lf_own_ray_init(lf_own_ray *out, const lf_visit *visit, int view, const lf_pivot *pivot);

/* What a sample of a view weighs that only its own pixel receives, 0: nothing is there.
 * *out_channels: times this in each of them, D R over the mean of D in chromatic media, else 1. */
float lf_prefix_own(const lf_visit *visit, int view, const lf_pivot *pivot, lf_vec3 *out_channels);

#endif
