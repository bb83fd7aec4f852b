/* Materials of a scene: its files' own, its own with their pictures, and which stand in for which;
 * private to render/. */
#ifndef LF_RENDER_SCENE_MATERIALS_H
#define LF_RENDER_SCENE_MATERIALS_H

#include "base/file.h"
#include "render/import/scene/scene_parse.h"

/* Fills scene->materials, whose geometry is there, and has the pictures of the scene's own read
 * (scene_pictures.h). They are the files' own, then the scene's: what the shared geometry numbers
 * stays, whatever the scene adds. reader->status says how it went. */
void lf_scene_materials(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                        const lf_roots *roots, const lf_scene *previous, lf_scene *scene);

/* Tells which of the scene's materials nothing has. */
void lf_warn_of_unused_materials(const lf_node *root, const lf_scene_desc *desc, lf_scene *scene);

#endif
