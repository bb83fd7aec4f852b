/* glTF's layered model (2.0, appendix B; KHR_materials_clearcoat, _specular, _transmission,
 * _volume), with energy conserved where glTF's own formulas lose or add it. From the top, each
 * layer transmitting the light that it does not reflect:
 *
 *   coat          GGX, index 1.5, about its own normal if the base's is bent; the layers below
 *                 receive 1 - coat E_coat(cos_o)
 *   sheen         fibres (surface_sheen.h); the layers below receive 1 - max(sheen) E_sheen(cos_o)
 *   metal         the share `metallic`: a conductor of colour albedo (surface_conductor.c)
 *   dielectric    the remaining share: GGX of index ior times specular, and below it one of
 *     diffuse     albedo / pi  loss(cos_o) loss(cos_i) / mean loss
 *     glass       the share `transmission`: unreflected light continues, refracted or, through a
 *                 sheet, straight, tinted by albedo
 *     subsurface  the share `subsurface` of diffuse light: loss(cos_o) cos_i / pi inwards, and from
 *                 inside loss(cos_i) cos_i / (pi mean loss) outwards, with no other lobe
 *
 * loss(cos) = 1 - specular E(cos), E of the GGX lobe (surface_energy.c), including multiple
 * scattering if the index is above 3. Diffuse light is coupled as in Ashikhmin and Shirley (2000)
 * and Kelemen, so that albedo is the visible colour: white returns loss(cos_o), and the sum is 1 at
 * every angle. Plastic, whose albedo is the pigment's, is darker by its internal reflection; both
 * agree if albedo is 0 or 1.
 *
 * Anisotropy (KHR_materials_anisotropy) gives the lobe of metal and dielectric two alphas
 * (surface_anisotropy.h). E is then the albedo of the isotropic lobe with the root of their mean
 * square. So a white metal returns 1 within 0.02 at alphas of 0.3 and 0.1, 0.04 at 0.5 and 0.25,
 * 0.1 at 1 and 0.1, where it is 1.07 from above. Transmission through rough glass is a lobe as
 * well, surface_glass.c. */
#include <string.h>

#include "render/scene/vec_double.h"
#include "render/transport/surface/surface_anisotropy.h"
#include "render/transport/surface/surface_glass.h"
#include "render/transport/surface/surface_sheen.h"

/* Data of a material that all directions share. */
typedef struct layers {
    const lf_material *m; /* loss: of the dielectric */
    float alpha, coat_alpha;
    /* shares: of the dielectric, by its own lobes and as rough glass; of metal; of the layer below;
     * and of light that enters subsurface */
    float dielectric, glass, metal, below, subsurface;
    bool rough, coated, rough_coat, sheened, apart;
    lf_vec3 coat_axis[3]; /* apart: of the coat's frame, in the base's */
} layers;

/* The shares for one direction wo, and the probabilities of drawing from each lobe. */
typedef struct shares {
    float under;   /* the coat: what the rest gets */
    float beneath; /* the sheen, likewise */
    float enters;  /* loss(cos_o) */
    float several;
    float by_far;                      /* rough glass or subsurface; else … */
    float by_coat, by_gloss, by_sheen; /* … the rest is diffuse */
} shares;

static layers layers_of(const lf_material *m)
{
    layers l = {.m = m, .alpha = lf_material_alpha(m)};
    l.rough = l.alpha >= LF_ALPHA_MIN;
    l.coated = m->coat > 0.0f;
    l.coat_alpha = m->coat_roughness * m->coat_roughness;
    l.rough_coat = l.coated && l.coat_alpha >= LF_ALPHA_MIN;
    l.sheened = lf_max3(m->sheen) > 0.0f;
    l.apart = l.coated && m->coat_normal.z > 0.0f;
    if (l.apart) {
        l.coat_axis[2] = m->coat_normal;
        lf_tangents(m->coat_normal, &l.coat_axis[0], &l.coat_axis[1]);
    }
    l.metal = m->metallic;
    l.glass = m->glass.is_rough ? (1.0f - m->metallic) * m->transmission : 0.0f;
    l.below = (1.0f - m->metallic) * (1.0f - m->transmission);
    l.dielectric = m->glass.is_rough ? l.below : 1.0f - m->metallic;
    l.subsurface = l.below * m->subsurface;
    l.below -= l.subsurface;
    return l;
}

static inline bool has_far_lobe(const layers *l)
{
    return l->glass > 0.0f || l->subsurface > 0.0f;
}

/* 1 - E of the dielectric's lobe. */
static inline float coat_loss(const lf_material *m, float cosine)
{
    float smooth = m->energy.smooth_scale * lf_coat_transmittance(m->energy.smooth_ior, cosine);
    return 1.0f - m->specular * (1.0f - lf_loss(m, smooth, cosine));
}

/* 1 - E of the clear coat. */
static inline float clear_loss(const lf_material *m, float cosine)
{
    float a = LF_LOSS_SCALE * m->coat_roughness * m->coat_roughness;
    return lf_loss_by(m->energy.coat_loss, a, lf_coat_transmittance(LF_COAT_INDEX, cosine), cosine);
}

/* Albedo of the fibres, in their strongest channel. */
static inline float sheen_share(const lf_material *m, float cosine)
{
    return lf_max3(m->sheen) * lf_sheen_albedo(m->sheen_roughness, cosine);
}

static inline float metal_several(const lf_material *m, float cosine)
{
    float loss =
        lf_loss_by(m->energy.metal_loss, LF_LOSS_SCALE * lf_material_alpha(m), 0.0f, cosine);
    return loss / (1.0f - loss);
}

/* Whether a lobe is not about the base's normal, or not isotropic. */
static inline bool is_special(const lf_material *m)
{
    return lf_is_anisotropic(m) || m->coat_normal.z > 0.0f;
}

static inline lf_vec3 to_coat(const layers *l, lf_vec3 w)
{
    return lf_to_frame(l->coat_axis[0], l->coat_axis[1], l->coat_axis[2], w);
}

/* The coat's share along wo, with cos_o to the base: 0 if it is seen from behind. */
static inline float coat_share(const layers *l, bool special, lf_vec3 wo, float cos_o)
{
    float cosine = special && l->apart ? lf_min(lf_dot(l->coat_axis[2], wo), 1.0f) : cos_o;
    if (special && !(cosine > LF_MIN_COS))
        return 0.0f;
    return l->m->coat * (1.0f - clear_loss(l->m, cosine));
}

static inline __attribute__((always_inline)) shares shares_of(const layers *l, bool special,
                                                              lf_vec3 wo, float cos_o)
{
    const lf_material *m = l->m;
    shares s = {.under = 1.0f, .enters = coat_loss(m, cos_o)};
    float coat = l->coated ? coat_share(l, special, wo, cos_o) : 0.0f,
          sheen = l->sheened ? sheen_share(m, cos_o) : 0.0f;
    s.under = 1.0f - coat;
    s.beneath = 1.0f - sheen;
    s.several = l->rough ? metal_several(m, cos_o) : 0.0f;
    float gloss = l->rough ? l->dielectric * (1.0f - s.enters) + l->metal * m->energy.mean_fresnel
                           : 0.0f,
          diffuse = l->below * s.enters * lf_mean3(m->albedo), base = gloss + diffuse,
          sum = sheen + s.beneath * base;
    s.by_coat = l->rough_coat ? (sum > 0.0f ? coat / (coat + s.under * sum) : 1.0f) : 0.0f;
    if (special && !(coat > 0.0f))
        s.by_coat = 0.0f;
    s.by_sheen = sheen > 0.0f ? (1.0f - s.by_coat) * sheen / sum : 0.0f;
    float rest = 1.0f - s.by_coat - s.by_sheen;
    s.by_gloss = base > 0.0f ? rest * gloss / base : rest * (float)l->rough;
    if (has_far_lobe(l)) {
        float far =
                  s.under * s.beneath * (l->glass + l->subsurface * s.enters * lf_mean3(m->albedo)),
              others = (l->rough_coat ? coat : 0.0f) + s.under * sum;
        s.by_far = others > 0.0f ? far / (far + others) : 1.0f;
    }
    return s;
}

/* The factor of the GGX lobe that metal and dielectric share: their Fresnel terms at cos_oh with
 * multiple-scattering compensation, without what the coat leaves (`under`). */
static inline lf_vec3 gloss_colour(const layers *l, const shares *s, float cos_oh)
{
    const lf_material *m = l->m;
    float c = lf_max(cos_oh, 0.0f), k = lf_schlick(c),
          dielectric = l->dielectric * m->specular * lf_fresnel_dielectric(c, m->ior) *
                       (1.0f + s->several * m->energy.rest);
    lf_vec3 metal = lf_v3(lf_lerp(m->albedo.x, 1.0f, k), lf_lerp(m->albedo.y, 1.0f, k),
                          lf_lerp(m->albedo.z, 1.0f, k));
    return lf_v3(
        dielectric * m->specular_tint.x + l->metal * metal.x * (1.0f + s->several * m->rest.x),
        dielectric * m->specular_tint.y + l->metal * metal.y * (1.0f + s->several * m->rest.y),
        dielectric * m->specular_tint.z + l->metal * metal.z * (1.0f + s->several * m->rest.z));
}

/* Diffuse light towards wi, without the transmittance of the layers above along wo. */
static lf_vec3 base_colour(const layers *l, float cos_i)
{
    if (!(cos_i > LF_MIN_COS))
        return lf_v3(0.0f, 0.0f, 0.0f);
    return lf_scale(l->m->albedo,
                    l->below * LF_INV_PI * cos_i * coat_loss(l->m, cos_i) / l->m->energy.mean_loss);
}

/* A coat's lobe about its own normal. */
static inline lf_ggx_lobe coat_lobe(const layers *l, lf_vec3 wo, lf_vec3 wi)
{
    if (!l->apart)
        return lf_ggx_eval(l->coat_alpha, wo, wi);
    lf_vec3 o = to_coat(l, wo);
    return o.z > LF_MIN_COS ? lf_ggx_eval(l->coat_alpha, o, to_coat(l, wi))
                            : (lf_ggx_lobe){.cos_oh = 1.0f};
}

static inline lf_ggx_lobe gloss_lobe(const layers *l, lf_vec3 wo, lf_vec3 wi)
{
    return lf_is_anisotropic(l->m) ? lf_anisotropic_eval(&l->m->anisotropic, wo, wi)
                                   : lf_ggx_eval(l->alpha, wo, wi);
}

/* Towards wi from wo.z > LF_MIN_COS; base: base_colour of wi. Inline, so that common materials have
 * no branch for special ones. */
static inline __attribute__((always_inline)) float eval_lobes(const layers *l, const shares *s,
                                                              bool special, lf_vec3 base,
                                                              lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float cosine = wi.z > LF_MIN_COS ? wi.z * LF_INV_PI : 0.0f,
          pdf = (1.0f - s->by_coat - s->by_sheen - s->by_gloss) * cosine;
    *f = lf_scale(base, s->enters);
    if (l->rough) {
        lf_ggx_lobe lobe = special ? gloss_lobe(l, wo, wi) : lf_ggx_eval(l->alpha, wo, wi);
        *f = lf_madd(*f, lobe.f, gloss_colour(l, s, lobe.cos_oh));
        pdf += s->by_gloss * lobe.pdf;
    }
    if (l->sheened) {
        *f = lf_madd(lf_scale(*f, s->beneath), lf_sheen_eval(l->m->sheen_roughness, wo, wi),
                     l->m->sheen);
        pdf += wi.z > LF_MIN_COS ? s->by_sheen * (0.5f * LF_INV_PI) : 0.0f;
    }
    *f = lf_scale(*f, s->under);
    if (l->rough_coat) {
        lf_ggx_lobe lobe = special ? coat_lobe(l, wo, wi) : lf_ggx_eval(l->coat_alpha, wo, wi);
        float k =
            l->m->coat * lobe.f * lf_fresnel_dielectric(lf_max(lobe.cos_oh, 0.0f), LF_COAT_INDEX);
        *f = lf_add(*f, lf_v3(k, k, k));
        pdf += s->by_coat * lobe.pdf;
    }
    return pdf;
}

static float eval_local(const layers *l, const shares *s, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 base = base_colour(l, wi.z);
    return is_special(l->m) ? eval_lobes(l, s, true, base, wo, wi, f)
                            : eval_lobes(l, s, false, base, wo, wi, f);
}

/* Adds rough glass, or light that enters subsurface, to the other lobes; returns the pdf of all. */
static float add_far(const layers *l, const shares *s, lf_vec3 wo, lf_vec3 wi, float pdf,
                     lf_vec3 *f)
{
    float share = s->under * s->beneath, own = wi.z < -LF_MIN_COS ? -wi.z * LF_INV_PI : 0.0f;
    lf_vec3 through = lf_v3(own, own, own);
    if (l->glass > 0.0f)
        own = lf_glass_eval(l->m, wo, wi, &through);
    *f = lf_madd(*f, share * (l->glass > 0.0f ? l->glass : l->subsurface * s->enters), through);
    return lf_lerp(pdf, own, s->by_far);
}

/* Light that leaves subsurface, towards wi from any wo inside. */
static float leave(const lf_material *m, lf_vec3 wi, lf_vec3 *f)
{
    float pdf = wi.z < -LF_MIN_COS ? -wi.z * LF_INV_PI : 0.0f,
          out = pdf > 0.0f ? pdf * coat_loss(m, lf_min(-wi.z, 1.0f)) / m->energy.mean_loss : 0.0f;
    *f = lf_v3(out, out, out);
    return pdf;
}

static float eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    float cos_o = lf_dot(ns, wo);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    lf_tangents(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo), i = lf_to_frame(t, b, ns, wi);
    if (lf_is_way_out(m))
        return leave(m, i, f);
    if (!(cos_o > LF_MIN_COS))
        return 0.0f;
    layers l = layers_of(m);
    shares s = shares_of(&l, is_special(m), o, lf_min(cos_o, 1.0f));
    float pdf = eval_local(&l, &s, o, i, f);
    return has_far_lobe(&l) ? add_far(&l, &s, o, i, pdf, f) : pdf;
}

static void add_far_fan(const layers *l, lf_vec3 wi, int n, const float *const o[3],
                        lf_fan_lobes *out)
{
    for (int k = 0; k < n; k++) {
        lf_vec3 f = lf_v3(out->weight[0][k], out->weight[1][k], out->weight[2][k]);
        if (!(o[2][k] > LF_MIN_COS) && !lf_is_way_out(l->m))
            continue;
        lf_vec3 wo = lf_v3(o[0][k], o[1][k], lf_min(o[2][k], 1.0f));
        shares s = shares_of(l, is_special(l->m), wo, wo.z);
        out->pdf[k] =
            lf_is_way_out(l->m) ? leave(l->m, wi, &f) : add_far(l, &s, wo, wi, out->pdf[k], &f);
        out->weight[0][k] = f.x;
        out->weight[1][k] = f.y;
        out->weight[2][k] = f.z;
    }
}

/* eval_local for all directions of a fan: one term per channel. Inline, with layers whose flags the
 * caller knows, so that no branches remain and the compiler vectorises it. */
static inline __attribute__((always_inline)) void fan_of(layers l, bool special, lf_vec3 wi, int n,
                                                         const float *x, const float *y,
                                                         const float *z, lf_fan_lobes *out)
{
    float *restrict pdf = out->pdf, *restrict red = out->weight[0],
                    *restrict green = out->weight[1], *restrict blue = out->weight[2];
    const lf_vec3 base = base_colour(&l, wi.z);
#pragma GCC ivdep /* GCC forgets restrict when a function is inlined */
    for (int k = 0; k < n; k++) {
        float cos_o = lf_min(lf_max(z[k], LF_MIN_COS), 1.0f),
              above = z[k] > LF_MIN_COS ? 1.0f : 0.0f;
        lf_vec3 f;
        shares s = shares_of(&l, special, lf_v3(x[k], y[k], cos_o), cos_o);
        pdf[k] = above * eval_lobes(&l, &s, special, base, lf_v3(x[k], y[k], cos_o), wi, &f);
        red[k] = above * f.x;
        green[k] = above * f.y;
        blue[k] = above * f.z;
    }
}

/* fan_of for the most common surfaces: a rough base, a rough coat or none. */
static void fan_of_gloss(const layers *of, lf_vec3 wi, int n, const float *x, const float *y,
                         const float *z, lf_fan_lobes *out)
{
    layers l = *of;
    l.glass = l.subsurface = 0.0f; /* separate lobes, added later */
    l.rough = true;
    l.sheened = l.apart = l.coated = l.rough_coat = false;
    if (of->coated) {
        l.coated = l.rough_coat = true;
        fan_of(l, false, wi, n, x, y, z, out);
    } else
        fan_of(l, false, wi, n, x, y, z, out);
}

static void eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                     const float *z, lf_fan_lobes *out)
{
    const layers l = layers_of(m);
    if (is_special(m))
        fan_of(l, true, wi, n, x, y, z, out);
    else if (l.rough && l.coated == l.rough_coat && !l.sheened)
        fan_of_gloss(&l, wi, n, x, y, z, out);
    else
        fan_of(l, false, wi, n, x, y, z, out);
    if (has_far_lobe(&l) || lf_is_way_out(m))
        add_far_fan(&l, wi, n, (const float *[3]){x, y, z}, out);
    out->n_terms = 3;
    out->colour[0] = lf_v3(1.0f, 0.0f, 0.0f);
    out->colour[1] = lf_v3(0.0f, 1.0f, 0.0f);
    out->colour[2] = lf_v3(0.0f, 0.0f, 1.0f);
}

/* Malley's cosine, on the other side. */
static lf_vec3 inwards(const float u[3])
{
    lf_vec3 w = lf_cosine_sample(u[0], u[1]);
    return lf_v3(w.x, w.y, -w.z);
}

static lf_vec3 draw(const layers *l, const shares *s, lf_vec3 o, const float u[3])
{
    float by = u[2];
    if (has_far_lobe(l)) {
        if (by < s->by_far)
            return l->glass > 0.0f
                       ? lf_glass_sample(l->m, o, (const float[3]){u[0], u[1], by / s->by_far})
                       : inwards(u);
        by = (by - s->by_far) / (1.0f - s->by_far);
    }
    if (by < s->by_coat && l->apart)
        return lf_from_frame(l->coat_axis[0], l->coat_axis[1], l->coat_axis[2],
                             lf_ggx_sample(l->coat_alpha, to_coat(l, o), u[0], u[1]));
    if (by < s->by_coat)
        return lf_ggx_sample(l->coat_alpha, o, u[0], u[1]);
    if (by < s->by_coat + s->by_gloss)
        return lf_is_anisotropic(l->m) ? lf_anisotropic_sample(&l->m->anisotropic, o, u[0], u[1])
                                       : lf_ggx_sample(l->alpha, o, u[0], u[1]);
    return by < s->by_coat + s->by_gloss + s->by_sheen ? lf_hemisphere_sample(u[0], u[1])
                                                       : lf_cosine_sample(u[0], u[1]);
}

static float sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi,
                    lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (lf_is_way_out(m)) {
        *wi = lf_from_frame(t, b, ns, inwards(u));
        return leave(m, inwards(u), f);
    }
    if (!(o.z > LF_MIN_COS))
        return 0.0f;
    layers l = layers_of(m);
    shares s = shares_of(&l, is_special(m), o, lf_min(o.z, 1.0f));
    lf_vec3 i = draw(&l, &s, o, u);
    *wi = lf_from_frame(t, b, ns, i);
    float pdf = eval_local(&l, &s, o, i, f);
    return has_far_lobe(&l) ? add_far(&l, &s, o, i, pdf, f) : pdf;
}

/* ------------------------------------------------------------------------------------ deltas -- */

/* Reflection of a smooth dielectric, glass or not. */
static lf_vec3 mirrored_by_dielectric(const lf_material *m, bool front, float cos_o)
{
    float f = lf_lerp(lf_fresnel_dielectric(cos_o, m->ior), lf_glass_reflectance(m, !front, cos_o),
                      m->transmission);
    return lf_scale(m->specular_tint, (1.0f - m->metallic) * m->specular * f);
}

/* Transmission through glass, the light that its face does not reflect: along *out_wi. */
static lf_vec3 transmitted(const layers *l, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                           lf_vec3 *out_wi)
{
    const lf_material *m = l->m;
    float cos_o = lf_min(lf_dot(ns, wo), 1.0f),
          enters = l->rough ? coat_loss(m, cos_o)
                            : 1.0f - m->specular * lf_glass_reflectance(m, !front, cos_o);
    *out_wi = lf_scale(wo, -1.0f);
    if ((m->is_solid && !lf_refract(ns, wo, front ? m->ior : 1.0f / m->ior, out_wi)) ||
        !(lf_dot(*out_wi, ng) < 0.0f))
        return lf_v3(0.0f, 0.0f, 0.0f);
    return lf_scale(m->albedo, (1.0f - m->metallic) * m->transmission * enters);
}

static int deltas(const lf_material *m, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                  lf_delta out[LF_MAX_DELTAS])
{
    float cos_o = lf_min(lf_dot(ns, wo), 1.0f), coat = 0.0f;
    int n = 0;
    if (!m->has_delta || !(cos_o > LF_MIN_COS) || (!front && m->subsurface > 0.0f))
        return 0;
    front = m->glass.is_parting ? !m->glass.is_inside : front;
    layers l = layers_of(m);
    /* with a coat normal of its own, the base or the coat itself is not a mirror */
    lf_vec3 shiny = ns;
    float cos_coat = cos_o;
    if (l.apart) {
        lf_vec3 t, b, own;
        lf_tangents(ns, &t, &b);
        own = lf_from_frame(t, b, ns, m->coat_normal);
        shiny = l.rough_coat ? ns : own;
        cos_coat = lf_min(lf_dot(own, wo), 1.0f);
    }
    if (l.coated && cos_coat > LF_MIN_COS)
        coat = m->coat * (l.rough_coat ? 1.0f - clear_loss(m, cos_coat)
                                       : lf_fresnel_dielectric(cos_coat, LF_COAT_INDEX));
    float beneath = (1.0f - coat) * (l.sheened ? 1.0f - sheen_share(m, cos_o) : 1.0f);
    lf_vec3 mirrored = l.rough_coat ? lf_v3(0.0f, 0.0f, 0.0f) : lf_v3(coat, coat, coat);
    if (!l.rough)
        mirrored = lf_madd(mirrored, beneath,
                           lf_madd(mirrored_by_dielectric(m, front, cos_o), m->metallic,
                                   lf_conductor_fresnel(m, cos_o)));
    if (m->glass.is_thin && lf_max3(mirrored) > 0.0f)
        mirrored = lf_scale(mirrored, 1.0f / (1.0f - lf_thin_passes(m, cos_o)));
    if (lf_max3(mirrored) > 0.0f)
        out[n++] = (lf_delta){lf_mirror(ng, shiny, wo), mirrored};
    if (m->transmission > 0.0f && !m->glass.is_rough && !m->glass.is_thin) {
        out[n].f = lf_scale(transmitted(&l, ng, ns, wo, front, &out[n].wi), beneath);
        n += lf_max3(out[n].f) > 0.0f;
    }
    return n;
}

/* ---------------------------------------------------------------------------------- the kind -- */

static float metal_rest(float albedo, double loss)
{
    double f = (double)albedo + (1.0 - (double)albedo) / 21.0; /* Schlick's mean */
    return (float)(f * (1.0 - loss) / (1.0 - f * loss));
}

static bool has_texture(const lf_material *m, lf_slot slot)
{
    return m->textures && m->textures->pyramid[slot];
}

static void vary(lf_material *m)
{
    float metal_mean = 0.0f;
    if (lf_material_alpha(m) >= LF_ALPHA_MIN) {
        metal_mean = lf_loss_look_up(0.0f, m->roughness, m->energy.metal_loss);
        lf_loss_of_dielectric(m, (double)metal_mean);
    }
    if (m->coat > 0.0f &&
        (has_texture(m, LF_SLOT_COAT_ROUGH) || has_texture(m, LF_SLOT_COAT_NORMAL)))
        (void)lf_loss_look_up(LF_COAT_INDEX, m->coat_roughness, m->energy.coat_loss);
    m->rest = lf_v3(metal_rest(m->albedo.x, (double)metal_mean),
                    metal_rest(m->albedo.y, (double)metal_mean),
                    metal_rest(m->albedo.z, (double)metal_mean));
    m->energy.mean_fresnel = lf_mean3(m->albedo) * (20.0f / 21.0f) + 1.0f / 21.0f;
    if (has_texture(m, LF_SLOT_METAL_ROUGH) || has_texture(m, LF_SLOT_NORMAL) ||
        lf_is_anisotropic(m))
        lf_glass_vary(m);
}

static void prepare(lf_material *m)
{
    /* a texture turns a smooth lobe into a rough one */
    if (has_texture(m, LF_SLOT_METAL_ROUGH) || has_texture(m, LF_SLOT_NORMAL) ||
        has_texture(m, LF_SLOT_SPECULAR) || m->anisotropy > 0.0f)
        m->roughness = lf_max(m->roughness, LF_LEAST_ROUGHNESS);
    if (has_texture(m, LF_SLOT_COAT_ROUGH) || has_texture(m, LF_SLOT_COAT_NORMAL))
        m->coat_roughness = lf_max(m->coat_roughness, LF_LEAST_ROUGHNESS);
    bool rough = lf_material_alpha(m) >= LF_ALPHA_MIN,
         rough_coat = m->coat_roughness * m->coat_roughness >= LF_ALPHA_MIN;
    memset(m->energy.coat_loss, 0, sizeof m->energy.coat_loss);
    memset(m->energy.metal_loss, 0, sizeof m->energy.metal_loss);
    if (!rough)
        lf_loss_of_dielectric(m, 0.0);
    vary(m);
    if (m->coat > 0.0f && rough_coat)
        (void)lf_loss_look_up(LF_COAT_INDEX, m->coat_roughness, m->energy.coat_loss);
    float diffuse = (1.0f - m->metallic) * (1.0f - m->transmission);
    if (has_texture(m, LF_SLOT_METAL_ROUGH))
        diffuse = 1.0f - m->transmission;
    if (has_texture(m, LF_SLOT_TRANSMISSION))
        diffuse = 1.0f;
    float glass = (1.0f - m->metallic) * m->transmission;
    bool reflects = m->metallic > 0.0f || (m->specular > 0.0f && m->ior > 1.0f);
    m->has_lobe = (rough && reflects) || (m->coat > 0.0f && rough_coat) ||
                  (lf_max3(m->albedo) > 0.0f && diffuse > 0.0f) ||
                  (lf_glass_is_rough(m) && glass > 0.0f) || lf_max3(m->sheen) > 0.0f;
    m->has_delta = (!rough && reflects) || (m->coat > 0.0f && !rough_coat) ||
                   (!lf_glass_is_rough(m) && glass > 0.0f);
    lf_glass_prepare(m);
}

static const char *const glasses[] = {"solid", "sheet", NULL};
static const lf_param glass_key = {.name = "glass", .type = LF_PARAM_WORD, .words = glasses};

#define KEY(name, ...) &lf_principled_##name,
#define OWN(key) &key,
static const lf_param *const keys[] = {LF_PRINCIPLED_LAYERS(KEY, KEY, KEY) OWN(glass_key) NULL};

enum { GLASS = sizeof keys / sizeof *keys - 2 };
_Static_assert(GLASS < LF_MAX_KEYS, "values of all keys have room");

static const char *check(const lf_value values[], const lf_material *m, const lf_param **out_key)
{
    (void)values;
    *out_key = &lf_principled_subsurface;
    return m->subsurface > 0.0f && m->transmission > 0.0f
               ? "a surface can have transmission or subsurface, not both"
               : NULL;
}

static void read(const lf_value values[], lf_material *m)
{
    m->is_solid = values[GLASS].word == 0;
}

const lf_surface_kind lf_surface_principled = {
    .name = "principled",
    .keys = keys,
    .lacks = "principled surfaces do not use it",
    .check = check,
    .read = read,
    .prepare = prepare,
    .vary = vary,
    .eval = eval,
    .eval_fan = eval_fan,
    .sample = sample,
    .deltas = deltas,
    .view_dependent = true,
};
