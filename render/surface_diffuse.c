#include "render/surface_lobes.h"

float lf_diffuse_eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float cos_i = lf_dot(ns, wi);
    /* wo is on the side of the geometric normal; where the shading normal turns away from it f must still not depend on the view. */
    (void)wo;
    float pdf = cos_i > LF_MIN_COS ? cos_i * LF_INV_PI : 0.0f;
    *f = lf_scale(m->albedo, pdf);
    return pdf;
}

float lf_diffuse_sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    *wi = lf_from_frame(t, b, ns, lf_cosine_sample(u[0], u[1]));
    return lf_diffuse_eval(m, ns, wo, *wi, f);
}
