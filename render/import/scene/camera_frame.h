/* The scene's camera taken from a mesh's file; private to render/. */
#ifndef LF_RENDER_CAMERA_FRAME_H
#define LF_RENDER_CAMERA_FRAME_H

#include "render/import/scene/shutter.h"

/* Sets scene->camera for the frame of desc. A value comes from the scene, else from the file's
 * camera in desc->framing, else from the defaults. Also sets the shifts of the shutter. If the
 * file's camera moves while the shutter is open, the frame's own time is interpolated between both
 * ends. scene->geometry, origin and bounds must be set. Errors go through reader. */
void lf_camera_frame(lf_reader *reader, const lf_node *root, const lf_scene_desc *desc,
                     const lf_shutter *shutter, lf_scene *scene);
/* Warns of file cameras that are not used. */
void lf_camera_frame_warn(const lf_scene_desc *desc, lf_scene *scene);

#endif
