/* Materials of a scene file, their images, and their assignment to meshes; private to render/. */
#ifndef LF_RENDER_MATERIAL_PARSE_H
#define LF_RENDER_MATERIAL_PARSE_H

#include "render/import/scene/scene_parse.h"

/* The keys of the two images of a slot: first colour or roughness, second coverage or metallic.
 * NULL: no second image. */
extern const char *const lf_picture_keys[LF_OWN_SLOTS][2];

bool lf_has_pictures(const lf_pictures_desc *pictures);

/* Reads one member of "materials" into desc->materials[index] and desc->pictures[index]. */
void lf_material_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *desc, int index);

/* Reads "material" and "materials" of a mesh, and the vertex data that they need; desc->materials
 * must be complete. */
void lf_mesh_materials_parse(lf_reader *reader, const lf_node *node, const lf_scene_desc *desc,
                             lf_mesh_desc *mesh);

/* The number of the scene's material that replaces the file's material of this name; below 0: none.
 */
int lf_mesh_override(const lf_mesh_desc *mesh, const char *name);

#endif
