/* The role of a mesh for the camera: object, catcher or ground; private to render/. */
#ifndef LF_RENDER_MESH_ROLE_H
#define LF_RENDER_MESH_ROLE_H

#include "render/import/scene/scene_parse.h"

/* Reads "catcher" and "ground" of a mesh, after its shape or file. Errors go through reader. */
void lf_mesh_role_parse(lf_reader *reader, const lf_node *node, lf_mesh_desc *mesh);

#endif
