#include "render/scene/vec_double.h"
#include "render/transport/surface/surface_lobes.h"

static float eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    float cos_i = lf_dot(ns, wi);
    /* wo is on the side of the geometric normal. If the shading normal faces away from it, f must
     * still not depend on the view. */
    (void)wo;
    float pdf = cos_i > LF_MIN_COS ? cos_i * LF_INV_PI : 0.0f;
    *f = lf_scale(m->albedo, pdf);
    return pdf;
}

static float sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi,
                    lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    *wi = lf_from_frame(t, b, ns, lf_cosine_sample(u[0], u[1]));
    return eval(m, ns, wo, *wi, f);
}

static void prepare(lf_material *m)
{
    m->has_lobe = lf_max3(m->albedo) > 0.0f;
    m->has_delta = false;
}

static void vary(lf_material *m)
{
    (void)m; /* all that counts is its albedo */
}

static const lf_param *const keys[] = {&lf_principled_albedo, NULL};

const lf_surface_kind lf_surface_diffuse = {
    .name = "diffuse",
    .keys = keys,
    .lacks = "diffuse surfaces do not use it",
    .prepare = prepare,
    .vary = vary,
    .eval = eval,
    .sample = sample,
};
