#include "render/transport/path/interior.h"

static bool is_filled(const lf_material *m)
{
    return m->is_solid && m->transmission > 0.0f;
}

static const lf_material *beyond(const lf_event *from, lf_vec3 w)
{
    const lf_hit *hit = &from->hit;
    if (from->kind != LF_EVENT_SURFACE || !is_filled(hit->material))
        return from->interior;
    bool through = lf_dot(hit->ng, w) < 0.0f;
    return through == hit->front ? hit->material : NULL;
}

const lf_material *lf_interior_beyond(const lf_scene *scene, const lf_event *from, lf_vec3 w)
{
    const lf_material *in = beyond(from, w);
    return lf_has(scene, LF_TRAIT_NESTED_GLASS) ? lf_nest_beyond_is(scene, from, w, in) : in;
}

static lf_vec3 extinction(const lf_material *m)
{
    return lf_add(m->absorption, m->scattering);
}

lf_vec3 lf_interior_left(const lf_material *in, float t)
{
    return lf_coloured_transmittance(extinction(in), t);
}

float lf_interior_segment(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                          lf_event *out)
{
    const lf_material *in = beyond(from, w);
    if (out->surface < INFINITY && !out->hit.front && is_filled(out->hit.material))
        in = out->hit.material;
    if (lf_has(tracer->scene, LF_TRAIT_NESTED_GLASS))
        in = lf_nest_before_is(tracer->scene, from, w, out, in);
    if (!(out->surface < INFINITY))
        in = NULL; /* no face ends it: the mesh is not closed */
    out->interior = in;
    if (!in || !(lf_max3(in->scattering) > 0.0f))
        return INFINITY;
    return lf_coloured_segment(tracer, extinction(in), beta);
}

lf_dimming lf_interior_dimming(const lf_material *in, lf_vec3 beta)
{
    return (lf_dimming){extinction(in), beta, lf_max3(in->scattering) > 0.0f};
}

void lf_interior_weigh(lf_vec3 beta, lf_event *out)
{
    const lf_material *in = out->interior;
    out->left = lf_v3(1.0f, 1.0f, 1.0f);
    if (!in)
        return;
    float t = lf_min(out->t, out->surface);
    if (!(lf_max3(in->scattering) > 0.0f))
        out->left = lf_interior_left(in, t);
    else if (out->kind == LF_EVENT_MEDIUM && out->volume == LF_INTERIOR)
        out->left = lf_coloured_collision(beta, extinction(in), in->scattering, t);
    else
        out->left = lf_coloured_passage(beta, extinction(in), t);
}
