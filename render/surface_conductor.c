#include "render/surface_lobes.h"

/* Schlick 1994 with the colour at normal incidence. */
static lf_vec3 schlick(lf_vec3 f0, float cos_theta)
{
    float c = 1.0f - cos_theta, c2 = c * c, k = c2 * c2 * c;
    return lf_v3(f0.x + (1.0f - f0.x) * k, f0.y + (1.0f - f0.y) * k, f0.z + (1.0f - f0.z) * k);
}

static float eval_local(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float alpha = lf_material_alpha(m);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (alpha < LF_ALPHA_MIN || !(wo.z > LF_MIN_COS) || !(wi.z > LF_MIN_COS))
        return 0.0f;
    lf_ggx_lobe lobe = lf_ggx_eval(alpha, wo, wi);
    *f = lf_scale(schlick(m->albedo, lobe.cos_oh), lobe.f);
    return lobe.pdf;
}

float lf_conductor_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_frame(ns, &t, &b);
    return eval_local(m, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

void lf_conductor_eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z,
                           lf_fan_lobes *out)
{
    float alpha = lf_material_alpha(m);
    if (alpha < LF_ALPHA_MIN || !(wi.z > LF_MIN_COS)) {
        lf_fan_clear(n, out);
        return;
    }
    /* Schlick's F0 (1 - k) + k */
    for (int i = 0; i < n; i++) {
        lf_ggx_lobe lobe = lf_ggx_eval(alpha, lf_v3(x[i], y[i], lf_max(z[i], LF_MIN_COS)), wi);
        float c = 1.0f - lobe.cos_oh, c2 = c * c, k = c2 * c2 * c, above = z[i] > LF_MIN_COS ? 1.0f : 0.0f;
        out->pdf[i] = above * lobe.pdf;
        out->coloured[i] = above * lobe.f * (1.0f - k);
        out->grey[i] = above * lobe.f * k;
    }
    out->colour = m->albedo;
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
    return schlick(m->albedo, lf_min(cos_o, 1.0f));
}
