/* What media let through on the way to the views, with one density for all light or, where they are
 * chromatic, one a channel: a table of functions each, of which a visit has one; private to
 * render/rows/. Prefix densities of chromatic media are those of a base ray that draws a channel
 * and is tracked in that alone, D_k = h_k mean_c sigma_t T_k, and what a view receives is each
 * channel's own (docs/developer/estimators/coloured-media.md, "Prefixes"). */
#ifndef LF_RENDER_EXTINCTION_H
#define LF_RENDER_EXTINCTION_H

#include "render/rows/unscattered.h"

typedef struct lf_extinction {
    int channels; /* that differ: 1 or 3 */

    /* Of a pivot's fan, the worker's lanes (mvpt.c). Sets tau, or channels.tau, to depths per unit
     * of Z, and sigma to the density of the medium that the pivot is in (< 0: in none). */
    void (*depths)(const lf_visit *visit, int medium);
    /* Sets density, of chromatic media channels.density and their mean, to what scale and depths
     * make of it, and tau, where the row has lights in media, to the least of the channels'.
     * Returns the sum of density. */
    float (*densities)(const lf_visit *visit, const lf_pivot *pivot);
    /* Multiplies densities by factor[channels][lanes]. */
    void (*weigh)(const lf_visit *visit, const float *factor);
    /* Gives every view y times its density times scale, and W that. */
    void (*spread)(lf_visit *visit, lf_vec3 y, float scale);
    /* Gives every view its density times the sum of weight[t] colour[t] over the lobes' terms. */
    void (*spread_lobes)(lf_visit *visit, const lf_fan_lobes *lobes,
                         const lf_vec3 colour[LF_FAN_TERMS]);

    /* Of one view's ray to the pivot, in all of LF_LANES (vpt.c): what lf_prefix_own returns, where
     * factor[channels][LF_LANES] is received. */
    float (*own)(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                 const float *factor, lf_vec3 *out_channels);
    /* sigma_t T exp(*out_depth) of a pivot in a medium. */
    float (*own_density)(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                         float *out_depth);

    /* Of the rays of B and q (unscattered.c): depths, and moments where features are wanted. */
    void (*march)(const lf_visit *visit, const lf_unscattered_rays *fan);
    /* The light that is lost along ray k, in the mean over the channels, and what is left of each;
     * factor: what else takes of it. */
    float (*lost)(const lf_visit *visit, const lf_unscattered_rays *fan, int k, float factor,
                  lf_vec3 *out_transmittance);
} lf_extinction;

extern const lf_extinction lf_extinction_grey, lf_extinction_chromatic;

/* What of light is lost at this optical depth; exp(-depth) times factor is what comes through. */
static inline float lf_lost_in(float depth, float factor, float *out_transmittance)
{
    float lost = depth > 0.0f ? -expm1f(-depth) : 0.0f;
    /* A sun or lamp behind 20 mean free paths and more: 1 - q would have no digits left. */
    float transmittance = depth < 0.5f ? 1.0f - lost : expf(-depth);
    lost += transmittance * (1.0f - factor);
    *out_transmittance = transmittance * factor;
    return lost;
}

#endif
