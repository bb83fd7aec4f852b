/* Anisotropic GGX with two alphas: a lobe that is wider along one direction than across it; private
 * to render/transport/surface_*.c. Directions are in the frame of lf_tangents of the shading
 * normal, as in surface_lobes.h and lf_anisotropy.along. */
#ifndef LF_RENDER_SURFACE_ANISOTROPY_H
#define LF_RENDER_SURFACE_ANISOTROPY_H

#include "render/transport/surface/surface_lobes.h"

static inline bool lf_is_anisotropic(const lf_material *m)
{
    return m->anisotropic.alpha[0] > 0.0f;
}

/* Into the frame whose x axis is the wider direction, and back. */
static inline lf_vec3 lf_to_anisotropy(const lf_anisotropy *anisotropic, lf_vec3 w)
{
    float c = anisotropic->along[0], s = anisotropic->along[1];
    return lf_v3(c * w.x + s * w.y, c * w.y - s * w.x, w.z);
}

static inline lf_vec3 lf_from_anisotropy(const lf_anisotropy *anisotropic, lf_vec3 w)
{
    float c = anisotropic->along[0], s = anisotropic->along[1];
    return lf_v3(c * w.x - s * w.y, s * w.x + c * w.y, w.z);
}

/* cos (1 + 2 Lambda) of Smith's function (Heitz 2014, eq. 86); w in the lobe's frame. */
static inline float lf_anisotropic_root(const float alpha[2], lf_vec3 w)
{
    float x = alpha[0] * w.x, y = alpha[1] * w.y;
    return sqrtf(x * x + y * y + w.z * w.z);
}

/* lf_ggx_eval with the density of normals of Heitz 2014, eq. 85. */
static inline lf_ggx_lobe lf_anisotropic_eval(const lf_anisotropy *anisotropic, lf_vec3 wo,
                                              lf_vec3 wi)
{
    const float *a = anisotropic->alpha;
    lf_vec3 o = lf_to_anisotropy(anisotropic, wo), i = lf_to_anisotropy(anisotropic, wi),
            h = lf_normalize(lf_add(o, i));
    float x = h.x / a[0], y = h.y / a[1], k = x * x + y * y + h.z * h.z,
          d = 0.5f * LF_INV_PI / (a[0] * a[1] * k * k), ro = lf_anisotropic_root(a, o),
          ri = lf_anisotropic_root(a, i), cos_i = lf_max(i.z, LF_MIN_COS);
    return (lf_ggx_lobe){.f = i.z > LF_MIN_COS ? d * cos_i / (cos_i * ro + o.z * ri) : 0.0f,
                         .pdf = h.z > 0.0f ? d / (o.z + ro) : 0.0f,
                         .cos_oh = lf_min(lf_dot(o, h), 1.0f)};
}

/* lf_ggx_sample for the anisotropic lobe. */
static inline lf_vec3 lf_anisotropic_sample(const lf_anisotropy *anisotropic, lf_vec3 wo, float u0,
                                            float u1)
{
    const float *a = anisotropic->alpha;
    lf_vec3 o = lf_to_anisotropy(anisotropic, wo),
            v = lf_normalize(lf_v3(a[0] * o.x, a[1] * o.y, o.z));
    float phi = 2.0f * LF_PI * u0, z = (1.0f - u1) * (1.0f + v.z) - v.z;
    float r = sqrtf(lf_max((1.0f - z) * (1.0f + z), 0.0f));
    lf_vec3 h = lf_normalize(
        lf_v3(a[0] * (r * cosf(phi) + v.x), a[1] * (r * sinf(phi) + v.y), lf_max(z + v.z, 1e-12f)));
    return lf_from_anisotropy(anisotropic,
                              lf_normalize(lf_sub(lf_scale(h, 2.0f * lf_dot(o, h)), o)));
}

#endif
