/* Whether a mesh has an inside; private to render/. */
#ifndef LF_RENDER_CLOSED_MESH_H
#define LF_RENDER_CLOSED_MESH_H

#include "render/scene/scene.h"

/* Whether every edge is run along as often one way as the other. Corners are the same where their
 * coordinates are. Wrong by one chance in 2^64. */
bool lf_mesh_is_closed(const lf_mesh *mesh);
/* The same of its triangles whose materials are marked. */
bool lf_mesh_part_is_closed(const lf_mesh *mesh, const bool *of_material);
/* Six times what these enclose: below 0 where they are inside out. */
double lf_mesh_part_volume(const lf_mesh *mesh, const bool *of_material);

#endif
