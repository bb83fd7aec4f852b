/* The part of a scene that defines its films, for comparisons; private to render/. */
#ifndef LF_RENDER_SCENE_SUBJECT_H
#define LF_RENDER_SCENE_SUBJECT_H

#include "render/import/scene/shutter.h"

/* The scene's document, with digests of files instead of their names (for a mesh an array of all
 * files read). It excludes keys that do not affect the film (film) or that the renderer's settings
 * decide (camera, render). Volumes, geometry and lights must be loaded, in desc's order. A new
 * reference; NULL = out of memory. */
json_t *lf_scene_subject(const lf_scene *scene, const lf_scene_desc *desc,
                         const lf_shutter *shutter);

#endif
