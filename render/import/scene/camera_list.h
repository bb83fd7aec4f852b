/* Lists, paths and circles of cameras: the "views" key of a scene's camera; private to render/. */
#ifndef LF_RENDER_CAMERA_LIST_H
#define LF_RENDER_CAMERA_LIST_H

#include "render/import/scene/scene_parse.h"

/* Each function reads one form of "views", node, into out->views, and their number into
 * out->camera. Default values come from out->camera, which must have been read. Errors go
 * through reader.
 *
 *   list    [{"position": …, "target": …, "up": …, "fov_y": …}, …]; all except position default to
 *           the camera's values
 *   path    {"count": 100, "through": [as a list], "closed": false}: along a smooth curve
 *           (Catmull-Rom) through the cameras, with equally many views between any two
 *   circle  {"count": 36, "angle": 360}: the camera rotated about the line through its target along
 *           up, to the right; less than a full circle extends equally to both sides */
typedef void (*lf_camera_list_fn)(lf_reader *reader, const lf_node *node, lf_scene_desc *out);
void lf_camera_list_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out);
void lf_camera_path_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out);
void lf_camera_circle_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out);

/* The error of a camera, NULL: none; *out_key: the key that causes it. */
const char *lf_camera_fault(const double position[3], const double target[3], const double up[3],
                            const char **out_key);

#endif
