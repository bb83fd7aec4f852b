/* Parsing the camera of a scene file; private to render/. */
#ifndef LF_RENDER_CAMERA_PARSE_H
#define LF_RENDER_CAMERA_PARSE_H

#include "render/import/scene/scene_parse.h"

/* Reads the camera of the document into out->camera and out->framing. Errors go through reader. */
void lf_camera_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out);
/* Refuses invalid cameras, for example with the position at the target, once all values are known.
 * Sets the focus to the window, unless the document gives it. */
void lf_camera_check(lf_reader *reader, const lf_node *root, lf_camera *camera);

#endif
