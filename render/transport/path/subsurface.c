#include "render/transport/path/subsurface.h"

#include "render/transport/path/coloured.h"

/* Limit for meshes in which a walk does not end: a white ball of a thousand mean free paths ends
 * one in 10^6 steps. */
enum { LONGEST_WALK = 1 << 22 };

float lf_subsurface_albedo(float albedo, float g)
{
    float b = 1.139f + 1.17f * albedo,
          s = (b - sqrtf(b * b - 4.0f * 0.139f * (1.0f - albedo))) / (2.0f * 0.139f),
          s2 = lf_min(lf_max(s, 0.0f), 1.0f);
    s2 *= s2;
    return (1.0f - s2) / (1.0f - g * s2);
}

static lf_subsurface subsurface_of(const lf_hit *hit)
{
    const lf_material *m = lf_hit_material(hit);
    float g = m->g;
    lf_vec3 r = m->subsurface_radius;
    return (lf_subsurface){.of = hit->material,
                           .sigma_t = lf_v3(1.0f / r.x, 1.0f / r.y, 1.0f / r.z),
                           .albedo = lf_v3(lf_subsurface_albedo(m->albedo.x, g),
                                           lf_subsurface_albedo(m->albedo.y, g),
                                           lf_subsurface_albedo(m->albedo.z, g)),
                           .g = g};
}

lf_subsurface lf_subsurface_beyond(const lf_event *from, lf_vec3 w)
{
    const lf_subsurface none = {0};
    const lf_hit *hit = &from->hit;
    if (from->kind != LF_EVENT_SURFACE)
        return none;
    if (!(hit->material->subsurface > 0.0f) || !(lf_dot(hit->ng, w) < 0.0f))
        return from->subsurface;
    return hit->front ? subsurface_of(hit) : none;
}

static bool is_inside(const lf_box *box, lf_vec3 p)
{
    return p.x >= box->min.x && p.x <= box->max.x && p.y >= box->min.y && p.y <= box->max.y &&
           p.z >= box->min.z && p.z <= box->max.z;
}

/* One step of the walk from o along w, whose throughput is in *left; true: it ends at a surface. */
static bool step(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, lf_vec3 beta, lf_vec3 *left,
                 lf_event *out)
{
    const lf_subsurface *subsurface = &out->subsurface;
    lf_vec3 carried = lf_mul(beta, *left);
    float way = lf_coloured_segment(tracer, subsurface->sigma_t, carried);
    out->from = o;
    out->w = w;
    bool met = lf_trace_surface(tracer, o, w, way, &out->hit);
    out->t = out->surface = met ? out->hit.t : way;
    *left = lf_mul(
        *left, met ? lf_coloured_passage(carried, subsurface->sigma_t, out->t)
                   : lf_coloured_collision(carried, subsurface->sigma_t,
                                           lf_mul(subsurface->albedo, subsurface->sigma_t), way));
    return met;
}

void lf_subsurface_walk(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                        lf_event *out)
{
    const lf_vec3 one = lf_v3(1.0f, 1.0f, 1.0f), nothing = lf_v3(0.0f, 0.0f, 0.0f);
    lf_vec3 left = one, o = lf_offset(tracer->scene, from->p, from->hit.ng, w, 0.0f);
    out->kind = LF_EVENT_ESCAPE;
    out->interior = from->interior; /* of glass around the mesh, in which the path continues */
    out->channels = one;
    out->left = nothing;
    tracer->width = from->hit.varies ? from->hit.width : 0.0f;
    for (int i = 0; i < LONGEST_WALK; i++) {
        if (step(tracer, o, w, beta, &left, out)) {
            out->kind = LF_EVENT_SURFACE;
            out->p = out->hit.p;
            out->left = left;
            return;
        }
        o = lf_madd(o, out->t, w);
        if (!lf_path_survives(tracer, &left) || !(lf_max3(lf_mul(beta, left)) > 0.0f) ||
            !is_inside(&tracer->scene->bounds, o))
            return;
        const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
        w = lf_phase_sample(out->subsurface.g, w, u);
    }
}
