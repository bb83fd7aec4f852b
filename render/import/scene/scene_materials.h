/* Materials of a scene: its files' materials, its own with their images, and overrides; private to
 * render/. */
#ifndef LF_RENDER_SCENE_MATERIALS_H
#define LF_RENDER_SCENE_MATERIALS_H

#include "base/file.h"
#include "render/import/scene/scene_parse.h"

/* Fills scene->materials; its geometry must be set. Loads the images of the scene's own materials
 * (scene_pictures.h). The files' materials come first, then the scene's, so that the numbers in the
 * shared geometry stay valid. See reader->status for errors. */
void lf_scene_materials(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                        const lf_roots *roots, const lf_scene *previous, lf_scene *scene);

/* Warns of materials of the scene that nothing uses. */
void lf_warn_of_unused_materials(const lf_node *root, const lf_scene_desc *desc, lf_scene *scene);

#endif
