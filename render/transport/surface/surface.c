#include <string.h>

#include "render/transport/surface/surface.h"
#include "render/transport/surface/surface_lobes.h"

#define LIST(name) &lf_surface_##name,
const lf_surface_kind *const lf_surface_kinds[] = {LF_SURFACE_KINDS(LIST) NULL};

void lf_material_make_pictured(lf_material *m)
{
    if (m->kind == &lf_surface_diffuse || m->kind == &lf_surface_principled)
        return;
    m->metallic = (float)(m->kind == &lf_surface_conductor);
    if (m->eta.x > 0.0f)
        m->albedo = lf_conductor_fresnel(m, 1.0f);
    m->eta = m->k = lf_v3(0.0f, 0.0f, 0.0f);
    m->kind = &lf_surface_principled;
}

void lf_material_prepare(lf_material *m)
{
    memset(m->loss, 0, sizeof m->loss);
    m->rest = lf_v3(0.0f, 0.0f, 0.0f);
    m->kind->prepare(m);
}
