/* Phase functions: Henyey and Greenstein's (1941), mixtures of two, and water droplets; private to
 * render/. cos_theta is the cosine between the directions of travel before and after (1 = straight
 * ahead; g > 0 forward). All integrate to 1 over the sphere. */
#ifndef LF_RENDER_PHASE_H
#define LF_RENDER_PHASE_H

#include "render/scene/scene.h"

/* Value = sampling pdf, per unit solid angle; finite and > 0 for |g| <= 0.9999. */
static inline float lf_phase(float g, float cos_theta)
{
    /* 1 + g^2 - 2 g cos, written so that it does not cancel near g = cos = +-1. */
    float d = (1.0f - g) * (1.0f - g) + 2.0f * g * (1.0f - cos_theta);
    if (g < 0.0f)
        d = (1.0f + g) * (1.0f + g) - 2.0f * g * (1.0f + cos_theta);
    d = lf_max(d, 1e-12f);
    return LF_INV_4PI * (1.0f - g * g) / (d * sqrtf(d));
}

/* lf_phase from the two directions of travel (unit). Use it wherever both are known: the cosine of
 * a nearly straight path does not have enough digits for |g| > 0.99. */
static inline float lf_phase_between(float g, lf_vec3 w, lf_vec3 w_after)
{
    float a = fabsf(g);
    lf_vec3 c = lf_madd(w_after, -copysignf(1.0f, g), w);
    float d = lf_max((1.0f - a) * (1.0f - a) + a * lf_dot(c, c), 1e-12f);
    return LF_INV_4PI * (1.0f - a) * (1.0f + a) / (d * sqrtf(d));
}

/* Draws the direction after scattering for a path travelling along w (unit). */
lf_vec3 lf_phase_sample(float g, lf_vec3 w, const float u[2]);

/* Draine's (2003) factor of Henyey and Greenstein's function: 1 + alpha cos^2, over its mean. */
static inline float lf_phase_draine(float g, float alpha, float cos_theta)
{
    return (1.0f + alpha * cos_theta * cos_theta) /
           (1.0f + alpha * (1.0f + 2.0f * g * g) * (1.0f / 3.0f));
}

/* The phase function of a volume, from the two directions of travel. */
static inline float lf_volume_phase(const lf_volume *volume, lf_vec3 w, lf_vec3 w_after)
{
    const lf_second_lobe *second = &volume->second;
    float first = lf_phase_between(volume->g, w, w_after);
    if (second->share == 0.0f)
        return first;
    return lf_lerp(first,
                   lf_phase_between(second->g, w, w_after) *
                       lf_phase_draine(second->g, second->alpha, lf_dot(w, w_after)),
                   second->share);
}

/* Draws from lf_volume_phase; the third number chooses the lobe. */
lf_vec3 lf_volume_phase_sample(const lf_volume *volume, lf_vec3 w, const float u[3]);

static inline bool lf_volume_is_isotropic(const lf_volume *volume)
{
    return volume->g == 0.0f && volume->second.share == 0.0f;
}

/* Water droplets in light, of 5 to 50 micrometres' diameter, by a Henyey-Greenstein lobe and a
 * Draine lobe. This is the fit of Mie's theory by Jendersie and d'Eon (An Approximate Mie
 * Scattering Function for Fog and Cloud Rendering, 2023, equations 4 to 7). */
void lf_phase_droplets(double diameter, lf_volume *volume);

#endif
