/* From what a scene file says to a committed scene: loads what it names, sharing with the scene
 * before; private to render/. */
#ifndef LF_RENDER_SCENE_COMMIT_H
#define LF_RENDER_SCENE_COMMIT_H

#include "render/import/scene/shutter.h"

/* Fills the rest of scene, whose json and folder are set, from desc and its shutter. Errors go
 * through reader, at the node of what failed; scene is then half built and to be unreferenced. */
void lf_scene_commit(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                     const lf_shutter *shutter, const lf_roots *roots, const lf_scene *previous,
                     lf_scene *scene);

#endif
