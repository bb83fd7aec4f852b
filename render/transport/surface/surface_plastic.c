/* A diffuse base under a dielectric coat with GGX roughness. eta = ior. loss(cos) is the
 * transmittance of the coat (1 - F(cos) if it is smooth, 1 - E(cos) if it is rough:
 * surface_energy.c). Te is its mean over a hemisphere of uniform light, and Ti = Te / eta^2 the
 * same from inside. Light that has entered bounces between base and coat:
 *
 *   base = albedo / pi  loss(cos_o) loss(cos_i) / (eta^2 (1 - albedo (1 - Ti)))
 *        = albedo loss loss / (pi (eta^2 (1 - albedo) + albedo Te))  =  rest loss loss
 *
 * (the sum of the geometric series over inner reflections; Mitsuba's "plastic" with nonlinear =
 * true, after Wolff 1994). With albedo 1 the base reflects loss(cos_o), so that energy is
 * conserved. Light that a rough coat would reflect at a second microfacet goes to the base. */
#include "render/scene/vec_double.h"
#include "render/transport/surface/surface_lobes.h"

typedef struct plastic {
    float alpha, eta;
    float loss_o; /* what enters along wo */
    float select; /* probability of drawing wi by the coat's lobe */
    bool rough;
} plastic;

/* Probability of the coat's lobe: its share of what a base without inner reflections would give
 * back. */
static inline float select_of(float loss_o, float mean)
{
    float coat = 1.0f - loss_o, sum = coat + loss_o * mean;
    return sum > 0.0f ? coat / sum : 1.0f;
}

static plastic plastic_init(const lf_material *m, float cos_o)
{
    plastic p = {.alpha = lf_material_alpha(m),
                 .eta = m->ior,
                 .loss_o = lf_loss(m, lf_coat_transmittance(m->ior, cos_o), cos_o)};
    p.rough = p.alpha >= LF_ALPHA_MIN;
    p.select = p.rough ? select_of(p.loss_o, lf_mean3(m->albedo)) : 0.0f;
    return p;
}

/* The base towards wi, without loss(cos_o). */
static lf_vec3 base_colour(const lf_material *m, float cos_i)
{
    return lf_scale(m->rest, lf_loss(m, lf_coat_transmittance(m->ior, cos_i), cos_i) * cos_i);
}

/* wo.z > LF_MIN_COS. */
static float eval_local(const lf_material *m, const plastic *p, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    bool above = wi.z > LF_MIN_COS;
    float pdf = above ? (1.0f - p->select) * wi.z * LF_INV_PI : 0.0f;
    *f = above ? lf_scale(base_colour(m, wi.z), p->loss_o) : lf_v3(0.0f, 0.0f, 0.0f);
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
    plastic p = plastic_init(m, cos_o);
    lf_tangents(ns, &t, &b);
    return eval_local(m, &p, lf_to_frame(t, b, ns, wo), lf_to_frame(t, b, ns, wi), f);
}

/* The base's pdf. */
static float cosine_of(lf_vec3 wi)
{
    return wi.z > LF_MIN_COS ? wi.z * LF_INV_PI : 0.0f;
}

/* A rough coat over all directions of a fan; entering: transmittance of a smooth coat on input, of
 * this coat on output. */
static void fan_coat(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                     const float *z, float *restrict pdf, float *restrict entering,
                     float *restrict reflected)
{
    const lf_material own = *m;
    float cosine = cosine_of(wi), alpha = lf_material_alpha(m), mean = lf_mean3(m->albedo);
    for (int k = 0; k < n; k++) {
        float cos_o = lf_max(z[k], LF_MIN_COS), loss = lf_loss(&own, entering[k], cos_o),
              select = select_of(loss, mean);
        lf_ggx_lobe coat = lf_ggx_eval(alpha, lf_v3(x[k], y[k], cos_o), wi);
        bool above = z[k] > LF_MIN_COS;
        pdf[k] = above ? (1.0f - select) * cosine + select * coat.pdf : 0.0f;
        entering[k] = above ? loss : 0.0f;
        reflected[k] =
            above ? coat.f * lf_fresnel_dielectric(lf_max(coat.cos_oh, 0.0f), own.ior) : 0.0f;
    }
}

/* plastic_init and eval_local for all directions of a fan. */
static void eval_fan(const lf_material *m, lf_vec3 wi, int n, const float *x, const float *y,
                     const float *z, lf_fan_lobes *out)
{
    float *restrict pdf = out->pdf, *restrict entering = out->weight[0], ior = m->ior;
    float cosine = cosine_of(wi);
    bool rough = lf_material_alpha(m) >= LF_ALPHA_MIN;
    out->n_terms = rough ? 2 : 1;
    out->colour[0] = cosine > 0.0f ? base_colour(m, wi.z) : lf_v3(0.0f, 0.0f, 0.0f);
    out->colour[1] = lf_v3(1.0f, 1.0f, 1.0f);
    for (int k = 0; k < n; k++) {
        float above = z[k] > LF_MIN_COS ? 1.0f : 0.0f;
        entering[k] =
            above * (1.0f - lf_fresnel_dielectric(lf_min(lf_max(z[k], LF_MIN_COS), 1.0f), ior));
        pdf[k] = above * cosine;
    }
    if (rough)
        fan_coat(m, wi, n, x, y, z, pdf, entering, out->weight[1]);
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
    plastic p = plastic_init(m, o.z);
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
    .eval_fan = eval_fan,
    .sample = sample,
    .deltas = deltas,
    .view_dependent = true,
};
