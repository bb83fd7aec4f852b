/* The layered surface (principled_layers.h): sampling, delta lobes, preparation, keys. */
#include <string.h>

#include "render/scene/vec_double.h"
#include "render/transport/surface/principled_layers.h"

static float eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    float cos_o = lf_dot(ns, wo);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    lf_tangents(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo), i = lf_to_frame(t, b, ns, wi);
    if (lf_is_way_out(m))
        return lf_layers_leave(m, i, f);
    if (!(cos_o > LF_MIN_COS))
        return 0.0f;
    lf_layers l = lf_layers_of(m);
    lf_layer_shares s = lf_layers_shares(&l, lf_layers_are_special(m), o, lf_min(cos_o, 1.0f));
    float pdf = lf_layers_eval(&l, &s, o, i, f);
    return lf_layers_have_far(&l) ? lf_layers_add_far(&l, &s, o, i, pdf, f) : pdf;
}

/* Malley's cosine, on the other side. */
static lf_vec3 inwards(const float u[3])
{
    lf_vec3 w = lf_cosine_sample(u[0], u[1]);
    return lf_v3(w.x, w.y, -w.z);
}

static lf_vec3 draw(const lf_layers *l, const lf_layer_shares *s, lf_vec3 o, const float u[3])
{
    float by = u[2];
    if (lf_layers_have_far(l)) {
        if (by < s->by_far)
            return l->glass > 0.0f
                       ? lf_glass_sample(l->m, o, (const float[3]){u[0], u[1], by / s->by_far})
                       : inwards(u);
        by = (by - s->by_far) / (1.0f - s->by_far);
    }
    if (by < s->by_coat && l->apart)
        return lf_from_frame(l->coat_axis[0], l->coat_axis[1], l->coat_axis[2],
                             lf_ggx_sample(l->coat_alpha, lf_layers_to_coat(l, o), u[0], u[1]));
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
        return lf_layers_leave(m, inwards(u), f);
    }
    if (!(o.z > LF_MIN_COS))
        return 0.0f;
    lf_layers l = lf_layers_of(m);
    lf_layer_shares s = lf_layers_shares(&l, lf_layers_are_special(m), o, lf_min(o.z, 1.0f));
    lf_vec3 i = draw(&l, &s, o, u);
    *wi = lf_from_frame(t, b, ns, i);
    float pdf = lf_layers_eval(&l, &s, o, i, f);
    return lf_layers_have_far(&l) ? lf_layers_add_far(&l, &s, o, i, pdf, f) : pdf;
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
static lf_vec3 transmitted(const lf_layers *l, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                           lf_vec3 *out_wi)
{
    const lf_material *m = l->m;
    float cos_o = lf_min(lf_dot(ns, wo), 1.0f),
          enters = l->rough ? lf_dielectric_loss(m, cos_o)
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
    lf_layers l = lf_layers_of(m);
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
        coat = m->coat * (l.rough_coat ? 1.0f - lf_coat_loss(m, cos_coat)
                                       : lf_fresnel_dielectric(cos_coat, LF_COAT_INDEX));
    float beneath = (1.0f - coat) * (l.sheened ? 1.0f - lf_layers_sheen(m, cos_o) : 1.0f);
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
    .fan = LF_FAN_PRINCIPLED,
    .sample = sample,
    .deltas = deltas,
    .view_dependent = true,
};
