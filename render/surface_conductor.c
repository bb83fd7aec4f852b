/* GGX microfacets of metal, brightened by what comes back after several of them (surface_energy.c). */
#include <string.h>

#include "render/surface_lobes.h"

/* 1 / E(cos_o) - 1: how much more than once reflected light there is, were nothing absorbed. */
static inline float several(const lf_material *m, float cos_o)
{
    float loss = lf_loss(m, 0.0f, cos_o);
    return loss / (1.0f - loss);
}

static float eval_local(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float alpha = lf_material_alpha(m);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (alpha < LF_ALPHA_MIN || !(wo.z > LF_MIN_COS))
        return 0.0f;
    lf_ggx_lobe lobe = lf_ggx_eval(alpha, wo, wi);
    if (lobe.f > 0.0f) {
        lf_vec3 once = lf_scale(lf_conductor_fresnel(m, lobe.cos_oh), lobe.f);
        *f = lf_madd(once, several(m, wo.z), lf_mul(once, m->rest));
    }
    return lobe.pdf;
}

float lf_conductor_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    return eval_local(m, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

/* The lobes without Fresnel: of one reflection, and wo.h. */
static void fan_once(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z, float *restrict pdf,
                     float *restrict once, float *restrict cos_oh)
{
    float alpha = lf_material_alpha(m);
    for (int i = 0; i < n; i++) {
        lf_ggx_lobe lobe = lf_ggx_eval(alpha, lf_v3(x[i], y[i], lf_max(z[i], LF_MIN_COS)), wi);
        bool above = z[i] > LF_MIN_COS;
        pdf[i] = above ? lobe.pdf : 0.0f;
        once[i] = above ? lobe.f : 0.0f;
        cos_oh[i] = lobe.cos_oh;
    }
}

/* How much more there is of several reflections. */
static void fan_several(const lf_material *m, int n, const float *z, float *restrict more)
{
    const lf_material own = *m;
    for (int i = 0; i < n; i++)
        more[i] = several(&own, lf_max(z[i], LF_MIN_COS));
}

/* One term a channel. */
void lf_conductor_eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z,
                           lf_fan_lobes *out)
{
    float *restrict once = out->weight[0], *restrict cos_oh = out->weight[1], *restrict more = out->weight[2];
    const lf_material own = *m;
    if (lf_material_alpha(m) < LF_ALPHA_MIN) {
        out->n_terms = 0;
        memset(out->pdf, 0, (size_t)n * sizeof *out->pdf);
        return;
    }
    fan_once(m, wi, n, x, y, z, out->pdf, once, cos_oh);
    fan_several(m, n, z, more);
    for (int i = 0; i < n; i++) {
        lf_vec3 f = lf_conductor_fresnel(&own, cos_oh[i]);
        float g = once[i], s = more[i];
        once[i] = g * f.x + s * (g * f.x * own.rest.x);
        cos_oh[i] = g * f.y + s * (g * f.y * own.rest.y);
        more[i] = g * f.z + s * (g * f.z * own.rest.z);
    }
    out->n_terms = 3;
    out->colour[0] = lf_v3(1.0f, 0.0f, 0.0f);
    out->colour[1] = lf_v3(0.0f, 1.0f, 0.0f);
    out->colour[2] = lf_v3(0.0f, 0.0f, 1.0f);
}

float lf_conductor_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
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
