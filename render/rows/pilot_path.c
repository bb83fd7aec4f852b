#include "render/rows/pilot_path.h"

static int common_divisor(int a, int b)
{
    while (b != 0) {
        const int rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* Near this share of n, and prime to it: n multiples are n views. */
static int stride(int n, double share)
{
    int step = (int)(share * n);
    while (common_divisor(n, step) > 1)
        step++;
    return step;
}

/* A lattice of the two golden numbers of the plane. */
int lf_pilot_view(int n_views, int column, int row)
{
    return (column * stride(n_views, 0.7548777) + row * stride(n_views, 0.5698403)) % n_views;
}

bool lf_pilot_pivot(lf_tracer *tracer, const lf_rig *rig, int view, const float film[2],
                    lf_event *out, float *out_light)
{
    const lf_scene *scene = tracer->scene;
    const float slope = lf_rig_slope(rig, view, film[0]),
                my = (rig->y0 + film[1] * rig->dy) / rig->distance;
    const lf_vec3 along = lf_rig_direction(rig, slope, my, 1.0f);
    const float length = lf_length(along);
    out->kind = LF_EVENT_SURFACE;
    out->w = lf_scale(along, 1.0f / length);
    tracer->width = 0.0f;
    tracer->spread = lf_rig_spread(rig) / length;
    if (!lf_trace_seen(tracer, lf_rig_point(rig, rig->b[view], 0.0f, 0.0f), out->w, INFINITY,
                       &out->hit)) {
        if (!scene->backdrop.given)
            *out_light = lf_mean3(lf_light_seen(scene, out->w));
        return false;
    }
    const lf_material *material = lf_hit_material(&out->hit);
    out->p = out->hit.p;
    if (lf_max3(material->emission) > 0.0f && !(material->one_sided && !out->hit.front))
        *out_light = lf_mean3(material->emission);
    return material->has_lobe;
}

void lf_pilot_suffix(lf_tracer *tracer, const lf_event *pivot, lf_sampler *sampler, lf_suffix *out)
{
    lf_suffix_draw_light(tracer, pivot, sampler, out);
    lf_suffix_turn(tracer, pivot, lf_scale(pivot->w, -1.0f), sampler, out);
}

void lf_pilot_follow(lf_tracer *tracer, const lf_event *pivot, int max_depth,
                     const lf_light_balance *balance, lf_suffix *suffix)
{
    lf_light_balance own;
    bool shared = false;
    if (balance) {
        own = *balance;
        own.cosine = lf_dot(pivot->hit.ng, suffix->wi);
        shared = own.cosine > 0.0f;
    }
    if (suffix->is_pending)
        lf_suffix_follow_in_balance(tracer, pivot, max_depth, shared ? &own : NULL, suffix);
}

lf_vec3 lf_pilot_radiance(const lf_scene *scene, const lf_event *pivot, const lf_suffix *suffix)
{
    const lf_vec3 y = lf_suffix_radiance(scene, pivot, suffix, lf_scale(pivot->w, -1.0f));
    return isfinite(y.x + y.y + y.z) ? y : lf_v3(0.0f, 0.0f, 0.0f);
}
