#include "daemon/output/fit.h"

#include <math.h>

lf_status lf_fit_patch(const lf_scene *scene, const lf_render_settings *settings, const char *name,
                       double fill, double steps, json_t **out_patch, lf_error *err)
{
    double target[3], position[3], distance = 0.0;
    lf_status status = lf_camera_fit(scene, settings, name, fill, steps, target, position, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < 3; i++)
        distance += (target[i] - position[i]) * (target[i] - position[i]);
    *out_patch = json_pack("{s:{s:[f,f,f], s:[f,f,f]}}", "camera", "target", target[0], target[1],
                           target[2], "position", position[0], position[1], position[2]);
    if (json_object_get(json_object_get(lf_scene_json(scene), "camera"), "focus_distance"))
        json_object_set_new(json_object_get(*out_patch, "camera"), "focus_distance",
                            json_real(sqrt(distance)));
    return LF_OK;
}
