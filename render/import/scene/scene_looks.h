/* What a scene has that most lack, found once it is complete; private to render/. */
#ifndef LF_RENDER_SCENE_LOOKS_H
#define LF_RENDER_SCENE_LOOKS_H

#include "render/scene/scene.h"

/* Whether a volume is anywhere. */
static inline bool lf_volume_is_there(const lf_volume *volume)
{
    return volume->sigma_max > 0.0f;
}

/* Sets looks, has_delta, has_emission and has_view_lobes by what the meshes, lights and volumes of
 * a scene are. Materials that nothing is made of do not count. */
void lf_scene_look(lf_scene *scene);

#endif
