/* The traits of a scene (traits.h), found once it is complete; private to render/. */
#ifndef LF_RENDER_SCENE_TRAITS_H
#define LF_RENDER_SCENE_TRAITS_H

#include "render/scene/scene.h"

/* Whether a volume is anywhere. */
static inline bool lf_volume_is_there(const lf_volume *volume)
{
    return volume->sigma_max > 0.0f;
}

/* Adds to scene->traits what its meshes, materials and volumes are; materials that nothing is made
 * of do not count. lf_lights_commit adds those of its lights, lf_nest_glass that of its glass. */
void lf_scene_find_traits(lf_scene *scene);

#endif
