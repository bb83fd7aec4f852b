/* A diffuse base under a dielectric coat with GGX roughness. With eta = ior, T = 1 - F(cos), Te = 1 - (diffuse reflectance of the
 * coat from outside) and Ti = Te / eta^2 the same from inside, light that has entered bounces between base and coat:
 *
 *   base = albedo / pi  T(cos_o) T(cos_i) / (eta^2 (1 - albedo (1 - Ti)))  = albedo T T / (pi (eta^2 (1 - albedo) + albedo Te))
 *
 * (the sum of the geometric series over inner reflections; Mitsuba's "plastic" with nonlinear = true, after Wolff 1994). With
 * albedo 1 the base reflects 1 - F(cos_o), so that nothing is lost or won under a smooth coat. */
#include "render/surface_lobes.h"

/* A rough coat reflects up to 5.4e-4 more than F(cos_o) of the smooth one (Fresnel's curve bends upwards; worst at alpha 0.05 to
 * 0.1, eta 1.3, found by quadrature over eta 1..3 and alpha 0.05..1); the base leaves that out. */
#define ROUGH_MARGIN 0.9992f

/* Te: a polynomial in 1 / eta through the integral 2 int_0^1 (1 - F(c)) c dc at Chebyshev nodes; within 1.4e-4 for eta in
 * [1, 3]. */
static float diffuse_transmittance(float eta)
{
    float x = 1.0f / eta;
    float p = 0.60188299f * x - 1.11938060f;
    p = p * x - 0.76703789f;
    p = p * x + 4.05736338f;
    p = p * x - 4.90686123f;
    p = p * x + 3.00284878f;
    return p * x + 0.13104988f;
}

typedef struct plastic {
    float alpha, eta;
    float fresnel_o; /* of the smooth coat for wo */
    float select;    /* probability of drawing wi by the coat's lobe */
    bool rough;
} plastic;

static plastic plastic_init(const lf_material *m, float cos_o)
{
    plastic p = {.alpha = lf_material_alpha(m), .eta = m->ior, .fresnel_o = lf_fresnel_dielectric(lf_min(cos_o, 1.0f), m->ior)};
    float base = (1.0f - p.fresnel_o) * lf_mean3(m->albedo), sum = p.fresnel_o + base;
    p.rough = p.alpha >= LF_ALPHA_MIN;
    p.select = !p.rough ? 0.0f : sum > 0.0f ? p.fresnel_o / sum : 1.0f;
    return p;
}

static float base_component(float albedo, float transmittance, float eta)
{
    return albedo / (eta * eta * (1.0f - albedo) + albedo * transmittance);
}

/* The base towards wi, but for T(cos_o). */
static lf_vec3 base_colour(const lf_material *m, bool rough, float cos_i)
{
    float te = diffuse_transmittance(m->ior), ti = 1.0f - lf_fresnel_dielectric(lf_min(cos_i, 1.0f), m->ior);
    float k = (rough ? ROUGH_MARGIN : 1.0f) * ti * cos_i * LF_INV_PI;
    return lf_v3(k * base_component(m->albedo.x, te, m->ior), k * base_component(m->albedo.y, te, m->ior),
                 k * base_component(m->albedo.z, te, m->ior));
}

/* wo.z > LF_MIN_COS. */
static float eval_local(const lf_material *m, const plastic *p, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (!(wi.z > LF_MIN_COS))
        return 0.0f;
    *f = lf_scale(base_colour(m, p->rough, wi.z), 1.0f - p->fresnel_o);
    float pdf = (1.0f - p->select) * wi.z * LF_INV_PI;
    if (p->rough) {
        lf_ggx_lobe coat = lf_ggx_eval(p->alpha, wo, wi);
        float k = coat.f * lf_fresnel_dielectric(lf_max(coat.cos_oh, 0.0f), p->eta);
        *f = lf_add(*f, lf_v3(k, k, k));
        pdf += p->select * coat.pdf;
    }
    return pdf;
}

float lf_plastic_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    float cos_o = lf_dot(ns, wo);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (!(cos_o > LF_MIN_COS))
        return 0.0f;
    plastic p = plastic_init(m, cos_o);
    lf_frame(ns, &t, &b);
    return eval_local(m, &p, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

/* plastic_init and eval_local for all directions of a fan. */
void lf_plastic_eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z, lf_fan_lobes *out)
{
    float alpha = lf_material_alpha(m), eta = m->ior, mean = lf_mean3(m->albedo), cosine = wi.z * LF_INV_PI;
    bool rough = alpha >= LF_ALPHA_MIN;
    if (!(wi.z > LF_MIN_COS)) {
        lf_fan_clear(n, out);
        return;
    }
    out->colour = base_colour(m, rough, wi.z);
    for (int k = 0; k < n; k++) {
        float above = z[k] > LF_MIN_COS ? 1.0f : 0.0f;
        out->coloured[k] = above * (1.0f - lf_fresnel_dielectric(lf_min(lf_max(z[k], LF_MIN_COS), 1.0f), eta));
        out->pdf[k] = above * cosine;
        out->grey[k] = 0.0f;
    }
    if (!rough)
        return;
    for (int k = 0; k < n; k++) {
        float above = z[k] > LF_MIN_COS ? 1.0f : 0.0f, fresnel = above - out->coloured[k], sum = fresnel + out->coloured[k] * mean;
        float select = sum > 0.0f ? fresnel / sum : 1.0f;
        lf_ggx_lobe coat = lf_ggx_eval(alpha, lf_v3(x[k], y[k], lf_max(z[k], LF_MIN_COS)), wi);
        out->pdf[k] = above * ((1.0f - select) * cosine + select * coat.pdf);
        out->grey[k] = above * coat.f * lf_fresnel_dielectric(lf_max(coat.cos_oh, 0.0f), eta);
    }
}

float lf_plastic_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_frame(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo), i;
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (!(o.z > LF_MIN_COS))
        return 0.0f;
    plastic p = plastic_init(m, o.z);
    if (u[2] < p.select)
        i = lf_ggx_sample(p.alpha, o, u[0], u[1]);
    else
        i = lf_cosine_sample(u[0], u[1]);
    *wi = lf_from_frame(t, b, ns, i);
    return eval_local(m, &p, o, i, f);
}

lf_vec3 lf_plastic_delta(const lf_material *m, lf_vec3 ns, lf_vec3 wo)
{
    float cos_o = lf_dot(ns, wo);
    if (lf_material_alpha(m) >= LF_ALPHA_MIN || !(cos_o > LF_MIN_COS))
        return lf_v3(0.0f, 0.0f, 0.0f);
    float f = lf_fresnel_dielectric(lf_min(cos_o, 1.0f), m->ior);
    return lf_v3(f, f, f);
}
