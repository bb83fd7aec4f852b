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
#ifndef LF_RENDER_PRINCIPLED_LAYERS_H
#define LF_RENDER_PRINCIPLED_LAYERS_H

#include "render/transport/surface/surface_anisotropy.h"
#include "render/transport/surface/surface_glass.h"
#include "render/transport/surface/surface_sheen.h"

/* Data of a material that all directions share. */
typedef struct lf_layers {
    const lf_material *m; /* loss: of the dielectric */
    float alpha, coat_alpha;
    /* shares: of the dielectric, by its own lobes and as rough glass; of metal; of the layer below;
     * and of light that enters subsurface */
    float dielectric, glass, metal, below, subsurface;
    bool rough, coated, rough_coat, sheened, apart;
    lf_vec3 coat_axis[3]; /* apart: of the coat's frame, in the base's */
} lf_layers;

/* The shares for one direction wo, and the probabilities of drawing from each lobe. */
typedef struct lf_layer_shares {
    float under;   /* the coat: what the rest gets */
    float beneath; /* the sheen, likewise */
    float enters;  /* loss(cos_o) */
    float several;
    float by_far;                      /* rough glass or subsurface; else … */
    float by_coat, by_gloss, by_sheen; /* … the rest is diffuse */
} lf_layer_shares;

static inline lf_layers lf_layers_of(const lf_material *m)
{
    lf_layers l = {.m = m, .alpha = lf_material_alpha(m)};
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

static inline bool lf_layers_have_far(const lf_layers *l)
{
    return l->glass > 0.0f || l->subsurface > 0.0f;
}

/* 1 - E of the dielectric's lobe. */
static inline float lf_dielectric_loss(const lf_material *m, float cosine)
{
    float smooth = m->energy.smooth_scale * lf_coat_transmittance(m->energy.smooth_ior, cosine);
    return 1.0f - m->specular * (1.0f - lf_loss(m, smooth, cosine));
}

/* 1 - E of the clear coat. */
static inline float lf_coat_loss(const lf_material *m, float cosine)
{
    float a = LF_LOSS_SCALE * m->coat_roughness * m->coat_roughness;
    return lf_loss_by(m->energy.coat_loss, a, lf_coat_transmittance(LF_COAT_INDEX, cosine), cosine);
}

/* Albedo of the fibres, in their strongest channel. */
static inline float lf_layers_sheen(const lf_material *m, float cosine)
{
    return lf_max3(m->sheen) * lf_sheen_albedo(m->sheen_roughness, cosine);
}

static inline float lf_layers_several(const lf_material *m, float cosine)
{
    float loss =
        lf_loss_by(m->energy.metal_loss, LF_LOSS_SCALE * lf_material_alpha(m), 0.0f, cosine);
    return loss / (1.0f - loss);
}

/* Whether a lobe is not about the base's normal, or not isotropic. */
static inline bool lf_layers_are_special(const lf_material *m)
{
    return lf_is_anisotropic(m) || m->coat_normal.z > 0.0f;
}

static inline lf_vec3 lf_layers_to_coat(const lf_layers *l, lf_vec3 w)
{
    return lf_to_frame(l->coat_axis[0], l->coat_axis[1], l->coat_axis[2], w);
}

/* The coat's share along wo, with cos_o to the base: 0 if it is seen from behind. */
static inline float lf_layers_coat(const lf_layers *l, bool special, lf_vec3 wo, float cos_o)
{
    float cosine = special && l->apart ? lf_min(lf_dot(l->coat_axis[2], wo), 1.0f) : cos_o;
    if (special && !(cosine > LF_MIN_COS))
        return 0.0f;
    return l->m->coat * (1.0f - lf_coat_loss(l->m, cosine));
}

static inline __attribute__((always_inline)) lf_layer_shares
lf_layers_shares(const lf_layers *l, bool special, lf_vec3 wo, float cos_o)
{
    const lf_material *m = l->m;
    lf_layer_shares s = {.under = 1.0f, .enters = lf_dielectric_loss(m, cos_o)};
    float coat = l->coated ? lf_layers_coat(l, special, wo, cos_o) : 0.0f,
          sheen = l->sheened ? lf_layers_sheen(m, cos_o) : 0.0f;
    s.under = 1.0f - coat;
    s.beneath = 1.0f - sheen;
    s.several = l->rough ? lf_layers_several(m, cos_o) : 0.0f;
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
    if (lf_layers_have_far(l)) {
        float far =
                  s.under * s.beneath * (l->glass + l->subsurface * s.enters * lf_mean3(m->albedo)),
              others = (l->rough_coat ? coat : 0.0f) + s.under * sum;
        s.by_far = others > 0.0f ? far / (far + others) : 1.0f;
    }
    return s;
}

/* The factor of the GGX lobe that metal and dielectric share: their Fresnel terms at cos_oh with
 * multiple-scattering compensation, without what the coat leaves (`under`). */
static inline lf_vec3 lf_layers_gloss_colour(const lf_layers *l, const lf_layer_shares *s,
                                             float cos_oh)
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
static inline lf_vec3 lf_layers_base_colour(const lf_layers *l, float cos_i)
{
    if (!(cos_i > LF_MIN_COS))
        return lf_v3(0.0f, 0.0f, 0.0f);
    return lf_scale(l->m->albedo, l->below * LF_INV_PI * cos_i * lf_dielectric_loss(l->m, cos_i) /
                                      l->m->energy.mean_loss);
}

/* A coat's lobe about its own normal. */
static inline lf_ggx_lobe lf_layers_coat_lobe(const lf_layers *l, lf_vec3 wo, lf_vec3 wi)
{
    if (!l->apart)
        return lf_ggx_eval(l->coat_alpha, wo, wi);
    lf_vec3 o = lf_layers_to_coat(l, wo);
    return o.z > LF_MIN_COS ? lf_ggx_eval(l->coat_alpha, o, lf_layers_to_coat(l, wi))
                            : (lf_ggx_lobe){.cos_oh = 1.0f};
}

static inline lf_ggx_lobe lf_layers_gloss_lobe(const lf_layers *l, lf_vec3 wo, lf_vec3 wi)
{
    return lf_is_anisotropic(l->m) ? lf_anisotropic_eval(&l->m->anisotropic, wo, wi)
                                   : lf_ggx_eval(l->alpha, wo, wi);
}

/* Towards wi from wo.z > LF_MIN_COS; base: base_colour of wi. Inline, so that common materials have
 * no branch for special ones. */
static inline __attribute__((always_inline)) float
lf_layers_eval_lobes(const lf_layers *l, const lf_layer_shares *s, bool special, lf_vec3 base,
                     lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float cosine = wi.z > LF_MIN_COS ? wi.z * LF_INV_PI : 0.0f,
          pdf = (1.0f - s->by_coat - s->by_sheen - s->by_gloss) * cosine;
    *f = lf_scale(base, s->enters);
    if (l->rough) {
        lf_ggx_lobe lobe =
            special ? lf_layers_gloss_lobe(l, wo, wi) : lf_ggx_eval(l->alpha, wo, wi);
        *f = lf_madd(*f, lobe.f, lf_layers_gloss_colour(l, s, lobe.cos_oh));
        pdf += s->by_gloss * lobe.pdf;
    }
    if (l->sheened) {
        *f = lf_madd(lf_scale(*f, s->beneath), lf_sheen_eval(l->m->sheen_roughness, wo, wi),
                     l->m->sheen);
        pdf += wi.z > LF_MIN_COS ? s->by_sheen * (0.5f * LF_INV_PI) : 0.0f;
    }
    *f = lf_scale(*f, s->under);
    if (l->rough_coat) {
        lf_ggx_lobe lobe =
            special ? lf_layers_coat_lobe(l, wo, wi) : lf_ggx_eval(l->coat_alpha, wo, wi);
        float k =
            l->m->coat * lobe.f * lf_fresnel_dielectric(lf_max(lobe.cos_oh, 0.0f), LF_COAT_INDEX);
        *f = lf_add(*f, lf_v3(k, k, k));
        pdf += s->by_coat * lobe.pdf;
    }
    return pdf;
}

static inline float lf_layers_eval(const lf_layers *l, const lf_layer_shares *s, lf_vec3 wo,
                                   lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 base = lf_layers_base_colour(l, wi.z);
    return lf_layers_are_special(l->m) ? lf_layers_eval_lobes(l, s, true, base, wo, wi, f)
                                       : lf_layers_eval_lobes(l, s, false, base, wo, wi, f);
}

/* Adds rough glass, or light that enters subsurface, to the other lobes; returns the pdf of all. */
static inline float lf_layers_add_far(const lf_layers *l, const lf_layer_shares *s, lf_vec3 wo,
                                      lf_vec3 wi, float pdf, lf_vec3 *f)
{
    float share = s->under * s->beneath, own = wi.z < -LF_MIN_COS ? -wi.z * LF_INV_PI : 0.0f;
    lf_vec3 through = lf_v3(own, own, own);
    if (l->glass > 0.0f)
        own = lf_glass_eval(l->m, wo, wi, &through);
    *f = lf_madd(*f, share * (l->glass > 0.0f ? l->glass : l->subsurface * s->enters), through);
    return lf_lerp(pdf, own, s->by_far);
}

/* Light that leaves subsurface, towards wi from any wo inside. */
static inline float lf_layers_leave(const lf_material *m, lf_vec3 wi, lf_vec3 *f)
{
    float pdf = wi.z < -LF_MIN_COS ? -wi.z * LF_INV_PI : 0.0f,
          out = pdf > 0.0f ? pdf * lf_dielectric_loss(m, lf_min(-wi.z, 1.0f)) / m->energy.mean_loss
                           : 0.0f;
    *f = lf_v3(out, out, out);
    return pdf;
}

#endif
