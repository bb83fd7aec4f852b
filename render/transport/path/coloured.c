#include "render/transport/path/coloured.h"

lf_vec3 lf_coloured_transmittance(lf_vec3 sigma, float t)
{
    return lf_v3(expf(-sigma.x * t), expf(-sigma.y * t), expf(-sigma.z * t));
}

static float mean_by(lf_vec3 by, lf_vec3 x)
{
    return lf_dot(by, x) / (by.x + by.y + by.z);
}

float lf_coloured_segment(lf_tracer *tracer, lf_vec3 sigma, lf_vec3 beta)
{
    float u = (beta.x + beta.y + beta.z) * lf_rng(tracer), one = u < beta.x            ? sigma.x
                                                                 : u < beta.x + beta.y ? sigma.y
                                                                                       : sigma.z;
    return one > 0.0f ? lf_rng_exponential(tracer) / one : INFINITY;
}

lf_vec3 lf_coloured_collision(lf_vec3 beta, lf_vec3 sigma, lf_vec3 keeps, float t)
{
    lf_vec3 left = lf_coloured_transmittance(sigma, t);
    return lf_scale(lf_mul(left, keeps), 1.0f / mean_by(beta, lf_mul(left, sigma)));
}

lf_vec3 lf_coloured_passage(lf_vec3 beta, lf_vec3 sigma, float t)
{
    lf_vec3 left = lf_coloured_transmittance(sigma, t);
    return lf_scale(left, 1.0f / mean_by(beta, left));
}

lf_vec3 lf_dimming_at(const lf_dimming *dimming, float t)
{
    return dimming->is_drawn ? lf_coloured_passage(dimming->beta, dimming->sigma_t, t)
                             : lf_coloured_transmittance(dimming->sigma_t, t);
}

/* int exp(-sigma t) dt from 0 to `way`. */
static float let_out(float sigma, float way)
{
    float depth = sigma * way;
    /* 1 - x/2 is exact there */
    return depth > 1e-4f ? -expm1f(-depth) / sigma : way * (1.0f - 0.5f * depth);
}

lf_vec3 lf_dimming_between(const lf_dimming *dimming, lf_tracer *tracer, float t0, float t1)
{
    const lf_vec3 sigma = dimming->sigma_t;
    const float way = t1 - t0;
    if (dimming->is_drawn)
        return lf_scale(lf_dimming_at(dimming, t0 + lf_rng(tracer) * way), way);
    return lf_mul(lf_coloured_transmittance(sigma, t0),
                  lf_v3(let_out(sigma.x, way), let_out(sigma.y, way), let_out(sigma.z, way)));
}
