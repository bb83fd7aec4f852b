#include "render/surface_lobes.h"

const lf_surface_ops lf_surfaces[LF_MATERIAL_TYPES] = {
    [LF_MATERIAL_DIFFUSE] = {lf_diffuse_eval, NULL, lf_diffuse_sample, NULL, false},
    [LF_MATERIAL_CONDUCTOR] = {lf_conductor_eval, lf_conductor_eval_fan, lf_conductor_sample, lf_conductor_delta, true},
    [LF_MATERIAL_PLASTIC] = {lf_plastic_eval, lf_plastic_eval_fan, lf_plastic_sample, lf_plastic_delta, true},
};

bool lf_material_has_lobe(const lf_material *m)
{
    bool rough = lf_material_alpha(m) >= LF_ALPHA_MIN, coloured = lf_max3(m->albedo) > 0.0f;
    switch (m->type) {
    case LF_MATERIAL_CONDUCTOR:
        return rough;
    case LF_MATERIAL_PLASTIC:
        return coloured || (rough && m->ior > 1.0f);
    default:
        return coloured;
    }
}

bool lf_material_has_delta(const lf_material *m)
{
    bool smooth = lf_material_alpha(m) < LF_ALPHA_MIN;
    return smooth && (m->type == LF_MATERIAL_CONDUCTOR || (m->type == LF_MATERIAL_PLASTIC && m->ior > 1.0f));
}
