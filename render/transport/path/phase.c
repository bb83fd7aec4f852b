#include "render/transport/path/phase.h"

/* The direction at 1 - cos = m from the axis. */
static lf_vec3 about(lf_vec3 axis, float m, float u)
{
    float sine = sqrtf(lf_max(m * (2.0f - m), 0.0f)), phi = 2.0f * LF_PI * u;
    lf_vec3 t, bt;
    lf_tangents(axis, &t, &bt);
    return lf_from_frame(t, bt, axis, lf_v3(sine * cosf(phi), sine * sinf(phi), 1.0f - m));
}

/* Inversion of the cumulative distribution for |g| about sign(g) w, solved for m = 1 - cos. Every
 * term is positive, so there is no cancellation at |g| = 0.9999 (where m is 1e-8), and g = 0 is not
 * a special case. */
lf_vec3 lf_phase_sample(float g, lf_vec3 w, const float u[2])
{
    float a = fabsf(g), sign = copysignf(1.0f, g), b = 1.0f - a;
    float d = b + 2.0f * a * (1.0f - u[0]);
    float s = b * (1.0f + a) / d;
    float m = b * u[0] * (s + b) / d;
    return about(lf_scale(w, sign), m, u[1]);
}

/* With s^2 = 1 + g^2 - 2 g cos the density of s is 1 + k (A - s^2)^2 over s^2, A = 1 + g^2 and k =
 * alpha / 4g^2. The integral is elementary, and increases from the forward end. Newton's method,
 * between bounds. */
static float draine_from_forward(float g_, float alpha, float u)
{
    const double g = (double)g_, a = 1.0 + g * g, k = (double)alpha / (4.0 * g * g);
    double lo = 1.0 - g, hi = 1.0 + g, s = lo * hi / (hi - 2.0 * g * (double)u);
    const double p = 1.0 + k * a * a, q = 2.0 * k * a, r = k / 3.0;
    const double from = -p / lo + lo * (r * lo * lo - q), to = -p / hi + hi * (r * hi * hi - q),
                 wanted = from + (double)u * (to - from);
    for (int i = 0; i < 60 && hi - lo > 1e-13; i++) {
        double over = -p / s + s * (r * s * s - q) - wanted, d = a - s * s;
        if (over > 0.0)
            hi = s;
        else
            lo = s;
        double step = over * s * s / (1.0 + k * d * d), next = s - step;
        if (next > lo && next < hi && fabs(step) < 1e-13)
            break;
        s = next > lo && next < hi ? next : 0.5 * (lo + hi);
    }
    return (float)((s - (1.0 - g)) * (s + (1.0 - g)) / (2.0 * g));
}

lf_vec3 lf_volume_phase_sample(const lf_volume *volume, lf_vec3 w, const float u[3])
{
    const lf_second_lobe *second = &volume->second;
    if (!(u[2] < second->share))
        return lf_phase_sample(volume->g, w, u);
    if (!(second->alpha > 0.0f))
        return lf_phase_sample(second->g, w, u);
    return about(w, draine_from_forward(second->g, second->alpha, u[0]), u[1]);
}

void lf_phase_droplets(double d, lf_volume *volume)
{
    volume->g = (float)exp(-0.0990567 / (d - 1.67154));
    volume->second.g = (float)exp(-2.20679 / (d + 3.91029) - 0.428934);
    volume->second.alpha = (float)exp(3.62489 - 8.29288 / (d + 5.52825));
    volume->second.share = (float)exp(-0.599085 / (d - 0.641583) - 0.665888);
}
