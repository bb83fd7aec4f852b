#include "render/scene/camera.h"

#include <math.h>

#include "render/scene/key.h"

#define PLACE(field) .place = offsetof(lf_camera, field)

static const char *const placements[] = {"centred", "inclusive", NULL};

/* clang-format off */
const lf_param lf_camera_params[] = {
    {.name = "target", PLACE(target), .type = LF_PARAM_POINT, LF_COORDINATES,
     .about = "point in the middle of the window, x,y,z in scene units"},
    {.name = "position", PLACE(position), .type = LF_PARAM_POINT, LF_COORDINATES,
     .point = {0, 0, 5},
     .about = "middle of the line of cameras, x,y,z in scene units"},
    {.name = "up", PLACE(up), .type = LF_PARAM_POINT, LF_COORDINATES, .point = {0, 1, 0},
     .about = "direction that is up in the picture"},
    {.name = "fov_y", PLACE(fov_y), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0.1, .high = 160, .initial = 14,
     .about = "vertical angle of the window, seen from the middle of the cameras"},
    {.name = "aspect", PLACE(aspect), .low = 0.05, .high = 20, .initial = 0.75,
     .about = "width of the window over its height"},
    {.name = "views", PLACE(n_views), .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEWS,
     .initial = 45, .or_object = true,
     .about = "number of views, or an object that places the cameras (scene-format.md)"},
    {.name = "cone", PLACE(cone), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0, .high = 160, .initial = 40,
     .about = "angle over which the cameras are spread, seen from the target"},
    {.name = "placement", PLACE(inclusive), .type = LF_PARAM_SWITCH, .words = placements,
     .about = "outermost cameras: at the ends of the cone (inclusive) or half a spacing inside"},
    {.name = "lens_radius", PLACE(lens_radius), .low = 0, .high = LF_MAX_COORDINATE,
     .about = "radius of each view's lens, in scene units; 0: everything is sharp"},
    {.name = "focus_distance", PLACE(focus_distance), .low = LF_MIN_DISTANCE,
     .high = LF_MAX_COORDINATE,
     .about = "distance that is sharp with a lens_radius, in scene units (the window's)"},
    {.name = "view_blur", PLACE(view_blur), .unit = "views", .low = 0, .high = LF_MAX_VIEW_BLUR,
     .about = "width of each view's aperture along the line of cameras; 0: a pinhole"},
    {.name = "shutter", PLACE(shutter), .unit = "frames", .low = 0, .high = LF_MAX_SHUTTER,
     .about = "how long the shutter is open; 0: nothing moving is blurred"},
    {.name = "shutter_open", PLACE(shutter_open), .unit = "frames", .low = -LF_MAX_SHUTTER,
     .high = LF_MAX_SHUTTER,
     .about = "when the shutter opens, before or behind the frame"},
    {0},
};
/* clang-format on */

lf_camera lf_camera_row(const lf_camera *camera, int row)
{
    lf_camera one = *camera;
    if (camera->has_parts) {
        one.first_view = row * camera->n_views;
        one.all_views = camera->n_rows * camera->n_views;
        one.n_rows = 0;
        one.has_parts = false;
        return one;
    }
    const double place = camera->n_rows > 1 ? (double)row / (camera->n_rows - 1) - 0.5 : 0.0;
    one.rise += place * camera->rows_height;
    one.rows_step = camera->n_rows > 1 ? fabs(camera->rows_height) / (camera->n_rows - 1) : 0.0;
    one.n_rows = 0;
    one.rows_height = 0.0;
    return one;
}
