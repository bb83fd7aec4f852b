/* What a scene file says of its camera; private to render/. */
#ifndef LF_RENDER_CAMERA_PARSE_H
#define LF_RENDER_CAMERA_PARSE_H

#include "render/import/scene/scene_parse.h"

/* Reads the camera of the document into out->camera and out->framing. Errors go through reader. */
void lf_camera_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out);
/* Refuses one that stands on its target, and such, once all of it is known; its focus lies in the
 * window unless the document says otherwise. */
void lf_camera_check(lf_reader *reader, const lf_node *root, lf_camera *camera);

#endif
