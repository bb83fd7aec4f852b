/* Code shared by surface kinds; private to render/transport/surface/ and catcher.c. Directions
 * here are in the frame of the shading normal (z). */
#ifndef LF_RENDER_SURFACE_LOBES_H
#define LF_RENDER_SURFACE_LOBES_H

#include "render/transport/surface/surface.h"

static inline float lf_material_alpha(const lf_material *m)
{
    return m->roughness * m->roughness;
}

/* The mirror direction of wo about the shading normal; if it leads through the surface, it is also
 * mirrored at the surface. */
static inline lf_vec3 lf_mirror(lf_vec3 ng, lf_vec3 ns, lf_vec3 wo)
{
    lf_vec3 wi = lf_reflect(wo, ns);
    float cosine = lf_dot(wi, ng);
    return cosine > 0.0f ? wi : lf_madd(wi, -2.0f * cosine, ng);
}

/* Malley: density cos / pi. */
static inline lf_vec3 lf_cosine_sample(float u0, float u1)
{
    float r = sqrtf(u0), phi = 2.0f * LF_PI * u1;
    return lf_v3(r * cosf(phi), r * sinf(phi), sqrtf(lf_max(1.0f - u0, 0.0f)));
}

/* Uniform over the hemisphere: density 1 / 2 pi. */
static inline lf_vec3 lf_hemisphere_sample(float u0, float u1)
{
    float r = sqrtf(lf_max((1.0f - u0) * (1.0f + u0), 0.0f)), phi = 2.0f * LF_PI * u1;
    return lf_v3(r * cosf(phi), r * sinf(phi), u0);
}

/* Density of GGX normals (Walter et al. 2007, eq. 33) at the unit vector h, h.z > 0. The sine comes
 * from x and y: 1 - z^2 loses all digits at the peak for a small alpha. */
static inline float lf_ggx_d(float alpha, lf_vec3 h)
{
    float a2 = alpha * alpha, k = h.z * h.z * a2 + h.x * h.x + h.y * h.y;
    return a2 * LF_INV_PI / (k * k);
}

/* sqrt(alpha^2 sin^2 + cos^2) = cos (1 + 2 Lambda), Smith's function of GGX. */
static inline float lf_ggx_root(float alpha, float cos_theta)
{
    float c2 = cos_theta * cos_theta;
    return sqrtf(alpha * alpha * (1.0f - c2) + c2);
}

/* Reflection off GGX microfacets from wo (z > LF_MIN_COS) to wi, without Fresnel. */
typedef struct lf_ggx_lobe {
    /* D G2 |cos_i| / (4 cos_o cos_i), 0 for wi below the horizon; G2 height-correlated (Heitz 2014,
     * eq. 99) */
    float f;
    /* of wi if h is drawn from the normals visible from wo (Heitz 2018, eq. 17); integrates to 1
     * over the whole sphere */
    float pdf;
    float cos_oh; /* wo.h: the cosine for Fresnel */
} lf_ggx_lobe;

static inline lf_ggx_lobe lf_ggx_eval(float alpha, lf_vec3 wo, lf_vec3 wi)
{
    lf_vec3 h = lf_normalize(lf_add(wo, wi));
    float d = 0.5f * lf_ggx_d(alpha, h), ro = lf_ggx_root(alpha, wo.z),
          ri = lf_ggx_root(alpha, wi.z), i = lf_max(wi.z, LF_MIN_COS);
    return (lf_ggx_lobe){.f = wi.z > LF_MIN_COS ? d * i / (i * ro + wo.z * ri) : 0.0f,
                         .pdf = h.z > 0.0f ? d / (wo.z + ro) : 0.0f,
                         .cos_oh = lf_min(lf_dot(wo, h), 1.0f)};
}

/* Draws a normal visible from wo (the distribution of Heitz 2018, JCGT 7(4)) by the spherical cap
 * of Dupuy and Benyoub 2023. */
static inline lf_vec3 lf_ggx_normal(float alpha, lf_vec3 wo, float u0, float u1)
{
    lf_vec3 v = lf_normalize(lf_v3(alpha * wo.x, alpha * wo.y, wo.z));
    float phi = 2.0f * LF_PI * u0, z = (1.0f - u1) * (1.0f + v.z) - v.z;
    float r = sqrtf(lf_max((1.0f - z) * (1.0f + z), 0.0f));
    return lf_normalize(lf_v3(alpha * (r * cosf(phi) + v.x), alpha * (r * sinf(phi) + v.y),
                              lf_max(z + v.z, 1e-12f)));
}

/* Mirrors wo at a sampled normal; the result may lie below the horizon. */
static inline lf_vec3 lf_ggx_sample(float alpha, lf_vec3 wo, float u0, float u1)
{
    lf_vec3 h = lf_ggx_normal(alpha, wo, u0, u1);
    return lf_normalize(lf_sub(lf_scale(h, 2.0f * lf_dot(wo, h)), wo));
}

/* Unpolarised reflectance of a dielectric interface with relative index eta >= 1 seen from the
 * thinner side, cosine in [0, 1]. */
static inline float lf_fresnel_dielectric(float cos_i, float eta)
{
    float cos_t = sqrtf(1.0f - (1.0f - cos_i * cos_i) / (eta * eta));
    float s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t),
          p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 0.5f * (s * s + p * p);
}

/* Reflectance of a metal of complex index eta + i k, cosine in (0, 1] (Born and Wolf, Principles of
 * Optics, section 14.2). */
static inline float lf_fresnel_index(float cos_i, float eta, float k)
{
    float c2 = cos_i * cos_i, s2 = 1.0f - c2, d = eta * eta - k * k - s2,
          ab = sqrtf(d * d + 4.0f * eta * eta * k * k);
    float a = sqrtf(lf_max(0.5f * (ab + d), 0.0f)) * 2.0f * cos_i;
    float s = (ab + c2 - a) / (ab + c2 + a), t = c2 * ab + s2 * s2, u = a * s2;
    return 0.5f * s * (1.0f + (t - u) / (t + u));
}

/* Index of a clear coat on a principled surface. */
#define LF_COAT_INDEX 1.5f

/* (1 - cos)^5 of Schlick 1994. */
static inline float lf_schlick(float cos_theta)
{
    float c = 1.0f - cos_theta, c2 = c * c;
    return c2 * c2 * c;
}

/* Reflectance of a conductor, from its index or from its colour at normal incidence. */
static inline lf_vec3 lf_conductor_fresnel(const lf_material *m, float cos_theta)
{
    if (m->eta.x > 0.0f)
        return lf_v3(lf_fresnel_index(cos_theta, m->eta.x, m->k.x),
                     lf_fresnel_index(cos_theta, m->eta.y, m->k.y),
                     lf_fresnel_index(cos_theta, m->eta.z, m->k.z));
    float k = lf_schlick(cos_theta);
    return lf_v3(lf_lerp(m->albedo.x, 1.0f, k), lf_lerp(m->albedo.y, 1.0f, k),
                 lf_lerp(m->albedo.z, 1.0f, k));
}

/* Transmittance of a smooth coat of index ior. */
static inline float lf_coat_transmittance(float ior, float cos_theta)
{
    return 1.0f - lf_fresnel_dielectric(lf_min(cos_theta, 1.0f), ior);
}

/* 1 - E(cos), E the directional albedo of the material's rough lobe, with Fresnel (metals:
 * without). It is the sum of `smooth`, which is lf_coat_transmittance (metals: 0), and a / (cos +
 * a) times a polynomial in x = 2 sqrt((1 + a) cos / (cos + a)) - 1, a = LF_LOSS_SCALE alpha. This
 * form resolves cosines of the order of alpha. Within 3e-3 of quadrature for alpha in [1e-3, 1] and
 * all cosines. */
#define LF_LOSS_SCALE 2.0f
static inline float lf_loss_by(const float *c, float a, float smooth, float cos_theta)
{
    float inverse = 1.0f / (cos_theta + a);
    float x = 2.0f * sqrtf((1.0f + a) * cos_theta * inverse) - 1.0f;
    /* Written out, because with a loop GCC does not vectorise the caller's loop. */
    float p = (((c[8] * x + c[7]) * x + c[6]) * x + c[5]) * x + c[4];
    p = (((p * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0];
    return lf_min(lf_max(smooth + a * inverse * p, 0.0f), 1.0f);
}

static inline float lf_loss(const lf_material *m, float smooth, float cos_theta)
{
    return lf_loss_by(m->loss, LF_LOSS_SCALE * lf_material_alpha(m), smooth, cos_theta);
}

/* 1 / E(cos_o) - 1: multiply scattered over singly scattered light, without absorption. */
static inline float lf_conductor_several(const lf_material *m, float cos_o)
{
    float loss = lf_loss(m, 0.0f, cos_o);
    return loss / (1.0f - loss);
}

/* Cosine and weight of the i-th of LF_MEAN_STEPS points of 2 int_0^1 g(c) c dc. */
enum { LF_MEAN_STEPS = 128 };
static inline double lf_mean_cosine(int i, double *out_weight)
{
    double root = (i + 0.5) / LF_MEAN_STEPS, cosine = root * root;
    *out_weight = 4.0 * cosine * root / LF_MEAN_STEPS;
    return cosine;
}

/* Fits loss to a rough lobe; ior of the coat, 0: a metal. */
void lf_loss_fit(lf_material *m, float ior);
/* 2 int_0^1 loss(c) c dc. */
double lf_loss_mean(const lf_material *m, float ior);

/* lf_loss_fit from a table over index and roughness, for surfaces with textured roughness. out, of
 * LF_LOSS_TERMS, may be NULL; returns the mean. roughness 0: a smooth coat, and out is all 0.
 * Within 1e-3 of lf_loss_fit up to an index of 3. Above, lf_loss_fit counts light that one
 * microfacet reflects to another as lost. The table counts lf_loss_rest of it as finally reflected,
 * within 5e-3 (1e-2 from an index of 100 on). Parts of the table are made at first use (20 ms).
 * Thread: any. */
float lf_loss_look_up(float ior, float roughness, float *out);
/* The `smooth` of lf_loss for this table: *out_scale times lf_coat_transmittance of the returned
 * index. Up to an index of 3 the result is the index itself, times 1. Above, rough surfaces blur
 * the narrow range of cosines (about 1 / index) at which light enters, which polynomials cannot
 * follow. */
float lf_loss_smooth(float ior, float alpha, float *out_scale);
/* Multiple-scattering compensation of a layered surface's dielectric: the lobe is multiplied by
 * 1 + result * loss / (1 - loss), with the loss of a metal of its roughness. metal_loss: the mean
 * of that loss. 0 up to an index of 3. */
float lf_loss_rest(float ior, double metal_loss);
/* All energy terms of a layered surface's dielectric with m->ior and m->roughness:
 * energy.mean_loss, rest and the smooth terms and, if it is rough, m->loss. metal_loss: the mean
 * for a metal of its roughness. */
void lf_loss_of_dielectric(lf_material *m, double metal_loss);

#endif
