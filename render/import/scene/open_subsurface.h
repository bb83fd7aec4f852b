/* Warns of meshes that flesh (transport/path/flesh.h) does not stay in; private to render/. */
#ifndef LF_RENDER_OPEN_SUBSURFACE_H
#define LF_RENDER_OPEN_SUBSURFACE_H

#include "render/import/scene/scene_parse.h"

/* Of meshes whose material has subsurface, those that are not closed (an edge that is not run along
 * as often one way as the other), and those that are inside out. Corners are the same where their
 * coordinates are. */
void lf_warn_of_open_subsurface(const lf_scene *scene, const lf_scene_desc *desc,
                                lf_warnings *warnings);

#endif
