/* Warns of a camera that a wall shuts off from all light; private to render/. */
#ifndef LF_RENDER_WALLED_CAMERA_H
#define LF_RENDER_WALLED_CAMERA_H

#include "render/import/scene/scene_parse.h"

/* Of a camera that stands inside a closed mesh through which no light goes, and in whose box no
 * light is: what it sees is black, be that mesh a solid or a room. Where one of these is not
 * certain (several places, meshes or cameras that move, more than 2^18 triangles) nothing is
 * said. */
void lf_warn_of_walled_camera(const lf_scene *scene, const lf_scene_desc *desc,
                              lf_warnings *warnings);

#endif
