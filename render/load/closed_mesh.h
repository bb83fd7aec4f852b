/* Whether a mesh has an inside; private to render/. */
#ifndef LF_RENDER_CLOSED_MESH_H
#define LF_RENDER_CLOSED_MESH_H

#include "render/scene/scene.h"

/* Whether every edge is run along as often one way as the other. Corners are the same where their
 * coordinates are. Wrong by one chance in 2^64. */
bool lf_mesh_is_closed(const lf_mesh *mesh);

#endif
