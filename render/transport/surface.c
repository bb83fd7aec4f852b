#include <string.h>

#include "render/transport/surface.h"

#define LIST(name) &lf_surface_##name,
const lf_surface_kind *const lf_surface_kinds[] = {LF_SURFACE_KINDS(LIST) NULL};

void lf_material_prepare(lf_material *m)
{
    memset(m->loss, 0, sizeof m->loss);
    m->rest = lf_v3(0.0f, 0.0f, 0.0f);
    m->kind->prepare(m);
}
