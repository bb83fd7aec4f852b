/* Warns of meshes that do not contain their subsurface medium (transport/path/subsurface.h);
 * private to render/. */
#ifndef LF_RENDER_OPEN_SUBSURFACE_H
#define LF_RENDER_OPEN_SUBSURFACE_H

#include "render/import/scene/scene_parse.h"

/* Warns of meshes with a subsurface material that are not closed (an edge is not traversed equally
 * often in both directions), or inside out. Vertices with equal coordinates are one. */
void lf_warn_of_open_subsurface(const lf_scene *scene, const lf_scene_desc *desc,
                                lf_warnings *warnings);

#endif
