/* GGX microfacets of metal with multiple-scattering compensation (surface_energy.c). */
#include <string.h>

#include "render/scene/vec_double.h"
#include "render/transport/surface/metal.h"
#include "render/transport/surface/surface_lobes.h"

/* 1 / E(cos_o) - 1: multiply scattered over singly scattered light, without absorption. */
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

static float eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    return eval_local(m, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

/* The lobes without Fresnel: of single scattering, and wo.h. */
static void fan_once(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                     const float *z, float *restrict pdf, float *restrict once,
                     float *restrict cos_oh)
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

/* Adds the multiple-scattering compensation. */
static void fan_several(const lf_material *m, int n, const float *z, float *restrict more)
{
    const lf_material own = *m;
    for (int i = 0; i < n; i++)
        more[i] = several(&own, lf_max(z[i], LF_MIN_COS));
}

/* One term per channel. */
static void eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                     const float *z, lf_fan_lobes *out)
{
    float *restrict once = out->weight[0], *restrict cos_oh = out->weight[1],
                    *restrict more = out->weight[2];
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

static float sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi,
                    lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo), i = lf_ggx_sample(lf_material_alpha(m), o, u[0], u[1]);
    *wi = lf_from_frame(t, b, ns, i);
    return eval_local(m, o, i, f);
}

static int deltas(const lf_material *m, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                  lf_delta out[LF_MAX_DELTAS])
{
    (void)front;
    float cos_o = lf_dot(ns, wo);
    if (!m->has_delta || !(cos_o > LF_MIN_COS))
        return 0;
    out[0] = (lf_delta){lf_mirror(ng, ns, wo), lf_conductor_fresnel(m, lf_min(cos_o, 1.0f))};
    return lf_max3(out[0].f) > 0.0f;
}

/* Light that was not reflected at once has been multiplied by f on average. At each further
 * reflection the share `loss` remains: f^2 (1 - loss) / (1 - f loss) in all. The compensated lobe
 * already contains one f. */
static float rest_of(double f, double loss)
{
    return (float)(f * (1.0 - loss) / (1.0 - f * loss));
}

static void prepare(lf_material *m)
{
    double f[3] = {0.0};
    m->has_lobe = lf_material_alpha(m) >= LF_ALPHA_MIN;
    m->has_delta = !m->has_lobe;
    if (m->has_delta)
        return;
    lf_loss_fit(m, 0.0f);
    for (int i = 0; i < LF_MEAN_STEPS; i++) {
        double weight, cosine = lf_mean_cosine(i, &weight);
        lf_vec3 fresnel = lf_conductor_fresnel(m, (float)cosine);
        f[0] += weight * (double)fresnel.x;
        f[1] += weight * (double)fresnel.y;
        f[2] += weight * (double)fresnel.z;
    }
    double loss = lf_loss_mean(m, 0.0f);
    m->rest = lf_v3(rest_of(f[0], loss), rest_of(f[1], loss), rest_of(f[2], loss));
}

enum { ALBEDO, METAL, ETA, K, ROUGHNESS };

static const lf_param metal_key = {.name = "metal",
                                   .type = LF_PARAM_WORD,
                                   .exclusive = true,
                                   .words = lf_metal_names},
                      eta_key = {.name = "eta",
                                 .type = LF_PARAM_COLOUR,
                                 .exclusive = true,
                                 .low = 0.01,
                                 .high = 20},
                      k_key = {.name = "k", .type = LF_PARAM_COLOUR, .exclusive = true, .high = 20};

static const lf_param *const keys[] = {[ALBEDO] = &lf_principled_albedo,
                                       [METAL] = &metal_key,
                                       [ETA] = &eta_key,
                                       [K] = &k_key,
                                       [ROUGHNESS] = &lf_principled_roughness,
                                       NULL};

/* The colour comes from a metal's name, or from eta and k; albedo is for metals without these. */
static const char *check(const lf_value values[], const lf_material *m, const lf_param **out_key)
{
    (void)m;
    bool metal = values[METAL].given, eta = values[ETA].given, k = values[K].given;
    *out_key = &lf_principled_albedo;
    if (values[ALBEDO].given && (metal || eta || k))
        return metal ? "\"metal\" already sets the colour; remove one of the keys"
               : eta ? "\"eta\" already sets the colour; remove one of the keys"
                     : "\"k\" already sets the colour; remove one of the keys";
    *out_key = metal == eta ? &eta_key : &k_key;
    if (metal && (eta || k))
        return "\"metal\" already sets eta and k; remove one of the keys";
    *out_key = eta ? &k_key : &eta_key;
    return eta != k ? "eta and k must be given together" : NULL;
}

static void read(const lf_value values[], lf_material *m)
{
    if (values[METAL].given) {
        const lf_metal *metal = &lf_metals[values[METAL].word];
        m->eta = metal->eta;
        m->k = metal->k;
    } else if (values[ETA].given) {
        m->eta = lf_to_vec3(values[ETA].number);
        m->k = lf_to_vec3(values[K].number);
    }
}

const lf_surface_kind lf_surface_conductor = {
    .name = "conductor",
    .keys = keys,
    .lacks = "metals use eta and k",
    .check = check,
    .read = read,
    .prepare = prepare,
    .eval = eval,
    .eval_fan = eval_fan,
    .sample = sample,
    .deltas = deltas,
    .view_dependent = true,
};
