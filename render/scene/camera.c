/* What a scene says of its camera. */
#include "render/render.h"
#include "render/scene/key.h"

#define PLACE(field) .place = offsetof(lf_camera, field)

static const char *const placements[] = {"centred", "inclusive", NULL};

/* clang-format off */
const lf_param lf_camera_params[] = {
    {.name = "target", PLACE(target), .type = LF_PARAM_POINT, LF_COORDINATES},
    {.name = "position", PLACE(position), .type = LF_PARAM_POINT, LF_COORDINATES,
     .point = {0, 0, 5}},
    {.name = "up", PLACE(up), .type = LF_PARAM_POINT, LF_COORDINATES, .point = {0, 1, 0}},
    {.name = "fov_y", PLACE(fov_y), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0.1, .high = 160, .initial = 14},
    {.name = "aspect", PLACE(aspect), .low = 0.05, .high = 20, .initial = 0.75},
    {.name = "views", PLACE(n_views), .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEWS,
     .initial = 45, .or_object = true},
    {.name = "cone", PLACE(cone), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0, .high = 160, .initial = 40},
    {.name = "placement", PLACE(inclusive), .type = LF_PARAM_SWITCH, .words = placements},
    {.name = "lens_radius", PLACE(lens_radius), .low = 0, .high = LF_MAX_COORDINATE},
    {.name = "focus_distance", PLACE(focus_distance), .low = LF_MIN_DISTANCE,
     .high = LF_MAX_COORDINATE},
    {.name = "view_blur", PLACE(view_blur), .unit = "views", .low = 0, .high = LF_MAX_VIEW_BLUR},
    {.name = "shutter", PLACE(shutter), .unit = "frames", .low = 0, .high = LF_MAX_SHUTTER},
    {.name = "shutter_open", PLACE(shutter_open), .unit = "frames", .low = -LF_MAX_SHUTTER,
     .high = LF_MAX_SHUTTER},
    {0},
};
/* clang-format on */
