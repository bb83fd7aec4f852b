/* The loops of surface_fan.h, to be compiled for an instruction set: no branches per direction, so
 * that compilers vectorise them. */
#include <string.h>

#include "render/transport/surface/plastic_lobes.h"
#include "render/transport/surface/principled_layers.h"
#include "render/transport/surface/surface_fan.h"

/* ------------------------------------------------------------------------------------- metal -- */

/* The lobes without Fresnel: of single scattering, and wo.h. */
static void metal_once(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
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

/* The multiple-scattering compensation. */
static void metal_more(const lf_material *m, int n, const float *z, float *restrict more)
{
    const lf_material own = *m;
    for (int i = 0; i < n; i++)
        more[i] = lf_conductor_several(&own, lf_max(z[i], LF_MIN_COS));
}

static void conductor(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                      const float *z, lf_fan_lobes *out)
{
    float *restrict once = out->f[0], *restrict cos_oh = out->f[1], *restrict more = out->f[2];
    const lf_material own = *m;
    if (lf_material_alpha(m) < LF_ALPHA_MIN) {
        memset(out->pdf, 0, (size_t)n * sizeof *out->pdf);
        for (int c = 0; c < 3; c++)
            memset(out->f[c], 0, (size_t)n * sizeof *out->f[c]);
        return;
    }
    metal_once(m, wi, n, x, y, z, out->pdf, once, cos_oh);
    metal_more(m, n, z, more);
    for (int i = 0; i < n; i++) {
        lf_vec3 f = lf_conductor_fresnel(&own, cos_oh[i]);
        float g = once[i], s = more[i];
        once[i] = g * f.x + s * (g * f.x * own.rest.x);
        cos_oh[i] = g * f.y + s * (g * f.y * own.rest.y);
        more[i] = g * f.z + s * (g * f.z * own.rest.z);
    }
}

/* ----------------------------------------------------------------------------------- plastic -- */

/* The base's pdf. */
static float plastic_cosine(lf_vec3 wi)
{
    return wi.z > LF_MIN_COS ? wi.z * LF_INV_PI : 0.0f;
}

/* A rough coat over all directions of a fan; entering: transmittance of a smooth coat on input, of
 * this coat on output. */
static void plastic_coat(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                         const float *z, float *restrict pdf, float *restrict entering,
                         float *restrict reflected)
{
    const lf_material own = *m;
    float cosine = plastic_cosine(wi), alpha = lf_material_alpha(m), mean = lf_mean3(m->albedo);
    for (int k = 0; k < n; k++) {
        float cos_o = lf_max(z[k], LF_MIN_COS), loss = lf_loss(&own, entering[k], cos_o),
              select = lf_plastic_select(loss, mean);
        lf_ggx_lobe coat = lf_ggx_eval(alpha, lf_v3(x[k], y[k], cos_o), wi);
        bool above = z[k] > LF_MIN_COS;
        pdf[k] = above ? (1.0f - select) * cosine + select * coat.pdf : 0.0f;
        entering[k] = above ? loss : 0.0f;
        reflected[k] =
            above ? coat.f * lf_fresnel_dielectric(lf_max(coat.cos_oh, 0.0f), own.ior) : 0.0f;
    }
}

/* lf_plastic_init and eval_local (surface_plastic.c) for all directions of a fan. */
static void plastic(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                    const float *z, lf_fan_lobes *out)
{
    float *restrict pdf = out->pdf, *restrict entering = out->f[0], *restrict reflected = out->f[1],
                    *restrict blue = out->f[2];
    const float ior = m->ior, cosine = plastic_cosine(wi);
    const bool rough = lf_material_alpha(m) >= LF_ALPHA_MIN;
    const lf_vec3 base = cosine > 0.0f ? lf_plastic_base(m, wi.z) : lf_v3(0.0f, 0.0f, 0.0f);
    for (int k = 0; k < n; k++) {
        float above = z[k] > LF_MIN_COS ? 1.0f : 0.0f;
        entering[k] =
            above * (1.0f - lf_fresnel_dielectric(lf_min(lf_max(z[k], LF_MIN_COS), 1.0f), ior));
        reflected[k] = 0.0f;
        pdf[k] = above * cosine;
    }
    if (rough)
        plastic_coat(m, wi, n, x, y, z, pdf, entering, reflected);
    for (int k = 0; k < n; k++) {
        const float enters = entering[k], coat = reflected[k];
        entering[k] = enters * base.x + coat;
        reflected[k] = enters * base.y + coat;
        blue[k] = enters * base.z + coat;
    }
}

/* ------------------------------------------------------------------------------------ layers -- */

static void add_far_fan(const lf_layers *l, lf_vec3 wi, int n, const float *const o[3],
                        lf_fan_lobes *out)
{
    for (int k = 0; k < n; k++) {
        lf_vec3 f = lf_v3(out->f[0][k], out->f[1][k], out->f[2][k]);
        if (!(o[2][k] > LF_MIN_COS) && !lf_is_way_out(l->m))
            continue;
        lf_vec3 wo = lf_v3(o[0][k], o[1][k], lf_min(o[2][k], 1.0f));
        lf_layer_shares s = lf_layers_shares(l, lf_layers_are_special(l->m), wo, wo.z);
        out->pdf[k] = lf_is_way_out(l->m) ? lf_layers_leave(l->m, wi, &f)
                                          : lf_layers_add_far(l, &s, wo, wi, out->pdf[k], &f);
        out->f[0][k] = f.x;
        out->f[1][k] = f.y;
        out->f[2][k] = f.z;
    }
}

/* lf_layers_eval for all directions of a fan. Inline, with layers whose flags the caller knows, so
 * that no branches remain and the compiler vectorises it. */
static inline __attribute__((always_inline)) void fan_of(lf_layers l, bool special, lf_vec3 wi,
                                                         int n, const float *x, const float *y,
                                                         const float *z, lf_fan_lobes *out)
{
    float *restrict pdf = out->pdf, *restrict red = out->f[0], *restrict green = out->f[1],
                    *restrict blue = out->f[2];
    const lf_vec3 base = lf_layers_base_colour(&l, wi.z);
#pragma GCC ivdep /* GCC forgets restrict when a function is inlined */
    for (int k = 0; k < n; k++) {
        float cos_o = lf_min(lf_max(z[k], LF_MIN_COS), 1.0f),
              above = z[k] > LF_MIN_COS ? 1.0f : 0.0f;
        lf_vec3 f;
        lf_layer_shares s = lf_layers_shares(&l, special, lf_v3(x[k], y[k], cos_o), cos_o);
        pdf[k] =
            above * lf_layers_eval_lobes(&l, &s, special, base, lf_v3(x[k], y[k], cos_o), wi, &f);
        red[k] = above * f.x;
        green[k] = above * f.y;
        blue[k] = above * f.z;
    }
}

/* fan_of for the most common surfaces: a rough base, a rough coat or none. */
static void fan_of_gloss(const lf_layers *of, lf_vec3 wi, int n, const float *x, const float *y,
                         const float *z, lf_fan_lobes *out)
{
    lf_layers l = *of;
    l.glass = l.subsurface = 0.0f; /* separate lobes, added later */
    l.rough = true;
    l.sheened = l.apart = l.coated = l.rough_coat = false;
    if (of->coated) {
        l.coated = l.rough_coat = true;
        fan_of(l, false, wi, n, x, y, z, out);
    } else
        fan_of(l, false, wi, n, x, y, z, out);
}

static void principled(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                       const float *z, lf_fan_lobes *out)
{
    const lf_layers l = lf_layers_of(m);
    if (lf_layers_are_special(m))
        fan_of(l, true, wi, n, x, y, z, out);
    else if (l.rough && l.coated == l.rough_coat && !l.sheened)
        fan_of_gloss(&l, wi, n, x, y, z, out);
    else
        fan_of(l, false, wi, n, x, y, z, out);
    if (lf_layers_have_far(&l) || lf_is_way_out(m))
        add_far_fan(&l, wi, n, (const float *[3]){x, y, z}, out);
}

#define LF_SURFACE_FANS                                                                            \
    {                                                                                              \
        .of = {                                                                                    \
            [LF_FAN_CONDUCTOR] = conductor,                                                        \
            [LF_FAN_PLASTIC] = plastic,                                                            \
            [LF_FAN_PRINCIPLED] = principled                                                       \
        }                                                                                          \
    }
