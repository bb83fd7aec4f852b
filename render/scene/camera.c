#include "render/scene/camera.h"

#include <math.h>

#include "render/scene/key.h"

#define PLACE(field) .place = offsetof(lf_camera, field)

static const char *const placements[] = {"centred", "inclusive", NULL};

/* clang-format off */
const lf_param lf_camera_params[] = {
    {.name = "target", PLACE(target), .type = LF_PARAM_POINT, LF_COORDINATES,
     .about = "centre of the window, x,y,z in scene units"},
    {.name = "position", PLACE(position), .type = LF_PARAM_POINT, LF_COORDINATES,
     .point = {0, 0, 5},
     .about = "centre of the line of cameras, x,y,z in scene units"},
    {.name = "up", PLACE(up), .type = LF_PARAM_POINT, LF_COORDINATES, .point = {0, 1, 0},
     .about = "up direction of the image"},
    {.name = "fov_y", PLACE(fov_y), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0.1, .high = 160, .initial = 14,
     .about = "vertical angle of the window, seen from the centre of the cameras"},
    {.name = "aspect", PLACE(aspect), .low = 0.05, .high = 20, .initial = 0.75,
     .about = "width / height of the window"},
    {.name = "views", PLACE(n_views), .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEWS,
     .initial = 45, .or_object = true,
     .about = "number of views, or an object that places the cameras (scene-format.md)"},
    {.name = "cone", PLACE(cone), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0, .high = 160, .initial = 40,
     .about = "total angle over which the cameras are spread, seen from the target"},
    {.name = "placement", PLACE(inclusive), .type = LF_PARAM_SWITCH, .words = placements,
     .about = "outermost cameras: at the ends of the cone (inclusive) or half a spacing inside "
              "(centred)"},
    {.name = "lens_radius", PLACE(lens_radius), .low = 0, .high = LF_MAX_COORDINATE,
     .about = "lens radius of each view, in scene units; 0: everything is sharp"},
    {.name = "focus_distance", PLACE(focus_distance), .low = LF_MIN_DISTANCE,
     .high = LF_MAX_COORDINATE,
     .about = "focus distance with a lens_radius, in scene units (distance of the window)"},
    {.name = "view_blur", PLACE(view_blur), .unit = "views", .low = 0, .high = LF_MAX_VIEW_BLUR,
     .about = "aperture width of each view along the line of cameras; 0: a pinhole"},
    {.name = "shutter", PLACE(shutter), .unit = "frames", .low = 0, .high = LF_MAX_SHUTTER,
     .about = "exposure time; 0: no motion blur"},
    {.name = "shutter_open", PLACE(shutter_open), .unit = "frames", .low = -LF_MAX_SHUTTER,
     .high = LF_MAX_SHUTTER,
     .about = "time from the frame to the opening of the shutter"},
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
