/* Factors of the light that a view receives from a pivot or unscattered, besides geometry,
 * occlusion and extinction. Each plane that a visit cuts has a list of the factors that apply. mvpt
 * applies it to all views at once, vpt and native samples to one view, B and q to a fan of rays.
 * Private to render/rows/. docs/developer/estimators.md, "4. How a pivot is shared". */
#ifndef LF_RENDER_PREFIX_FACTOR_H
#define LF_RENDER_PREFIX_FACTOR_H

#include "render/rows/unscattered.h"

/* Functions that a factor does not need are NULL. */
typedef struct lf_prefix_factor {
    /* Whether the factor applies to the visit's plane. */
    bool (*applies)(const lf_visit *visit);
    /* Multiply worker->scale[lanes], the densities with which samples are drawn. between: by the
     * transmittance of surfaces between the pivot and the views, in scenes with such surfaces. at:
     * by the fraction of light that the pivot's own surface intercepts. Only for mvpt: base rays of
     * one view end at random on surfaces that they meet. */
    void (*between)(const lf_visit *visit, const lf_pivot *pivot);
    void (*at)(const lf_visit *visit, const lf_pivot *pivot);
    /* Multiplies factor[1 or 3 channels][rays->n] by the received light along these rays over the
     * sampling density. sampled[rays->n]: the density of the pivot's medium with which rays were
     * drawn, 0: not drawn by this ray. false: the product is 0. */
    bool (*received)(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                     const float *sampled, float *factor);
    /* Multiplies worker->factor of the fan's lanes, or channels.factor, by the unscattered
     * transmittance along its rays up to their ends. */
    void (*along)(const lf_unscattered *e, const lf_unscattered_rays *fan);
} lf_prefix_factor;

/* Sets visit->prefix to the list of a plane that has been cut. */
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

/* Sets factor[channels][rays->n] to the product of all `received`. false: the product is 0. */
bool lf_prefix_received(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                        const float *sampled, float *factor);

/* The ray of one view to a pivot, in all lanes. Do not copy it: rays points into it. */
typedef struct lf_own_ray {
    float x0[LF_LANES], slope[LF_LANES], z_end[LF_LANES];
    lf_rays rays; /* points to the arrays above */
} lf_own_ray;

void lf_own_ray_init(lf_own_ray *out, const lf_visit *visit, int view, const lf_pivot *pivot);

/* The weight of a view's sample that only its own pixel receives; 0: the view does not see the
 * pivot. *out_channels: factor per channel, D R over the mean of D in chromatic media, else 1. */
float lf_prefix_own(const lf_visit *visit, int view, const lf_pivot *pivot, lf_vec3 *out_channels);

#endif
