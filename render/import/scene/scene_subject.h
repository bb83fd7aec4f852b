/* What a scene shows, to whoever compares films; private to render/. */
#ifndef LF_RENDER_SCENE_SUBJECT_H
#define LF_RENDER_SCENE_SUBJECT_H

#include "render/import/scene/shutter.h"

/* The scene's document, with the digests of files instead of their names (an array of everything
 * that was read for a mesh), and without what does not make the film (film) or is decided by the
 * settings of a renderer (camera, render). Volumes, geometry and lights are loaded and in desc's
 * order. A new reference; NULL = out of memory. */
json_t *lf_scene_subject(const lf_scene *scene, const lf_scene_desc *desc,
                         const lf_shutter *shutter);

#endif
