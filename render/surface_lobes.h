/* What the surface types share; private to render/surface_*.c. Directions here are in the frame of the shading normal (z). */
#ifndef LF_RENDER_SURFACE_LOBES_H
#define LF_RENDER_SURFACE_LOBES_H

#include "render/surface.h"

/* The members of the table in surface.c; lf_surface_ops says what they do. */
float lf_diffuse_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
float lf_diffuse_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f);
float lf_conductor_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
void lf_conductor_eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z,
                           lf_fan_lobes *out);
float lf_conductor_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f);
lf_vec3 lf_conductor_delta(const lf_material *m, lf_vec3 ns, lf_vec3 wo);
float lf_plastic_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);
void lf_plastic_eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y, const float *z,
                         lf_fan_lobes *out);
float lf_plastic_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f);
lf_vec3 lf_plastic_delta(const lf_material *m, lf_vec3 ns, lf_vec3 wo);

/* Directions closer to the horizon than this count as below it: keeps quotients of cosines finite with denormals flushed. */
#define LF_MIN_COS 1e-7f

/* No direction of the fan reflects anything. */
static inline void lf_fan_clear(int n, lf_fan_lobes *out)
{
    out->colour = lf_v3(0.0f, 0.0f, 0.0f);
    for (int k = 0; k < n; k++)
        out->pdf[k] = out->coloured[k] = out->grey[k] = 0.0f;
}

static inline float lf_material_alpha(const lf_material *m)
{
    return m->roughness * m->roughness;
}

/* Malley: density cos / pi. */
static inline lf_vec3 lf_cosine_sample(float u0, float u1)
{
    float r = sqrtf(u0), phi = 2.0f * LF_PI * u1;
    return lf_v3(r * cosf(phi), r * sinf(phi), sqrtf(lf_max(1.0f - u0, 0.0f)));
}

/* Density of GGX normals (Walter et al. 2007, eq. 33) at the unit vector h, h.z > 0. The sine comes from x and y: 1 - z^2 has no
 * digits left where a small alpha has its peak. */
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

/* Reflection off GGX microfacets between wo and wi (z > LF_MIN_COS), without Fresnel. */
typedef struct lf_ggx_lobe {
    float f;      /* D G2 |cos_i| / (4 cos_o cos_i); G2 height-correlated (Heitz 2014, eq. 99) */
    float pdf;    /* of wi when h is drawn from the normals visible from wo (Heitz 2018, eq. 17) */
    float cos_oh; /* wo.h: what Fresnel wants */
} lf_ggx_lobe;

static inline lf_ggx_lobe lf_ggx_eval(float alpha, lf_vec3 wo, lf_vec3 wi)
{
    lf_vec3 h = lf_normalize(lf_add(wo, wi));
    float d = 0.5f * lf_ggx_d(alpha, h), ro = lf_ggx_root(alpha, wo.z), ri = lf_ggx_root(alpha, wi.z);
    return (lf_ggx_lobe){.f = d * wi.z / (wi.z * ro + wo.z * ri), .pdf = d / (wo.z + ro), .cos_oh = lf_min(lf_dot(wo, h), 1.0f)};
}

/* Draws a normal visible from wo (the distribution of Heitz 2018, JCGT 7(4)) by the spherical cap of Dupuy and Benyoub 2023 and
 * mirrors wo about it; the result may lie below the horizon. */
static inline lf_vec3 lf_ggx_sample(float alpha, lf_vec3 wo, float u0, float u1)
{
    lf_vec3 v = lf_normalize(lf_v3(alpha * wo.x, alpha * wo.y, wo.z));
    float phi = 2.0f * LF_PI * u0, z = (1.0f - u1) * (1.0f + v.z) - v.z;
    float r = sqrtf(lf_max((1.0f - z) * (1.0f + z), 0.0f));
    lf_vec3 h = lf_normalize(lf_v3(alpha * (r * cosf(phi) + v.x), alpha * (r * sinf(phi) + v.y), lf_max(z + v.z, 1e-12f)));
    return lf_normalize(lf_sub(lf_scale(h, 2.0f * lf_dot(wo, h)), wo));
}

/* Unpolarised reflectance of a dielectric interface with relative index eta >= 1 seen from the thinner side, cosine in [0, 1]. */
static inline float lf_fresnel_dielectric(float cos_i, float eta)
{
    float cos_t = sqrtf(1.0f - (1.0f - cos_i * cos_i) / (eta * eta));
    float s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t), p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 0.5f * (s * s + p * p);
}

#endif
