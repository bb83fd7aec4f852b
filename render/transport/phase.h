/* The Henyey-Greenstein phase function; private to render/. cos_theta is the cosine between the
 * direction of travel before and after (1 = straight on; g > 0 forward). Henyey & Greenstein 1941;
 * integrates to 1 over the sphere. */
#ifndef LF_RENDER_PHASE_H
#define LF_RENDER_PHASE_H

#include "render/scene/vec.h"

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

/* The same from the two directions of travel (unit): to be used wherever both are at hand, because
 * the cosine of a nearly straight path does not carry enough digits for |g| > 0.99. */
static inline float lf_phase_between(float g, lf_vec3 w, lf_vec3 w_after)
{
    float a = fabsf(g);
    lf_vec3 c = lf_madd(w_after, -copysignf(1.0f, g), w);
    float d = lf_max((1.0f - a) * (1.0f - a) + a * lf_dot(c, c), 1e-12f);
    return LF_INV_4PI * (1.0f - a) * (1.0f + a) / (d * sqrtf(d));
}

/* Draws the direction after scattering for a path travelling along w (unit). */
lf_vec3 lf_phase_sample(float g, lf_vec3 w, const float u[2]);

#endif
