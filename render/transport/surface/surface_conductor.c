/* GGX microfacets of metal with multiple-scattering compensation (surface_energy.c). */
#include <string.h>

#include "render/scene/vec_double.h"
#include "render/transport/surface/metal.h"
#include "render/transport/surface/surface_lobes.h"

static float eval_local(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float alpha = lf_material_alpha(m);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (alpha < LF_ALPHA_MIN || !(wo.z > LF_MIN_COS))
        return 0.0f;
    lf_ggx_lobe lobe = lf_ggx_eval(alpha, wo, wi);
    if (lobe.f > 0.0f) {
        lf_vec3 once = lf_scale(lf_conductor_fresnel(m, lobe.cos_oh), lobe.f);
        *f = lf_madd(once, lf_conductor_several(m, wo.z), lf_mul(once, m->rest));
    }
    return lobe.pdf;
}

static float eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    return eval_local(m, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
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
    .fan = LF_FAN_CONDUCTOR,
    .sample = sample,
    .deltas = deltas,
    .view_dependent = true,
};
