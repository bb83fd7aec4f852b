#include "render/load/camera_parse.h"

#include "render/load/member_read.h"
#include "render/scene/vec_double.h"

/* The rig needs a view axis and an up vector that is not along it. */
static void check_camera(lf_reader *reader, const lf_node *node, lf_camera *camera)
{
    double view[3], cross[3];
    const double *up = camera->up;
    lf_sub_double(camera->target, camera->position, view);
    double distance = lf_length_double(view);
    lf_node position = lf_node_child(node, "position"), up_node = lf_node_child(node, "up"),
            blur = lf_node_child(node, "view_blur");
    if (!(distance > 0)) {
        lf_read_fail(reader, &position, "the camera stands on its target");
        return;
    }
    lf_cross_double(view, up, cross);
    if (!(lf_length_double(cross) > 1e-6 * distance * lf_length_double(up)))
        lf_read_fail(reader, &up_node, "up is zero or along the line of sight");
    if (camera->view_blur > 0 && camera->lens_radius > 0)
        lf_read_fail(reader, &blur, "does not go with a lens_radius: one lens at a time");
    if (!lf_node_child(node, "focus_distance").value)
        camera->focus_distance = distance;
}

void lf_camera_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out)
{
    lf_camera *camera = &out->camera;
    const lf_node node = lf_node_child(root, "camera");
    *camera = (lf_camera){0};
    lf_read_params(reader, &node, lf_camera_params, camera);
    camera->has_aspect = lf_node_child(&node, "aspect").value;
    camera->has_views = lf_node_child(&node, "views").value;
    camera->has_cone = lf_node_child(&node, "cone").value;
    if (reader->status == LF_OK)
        check_camera(reader, &node, camera);
}
