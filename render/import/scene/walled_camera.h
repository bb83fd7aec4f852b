/* Warns of a camera that a wall encloses without any light; private to render/. */
#ifndef LF_RENDER_WALLED_CAMERA_H
#define LF_RENDER_WALLED_CAMERA_H

#include "render/import/scene/scene_parse.h"

/* Warns of a camera inside a closed opaque mesh whose box contains no light: its image is black,
 * whether the mesh is a solid or a room. No warning in uncertain cases (instances, moving meshes or
 * cameras, more than 2^18 triangles). */
void lf_warn_of_walled_camera(const lf_scene *scene, const lf_scene_desc *desc,
                              lf_warnings *warnings);

#endif
