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
#ifndef LF_RENDER_PLASTIC_LOBES_H
#define LF_RENDER_PLASTIC_LOBES_H

#include "render/transport/surface/surface_lobes.h"

typedef struct lf_plastic {
    float alpha, eta;
    float loss_o; /* what enters along wo */
    float select; /* probability of drawing wi by the coat's lobe */
    bool rough;
} lf_plastic;

/* Probability of the coat's lobe: its share of what a base without inner reflections would give
 * back. */
static inline float lf_plastic_select(float loss_o, float mean)
{
    float coat = 1.0f - loss_o, sum = coat + loss_o * mean;
    return sum > 0.0f ? coat / sum : 1.0f;
}

static inline lf_plastic lf_plastic_init(const lf_material *m, float cos_o)
{
    lf_plastic p = {.alpha = lf_material_alpha(m),
                    .eta = m->ior,
                    .loss_o = lf_loss(m, lf_coat_transmittance(m->ior, cos_o), cos_o)};
    p.rough = p.alpha >= LF_ALPHA_MIN;
    p.select = p.rough ? lf_plastic_select(p.loss_o, lf_mean3(m->albedo)) : 0.0f;
    return p;
}

/* The base towards wi, without loss(cos_o). */
static inline lf_vec3 lf_plastic_base(const lf_material *m, float cos_i)
{
    return lf_scale(m->rest, lf_loss(m, lf_coat_transmittance(m->ior, cos_i), cos_i) * cos_i);
}

#endif
