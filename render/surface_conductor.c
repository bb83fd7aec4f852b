/* GGX microfacets of metal, and what light does that meets several of them (surface_energy.c). */
#include <string.h>

#include "render/surface_lobes.h"

static float eval_local(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float alpha = lf_material_alpha(m);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (alpha < LF_ALPHA_MIN || !(wo.z > LF_MIN_COS))
        return 0.0f;
    lf_ggx_lobe lobe = lf_ggx_eval(alpha, wo, wi);
    if (wi.z > LF_MIN_COS) {
        lf_vec3 once = lf_scale(lf_conductor_fresnel(m, lobe.cos_oh), lobe.f);
        *f = lf_madd(once, lf_loss(m, 0.0f, wo.z) * lf_loss(m, 0.0f, wi.z) * wi.z, m->rest);
    }
    return lobe.pdf;
}

float lf_conductor_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_frame(ns, &t, &b);
    return eval_local(m, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

/* The lobes without Fresnel; term 0: of one reflection, term 2: of several; *cos_oh for term 0. */
static void fan_geometry(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z, lf_fan_lobes *out)
{
    const lf_material own = *m;
    float alpha = lf_material_alpha(m), several = wi.z > LF_MIN_COS ? lf_loss(m, 0.0f, wi.z) * wi.z : 0.0f;
    for (int i = 0; i < n; i++) {
        float cos_o = lf_max(z[i], LF_MIN_COS);
        lf_ggx_lobe lobe = lf_ggx_eval(alpha, lf_v3(x[i], y[i], cos_o), wi);
        bool above = z[i] > LF_MIN_COS;
        out->pdf[i] = above ? lobe.pdf : 0.0f;
        out->weight[0][i] = above ? lobe.f : 0.0f;
        out->weight[1][i] = lobe.cos_oh;
        out->weight[2][i] = above ? lf_loss(&own, 0.0f, cos_o) * several : 0.0f;
    }
}

void lf_conductor_eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z,
                           lf_fan_lobes *out)
{
    float *const *w = out->weight;
    if (lf_material_alpha(m) < LF_ALPHA_MIN) {
        out->n_terms = 0;
        memset(out->pdf, 0, (size_t)n * sizeof *out->pdf);
        return;
    }
    fan_geometry(m, wi, n, x, y, z, out);
    out->n_terms = 3;
    if (!(m->eta.x > 0.0f)) { /* Schlick's F0 (1 - k) + k */
        for (int i = 0; i < n; i++) {
            float k = lf_schlick(w[1][i]);
            w[1][i] = w[0][i] * k;
            w[0][i] *= 1.0f - k;
        }
        out->colour[0] = m->albedo;
        out->colour[1] = lf_v3(1.0f, 1.0f, 1.0f);
        out->colour[2] = m->rest;
        return;
    }
    const lf_material own = *m;
    for (int i = 0; i < n; i++) {
        lf_vec3 f = lf_v3(lf_fresnel_index(w[1][i], own.eta.x, own.k.x), lf_fresnel_index(w[1][i], own.eta.y, own.k.y),
                          lf_fresnel_index(w[1][i], own.eta.z, own.k.z));
        float once = w[0][i], several = w[2][i];
        w[0][i] = once * f.x + several * own.rest.x;
        w[1][i] = once * f.y + several * own.rest.y;
        w[2][i] = once * f.z + several * own.rest.z;
    }
    out->colour[0] = lf_v3(1.0f, 0.0f, 0.0f);
    out->colour[1] = lf_v3(0.0f, 1.0f, 0.0f);
    out->colour[2] = lf_v3(0.0f, 0.0f, 1.0f);
}

float lf_conductor_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_frame(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo), i = lf_ggx_sample(lf_material_alpha(m), o, u[0], u[1]);
    *wi = lf_from_frame(t, b, ns, i);
    return eval_local(m, o, i, f);
}

lf_vec3 lf_conductor_delta(const lf_material *m, lf_vec3 ns, lf_vec3 wo)
{
    float cos_o = lf_dot(ns, wo);
    if (lf_material_alpha(m) >= LF_ALPHA_MIN || !(cos_o > LF_MIN_COS))
        return lf_v3(0.0f, 0.0f, 0.0f);
    return lf_conductor_fresnel(m, lf_min(cos_o, 1.0f));
}
