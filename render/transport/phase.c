#include "render/transport/phase.h"

/* Inversion of the cumulative distribution for |g| about sign(g) w, solved for m = 1 - cos: every
 * term is positive, so that nothing cancels at |g| = 0.9999 (where m is 1e-8) and g = 0 is no
 * special case. */
lf_vec3 lf_phase_sample(float g, lf_vec3 w, const float u[2])
{
    float a = fabsf(g), sign = copysignf(1.0f, g), b = 1.0f - a;
    float d = b + 2.0f * a * (1.0f - u[0]);
    float s = b * (1.0f + a) / d;
    float m = b * u[0] * (s + b) / d;
    float sine = sqrtf(lf_max(m * (2.0f - m), 0.0f)), phi = 2.0f * LF_PI * u[1];
    lf_vec3 axis = lf_scale(w, sign), t, bt;
    lf_tangents(axis, &t, &bt);
    return lf_from_frame(t, bt, axis, lf_v3(sine * cosf(phi), sine * sinf(phi), 1.0f - m));
}
