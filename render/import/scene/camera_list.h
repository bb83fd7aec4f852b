/* Cameras that stand where they like: what "views" of a scene's camera says of them; private to
 * render/. */
#ifndef LF_RENDER_CAMERA_LIST_H
#define LF_RENDER_CAMERA_LIST_H

#include "render/import/scene/scene_parse.h"

/* Each reads one form of views, node, into out->views, and out->camera says how many. They look at
 * what out->camera says otherwise, which must have been read. Errors go through reader.
 *
 *   list    [{"position": …, "target": …, "up": …, "fov_y": …}, …]; what one does not say, but for
 *           its position, is the camera's own
 *   path    {"count": 100, "through": [as a list], "closed": false}: from camera to camera along a
 *           smooth curve (Catmull and Rom's), as many views between any two
 *   circle  {"count": 36, "angle": 360}: the camera turned about the line through its target along
 *           up, to the right; of less than a whole turn half to either side */
typedef void (*lf_camera_list_fn)(lf_reader *reader, const lf_node *node, lf_scene_desc *out);
void lf_camera_list_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out);
void lf_camera_path_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out);
void lf_camera_circle_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out);

/* What is wrong with a camera, NULL: nothing; *out_key: the key to blame. */
const char *lf_camera_fault(const double position[3], const double target[3], const double up[3],
                            const char **out_key);

#endif
