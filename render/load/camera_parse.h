/* What a scene file says of its camera; private to render/. */
#ifndef LF_RENDER_CAMERA_PARSE_H
#define LF_RENDER_CAMERA_PARSE_H

#include "render/load/scene_parse.h"

/* Reads the camera of the document into out->camera. Errors go through reader. */
void lf_camera_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out);

#endif
