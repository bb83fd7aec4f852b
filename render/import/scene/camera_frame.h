/* The scene's camera as one of a mesh's file; private to render/. */
#ifndef LF_RENDER_CAMERA_FRAME_H
#define LF_RENDER_CAMERA_FRAME_H

#include "render/import/scene/shutter.h"

/* Sets scene->camera, whose desc is that of the frame: what it says itself, else what the camera of
 * desc->framing has, else what is there initially; and what it gains while the shutter is open.
 * Of a file's camera that moves meanwhile the frame's own moment is taken between both ends.
 * scene->geometry, origin and bounds are there. Errors go through reader. */
void lf_camera_frame(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                     const lf_shutter *shutter, lf_scene *scene);
/* Of cameras that nobody looks through. */
void lf_camera_frame_warn(const lf_scene_desc *desc, lf_scene *scene);

#endif
