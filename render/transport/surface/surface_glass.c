#include "render/transport/surface/surface_glass.h"

bool lf_refract(lf_vec3 n, lf_vec3 wo, float eta, lf_vec3 *out)
{
    float cos_o = lf_dot(n, wo), k = 1.0f - (1.0f - cos_o * cos_o) / (eta * eta);
    if (!(k > 0.0f))
        return false;
    *out = lf_normalize(lf_sub(lf_scale(n, cos_o / eta - sqrtf(k)), lf_scale(wo, 1.0f / eta)));
    return true;
}

float lf_glass_reflectance(const lf_material *m, bool inside, float cosine)
{
    float f;
    if (!m->is_solid || !inside) {
        f = lf_fresnel_dielectric(cosine, m->ior);
    } else {
        float outside2 = 1.0f - (1.0f - cosine * cosine) * m->ior * m->ior;
        f = outside2 > 0.0f ? lf_fresnel_dielectric(sqrtf(outside2), m->ior) : 1.0f;
    }
    return m->is_solid ? f : 2.0f * f / (1.0f + f);
}

static float eta_of(const lf_material *m)
{
    return m->glass.is_inside ? 1.0f / m->ior : m->ior;
}

/* E(cos_o). */
static float kept(const lf_material *m, float cos_o)
{
    const float *at = m->glass.kept[m->glass.is_inside];
    if (!m->is_solid) /* all transmitted light would have been reflected by a metal */
        return 1.0f -
               lf_loss_by(m->energy.metal_loss, LF_LOSS_SCALE * lf_material_alpha(m), 0.0f, cos_o);
    float x = cbrtf(cos_o) * (LF_GLASS_NODES - 1);
    int k = (int)lf_min(x, LF_GLASS_NODES - 2);
    return lf_lerp(at[k], at[k + 1], x - (float)k);
}

/* Reflection and refraction at a microfacet for this cosine. */
typedef struct facet {
    lf_vec3 mirrored, through;
    float by_mirror; /* probability */
} facet;

static facet facet_at(const lf_material *m, float cosine)
{
    float c = lf_min(lf_max(cosine, 0.0f), 1.0f),
          reflectance = lf_glass_reflectance(m, m->glass.is_inside, c),
          f = m->specular * reflectance;
    facet out = {lf_scale(m->specular_tint, f), lf_scale(m->albedo, 1.0f - f), 1.0f};
    float through = lf_mean3(out.through), sum = lf_mean3(out.mirrored) + through;
    if (reflectance < 1.0f)
        out.by_mirror = sum > 0.0f ? 1.0f - through / sum : 0.0f;
    return out;
}

/* Refraction, without Fresnel: Walter et al., eq. 16, 17 and 21, by normals visible from wo. */
static lf_ggx_lobe refracted(float alpha, float eta, lf_vec3 wo, lf_vec3 wi)
{
    lf_vec3 h = lf_madd(wo, eta, wi);
    float length2 = lf_dot(h, h);
    lf_ggx_lobe nothing = {0.0f, 0.0f, 1.0f};
    if (!(length2 > 0.0f))
        return nothing;
    h = lf_scale(h, copysignf(1.0f / sqrtf(length2), h.z));
    float oh = lf_dot(wo, h), ih = lf_dot(wi, h), cos_i = -wi.z;
    if (!(oh > 0.0f && ih < 0.0f && h.z > 0.0f))
        return nothing;
    lf_ggx_lobe out = {.cos_oh = lf_min(oh, 1.0f)};
    out.pdf = 2.0f * lf_ggx_d(alpha, h) * oh / (wo.z + lf_ggx_root(alpha, wo.z)) * eta * eta * -ih /
              length2;
    if (cos_i > LF_MIN_COS)
        out.f = out.pdf * 2.0f * cos_i / (cos_i + lf_ggx_root(alpha, cos_i));
    return out;
}

float lf_glass_eval(const lf_material *m, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float alpha = lf_material_alpha(m), scale = 1.0f / kept(m, wo.z);
    lf_ggx_lobe back = lf_ggx_eval(alpha, wo, wi),
                on = m->is_solid ? refracted(alpha, eta_of(m), wo, wi)
                                 : lf_ggx_eval(alpha, wo, lf_v3(wi.x, wi.y, -wi.z));
    facet at_back = facet_at(m, back.cos_oh), at_on = facet_at(m, on.cos_oh);
    *f = lf_madd(lf_scale(at_back.mirrored, scale * back.f), scale * on.f, at_on.through);
    return at_back.by_mirror * back.pdf + (1.0f - at_on.by_mirror) * on.pdf;
}

lf_vec3 lf_glass_sample(const lf_material *m, lf_vec3 wo, const float u[3])
{
    lf_vec3 h = lf_ggx_normal(lf_material_alpha(m), wo, u[0], u[1]), wi;
    float oh = lf_dot(wo, h);
    lf_vec3 mirrored = lf_normalize(lf_sub(lf_scale(h, 2.0f * oh), wo));
    if (u[2] < facet_at(m, oh).by_mirror)
        return mirrored;
    if (!m->is_solid)
        return lf_v3(mirrored.x, mirrored.y, -mirrored.z);
    return lf_refract(h, wo, eta_of(m), &wi) ? wi : mirrored;
}

float lf_thin_passes(const lf_material *m, float cosine)
{
    float c = lf_min(lf_max(cosine, LF_MIN_COS), 1.0f);
    float under = 1.0f - m->coat * lf_fresnel_dielectric(c, LF_COAT_INDEX);
    return m->albedo.x * under * (1.0f - m->specular * lf_glass_reflectance(m, false, c));
}

static bool is_thin(const lf_material *m)
{
    bool is_grey = m->albedo.x == m->albedo.y && m->albedo.y == m->albedo.z;
    return m->transmission == 1.0f && m->metallic == 0.0f && !m->is_solid && is_grey &&
           m->albedo.x > 0.0f && !m->has_lobe && !m->textures && m->cover == LF_COVER_OPAQUE &&
           !(lf_max3(m->emission) > 0.0f);
}

void lf_glass_prepare(lf_material *m)
{
    m->glass.is_thin = is_thin(m);
    m->glass.is_rough = lf_glass_is_rough(m);
    for (int inside = 0; inside < 2 && m->glass.is_rough && m->is_solid; inside++)
        lf_glass_fit(m->ior, inside, m->roughness, m->glass.kept[inside]);
}

void lf_glass_part(lf_material *m, float eta)
{
    const bool lobes = lf_material_alpha(m) >= LF_ALPHA_MIN, was_rough = m->glass.is_rough;
    m->glass.is_parting = true;
    m->glass.is_inside = eta < 1.0f;
    m->ior = eta < 1.0f ? 1.0f / eta : eta;
    if (lobes || m->transmission < 1.0f)
        lf_loss_of_dielectric(m, lobes ? (double)lf_loss_look_up(0.0f, m->roughness, NULL) : 0.0);
    m->glass.is_rough = lf_glass_is_rough(m);
    m->has_delta |= was_rough && !m->glass.is_rough;
    if (m->glass.is_rough)
        lf_glass_look_up(m->ior, m->glass.is_inside, m->roughness,
                         m->glass.kept[m->glass.is_inside]);
}

void lf_glass_vary(lf_material *m)
{
    for (int inside = 0; inside < 2 && m->glass.is_rough && m->is_solid; inside++)
        lf_glass_look_up(m->ior, inside, m->roughness, m->glass.kept[inside]);
}
