/* From a parsed scene to a committed scene: loads its files, and shares with the previous scene;
 * private to render/. */
#ifndef LF_RENDER_SCENE_COMMIT_H
#define LF_RENDER_SCENE_COMMIT_H

#include "render/import/scene/shutter.h"

/* Fills the rest of scene, whose json and folder are set, from desc and its shutter. Errors go
 * through reader, at the node that failed. The scene is then half built and must be unreferenced.
 */
void lf_scene_commit(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                     const lf_shutter *shutter, const lf_roots *roots, const lf_scene *previous,
                     lf_scene *scene);

#endif
