/* The coated diffuse surface (plastic_lobes.h): evaluation, sampling, preparation, keys. */
#include "render/scene/vec_double.h"
#include "render/transport/surface/plastic_lobes.h"

/* wo.z > LF_MIN_COS. */
static float eval_local(const lf_material *m, const lf_plastic *p, lf_vec3 wo, lf_vec3 wi,
                        lf_vec3 *f)
{
    bool above = wi.z > LF_MIN_COS;
    float pdf = above ? (1.0f - p->select) * wi.z * LF_INV_PI : 0.0f;
    *f = above ? lf_scale(lf_plastic_base(m, wi.z), p->loss_o) : lf_v3(0.0f, 0.0f, 0.0f);
    if (p->rough) {
        lf_ggx_lobe coat = lf_ggx_eval(p->alpha, wo, wi);
        float k = coat.f * lf_fresnel_dielectric(lf_max(coat.cos_oh, 0.0f), p->eta);
        *f = lf_add(*f, lf_v3(k, k, k));
        pdf += p->select * coat.pdf;
    }
    return pdf;
}

static float eval(const lf_material *m, lf_vec3 ns, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    lf_vec3 t, b;
    float cos_o = lf_dot(ns, wo);
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (!(cos_o > LF_MIN_COS))
        return 0.0f;
    lf_plastic p = lf_plastic_init(m, cos_o);
    lf_tangents(ns, &t, &b);
    return eval_local(m, &p, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

static float sample(const lf_material *m, lf_vec3 ns, lf_vec3 wo, const float u[3], lf_vec3 *wi,
                    lf_vec3 *f)
{
    lf_vec3 t, b;
    lf_tangents(ns, &t, &b);
    lf_vec3 o = lf_to_frame(t, b, ns, wo), i;
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    if (!(o.z > LF_MIN_COS))
        return 0.0f;
    lf_plastic p = lf_plastic_init(m, o.z);
    if (u[2] < p.select)
        i = lf_ggx_sample(p.alpha, o, u[0], u[1]);
    else
        i = lf_cosine_sample(u[0], u[1]);
    *wi = lf_from_frame(t, b, ns, i);
    return eval_local(m, &p, o, i, f);
}

static int deltas(const lf_material *m, lf_vec3 ng, lf_vec3 ns, lf_vec3 wo, bool front,
                  lf_delta out[LF_MAX_DELTAS])
{
    (void)front;
    float cos_o = lf_dot(ns, wo);
    if (!m->has_delta || !(cos_o > LF_MIN_COS))
        return 0;
    float f = lf_fresnel_dielectric(lf_min(cos_o, 1.0f), m->ior);
    out[0] = (lf_delta){lf_mirror(ng, ns, wo), lf_v3(f, f, f)};
    return f > 0.0f;
}

/* The series over reflections between base and coat, without loss(cos_o) loss(cos_i). */
static float rest_of(double albedo, double eta, double loss)
{
    return (float)(albedo / ((double)LF_PI * (eta * eta * (1.0 - albedo) + albedo * loss)));
}

static void prepare(lf_material *m)
{
    bool rough = lf_material_alpha(m) >= LF_ALPHA_MIN;
    double eta = (double)m->ior;
    m->has_lobe = lf_max3(m->albedo) > 0.0f || (rough && m->ior > 1.0f);
    m->has_delta = !rough && m->ior > 1.0f;
    if (rough)
        lf_loss_fit(m, m->ior);
    double loss = lf_loss_mean(m, m->ior);
    m->rest =
        lf_v3(rest_of((double)m->albedo.x, eta, loss), rest_of((double)m->albedo.y, eta, loss),
              rest_of((double)m->albedo.z, eta, loss));
}

static const lf_param *const keys[] = {&lf_principled_albedo, &lf_principled_roughness,
                                       &lf_principled_ior, NULL};

const lf_surface_kind lf_surface_plastic = {
    .name = "plastic",
    .keys = keys,
    .lacks = "plastic surfaces do not use it",
    .prepare = prepare,
    .eval = eval,
    .fan = LF_FAN_PLASTIC,
    .sample = sample,
    .deltas = deltas,
    .view_dependent = true,
};
