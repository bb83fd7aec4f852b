/* What the integrators of this folder do alike; private to render/papers/. */
#ifndef LF_RENDER_ALIKE_H
#define LF_RENDER_ALIKE_H

#include "render/plane/rig.h"
#include "render/transport/light/light.h"
#include "render/visit_lattice.h"

/* What a ray of a rig finds that meets nothing; my: the slope of its row's plane. */
static inline lf_vec3 lf_rig_sky(const lf_rig *rig, const lf_scene *seen, lf_vec3 w, float my)
{
    if (seen->backdrop.given)
        return lf_backdrop_at(&seen->backdrop, lf_rig_height_between(rig, my));
    return lf_light_seen(seen, w);
}

/* What no reference mode knows, in words behind "renders no"; NULL: nothing of it is there. */
static inline const char *lf_reference_unknown(const lf_scene *scene,
                                               const lf_render_settings *settings)
{
    if (scene->flames.n > 0)
        return "volumes that emit; the scene has some";
    if (scene->looks.chromatic)
        return "extinction that has a colour; the scene's has";
    if (scene->looks.moving || settings->camera.moves)
        return "motion; something moves while the shutter is open";
    if (settings->features)
        return "reconstructed pictures (--reconstruct off) or depth";
    return NULL;
}

#endif
