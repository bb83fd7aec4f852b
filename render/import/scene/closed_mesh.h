/* Whether a mesh has an inside; private to render/. */
#ifndef LF_RENDER_CLOSED_MESH_H
#define LF_RENDER_CLOSED_MESH_H

#include "render/scene/scene.h"

/* Whether every edge is traversed equally often in both directions. Vertices with equal coordinates
 * are one. Wrong with a probability of 2^-64. */
bool lf_mesh_is_closed(const lf_mesh *mesh);
/* lf_mesh_is_closed for the triangles with marked materials. */
bool lf_mesh_part_is_closed(const lf_mesh *mesh, const bool *of_material);
/* Six times the volume that these enclose; below 0 if they are inside out. */
double lf_mesh_part_volume(const lf_mesh *mesh, const bool *of_material);

#endif
