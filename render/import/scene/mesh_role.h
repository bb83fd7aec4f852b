/* What a mesh is to the camera: a thing, a catcher, a ground; private to render/. */
#ifndef LF_RENDER_MESH_ROLE_H
#define LF_RENDER_MESH_ROLE_H

#include "render/import/scene/scene_parse.h"

/* Reads "catcher" and "ground" of a mesh, whose shape or file is read. Errors go through reader. */
void lf_mesh_role_parse(lf_reader *reader, const lf_node *node, lf_mesh_desc *mesh);

#endif
