/* Code shared by the integrators of this folder; private to render/papers/. */
#ifndef LF_RENDER_ALIKE_H
#define LF_RENDER_ALIKE_H

#include "render/plane/rig.h"
#include "render/transport/light/light.h"
#include "render/visit_lattice.h"

/* Traits that all of them support; those with surfaces support more. */
#define LF_REFERENCE_SUPPORT                                                                       \
    (LF_TRAITS_PLAIN_MEDIA | LF_TRAITS_LIGHT | LF_TRAIT_LENS | LF_TRAIT_VIEW_BLUR)

/* The light of a rig's ray that meets nothing; my: the slope of its row's plane. */
static inline lf_vec3 lf_rig_sky(const lf_rig *rig, const lf_scene *seen, lf_vec3 w, float my)
{
    if (seen->backdrop.given)
        return lf_backdrop_at(&seen->backdrop, lf_rig_height_between(rig, my));
    return lf_light_seen(seen, w);
}

#endif
