/* Transmittance of media towards the views, with one density for all channels or, if media are
 * chromatic, one per channel. A table of functions for each; a visit uses one. Private to
 * render/rows/. With chromatic media a base ray draws a channel and is tracked in its extinction
 * only. Prefix densities are for such a ray, D_k = h_k mean_c sigma_t T_k. Each view receives
 * each channel with its own density (docs/developer/estimators/coloured-media.md, "Prefixes"). */
#ifndef LF_RENDER_EXTINCTION_H
#define LF_RENDER_EXTINCTION_H

#include "render/rows/unscattered.h"

typedef struct lf_extinction {
    int channels; /* 1 or 3: number of channels that differ */

    /* For a pivot's fan, in the worker's lanes (mvpt.c): sets tau, or channels.tau, to optical
     * depths per unit of Z, and sigma to the density of the pivot's medium (medium < 0: none). */
    void (*depths)(const lf_visit *visit, int medium);
    /* Sets density from scale and depths; for chromatic media channels.density and their mean. Also
     * sets tau to the minimum over the channels, if the row has lights in media. Returns the sum of
     * density. */
    float (*densities)(const lf_visit *visit, const lf_pivot *pivot);
    /* Multiplies densities by factor[channels][lanes]. */
    void (*weigh)(const lf_visit *visit, const float *factor);
    /* Adds y times density times scale to every view, and density times scale to W. */
    void (*spread)(lf_visit *visit, lf_vec3 y, float scale);

    /* For one view's ray to the pivot, in all of LF_LANES (vpt.c): lf_prefix_own, with
     * factor[channels][LF_LANES] as the received factor. */
    float (*own)(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                 const float *factor, lf_vec3 *out_channels);
    /* sigma_t T exp(*out_depth) of a pivot in a medium. */
    float (*own_density)(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                         float *out_depth);

    /* For the rays of B and q (unscattered.c): depths, and moments if features are needed. */
    void (*march)(const lf_visit *visit, const lf_unscattered_rays *fan);
    /* The light lost along ray k, mean over the channels, and each channel's transmittance. factor:
     * additional transmittance. */
    float (*lost)(const lf_visit *visit, const lf_unscattered_rays *fan, int k, float factor,
                  lf_vec3 *out_transmittance);
} lf_extinction;

extern const lf_extinction lf_extinction_grey, lf_extinction_chromatic;

/* The fraction of light that is lost at this optical depth. *out_transmittance: exp(-depth) times
 * factor. */
static inline float lf_lost_in(float depth, float factor, float *out_transmittance)
{
    float lost = depth > 0.0f ? -expm1f(-depth) : 0.0f;
    /* After 20 mean free paths and more, 1 - lost would have no digits left of the light of a sun
     * or an area light. */
    float transmittance = depth < 0.5f ? 1.0f - lost : expf(-depth);
    lost += transmittance * (1.0f - factor);
    *out_transmittance = transmittance * factor;
    return lost;
}

#endif
