/* The traits of a scene (traits.h), found once it is complete; private to render/. */
#ifndef LF_RENDER_SCENE_TRAITS_H
#define LF_RENDER_SCENE_TRAITS_H

#include "render/scene/scene.h"

/* Whether a volume is not empty. */
static inline bool lf_volume_is_there(const lf_volume *volume)
{
    return volume->sigma_max > 0.0f;
}

/* Adds the traits of its meshes, used materials and volumes to scene->traits. lf_lights_commit adds
 * the traits of its lights, lf_nest_glass the trait of nested glass. */
void lf_scene_find_traits(lf_scene *scene);

#endif
