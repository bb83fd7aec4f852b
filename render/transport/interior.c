#include "render/transport/interior.h"

static bool is_filled(const lf_material *m)
{
    return m->is_solid && m->transmission > 0.0f;
}

const lf_material *lf_interior_beyond(const lf_event *from, lf_vec3 w)
{
    const lf_hit *hit = &from->hit;
    if (from->kind != LF_EVENT_SURFACE || !is_filled(hit->material))
        return from->interior;
    bool through = lf_dot(hit->ng, w) < 0.0f;
    return through == hit->front ? hit->material : NULL;
}

static lf_vec3 extinction(const lf_material *m)
{
    return lf_add(m->glass.absorption, m->glass.scattering);
}

static lf_vec3 transmittance(lf_vec3 sigma, float t)
{
    return lf_v3(expf(-sigma.x * t), expf(-sigma.y * t), expf(-sigma.z * t));
}

lf_vec3 lf_interior_left(const lf_material *in, float t)
{
    return transmittance(extinction(in), t);
}

static float mean_by(lf_vec3 by, lf_vec3 x)
{
    return lf_dot(by, x) / (by.x + by.y + by.z);
}

float lf_coloured_way(lf_tracer *tracer, lf_vec3 sigma, lf_vec3 beta)
{
    float u = (beta.x + beta.y + beta.z) * lf_rng(tracer), one = u < beta.x            ? sigma.x
                                                                 : u < beta.x + beta.y ? sigma.y
                                                                                       : sigma.z;
    return one > 0.0f ? lf_rng_exponential(tracer) / one : INFINITY;
}

lf_vec3 lf_coloured_collision(lf_vec3 beta, lf_vec3 sigma, lf_vec3 keeps, float t)
{
    lf_vec3 left = transmittance(sigma, t);
    return lf_scale(lf_mul(left, keeps), 1.0f / mean_by(beta, lf_mul(left, sigma)));
}

lf_vec3 lf_coloured_passage(lf_vec3 beta, lf_vec3 sigma, float t)
{
    lf_vec3 left = transmittance(sigma, t);
    return lf_scale(left, 1.0f / mean_by(beta, left));
}

float lf_interior_way(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                      lf_event *out)
{
    const lf_material *in = lf_interior_beyond(from, w);
    if (out->surface < INFINITY && !out->hit.front && is_filled(out->hit.material))
        in = out->hit.material;
    if (!(out->surface < INFINITY))
        in = NULL; /* no face ends it: the mesh is not closed */
    out->interior = in;
    if (!in || !(lf_max3(in->glass.scattering) > 0.0f))
        return INFINITY;
    return lf_coloured_way(tracer, extinction(in), beta);
}

void lf_interior_weigh(lf_vec3 beta, lf_event *out)
{
    const lf_material *in = out->interior;
    out->left = lf_v3(1.0f, 1.0f, 1.0f);
    if (!in)
        return;
    float t = lf_min(out->t, out->surface);
    if (!(lf_max3(in->glass.scattering) > 0.0f))
        out->left = lf_interior_left(in, t);
    else if (out->kind == LF_EVENT_MEDIUM && out->volume == LF_INTERIOR)
        out->left = lf_coloured_collision(beta, extinction(in), in->glass.scattering, t);
    else
        out->left = lf_coloured_passage(beta, extinction(in), t);
}
