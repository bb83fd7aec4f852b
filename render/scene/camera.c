#include "render/scene/camera.h"

#include <math.h>

#include "render/scene/key.h"

#define PLACE(field) .place = offsetof(lf_camera, field)

static const char *const placements[] = {"centred", "inclusive", NULL};

/* clang-format off */
const lf_param lf_camera_params[] = {
    {.name = "target", PLACE(target), .type = LF_PARAM_POINT, LF_COORDINATES,
     .about = "point in the middle of the window, in the focal plane"},
    {.name = "position", PLACE(position), .type = LF_PARAM_POINT, LF_COORDINATES,
     .point = {0, 0, 5},
     .about = "middle of the line of cameras, at least 1e-9 from target"},
    {.name = "up", PLACE(up), .type = LF_PARAM_POINT, LF_COORDINATES, .point = {0, 1, 0},
     .about = "direction that is up in the image; not along the line of sight"},
    {.name = "fov_y", PLACE(fov_y), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0.1, .high = 160, .initial = 14,
     .about = "vertical angle of the window, seen from the centre of the cameras"},
    {.name = "aspect", PLACE(aspect), .low = 0.05, .high = 20, .initial = 0.75,
     .about = "width / height of the window"},
    {.name = "views", PLACE(n_views), .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEWS,
     .initial = 45, .or_object = true,
     .about = "number of views, or an object that places the cameras; see Views"},
    {.name = "cone", PLACE(cone), .type = LF_PARAM_ANGLE, .unit = "degrees",
     .low = 0, .high = 160, .initial = 40,
     .about = "view cone: angle over which the cameras are spread, seen from the target"},
    {.name = "depthiness", PLACE(depthiness), .low = 0, .high = LF_MAX_DEPTHINESS, .initial = 1,
     .about = "factor of the view cone in use, also of a panel's own; 0: all views are equal"},
    {.name = "placement", PLACE(inclusive), .type = LF_PARAM_SWITCH, .words = placements,
     .about = "inclusive: the outermost cameras are at the ends of the cone; centred: half a "
              "spacing inside"},
    {.name = "lens_radius", PLACE(lens_radius), .unit = "scene units", .low = 0,
     .high = LF_MAX_COORDINATE,
     .about = "radius of each view's lens; 0: a pinhole, everything is sharp"},
    {.name = "focus_distance", PLACE(focus_distance), .unit = "scene units", .low = LF_MIN_DISTANCE,
     .high = LF_MAX_COORDINATE,
     .about = "distance along the view axis that is sharp with a lens_radius (distance of target)"},
    {.name = "view_blur", PLACE(view_blur), .unit = "camera spacings", .low = 0,
     .high = LF_MAX_VIEW_BLUR,
     .about = "width of each view's aperture along the line of cameras; 0: a pinhole; excludes "
              "lens_radius"},
    {.name = "shutter", PLACE(shutter), .unit = "frames", .low = 0, .high = LF_MAX_SHUTTER,
     .about = "exposure time, see Motion blur; 0: no motion blur"},
    {.name = "shutter_open", PLACE(shutter_open), .unit = "frames", .low = -LF_MAX_SHUTTER,
     .high = LF_MAX_SHUTTER,
     .about = "time at which the shutter opens, relative to the frame; minus half of shutter "
              "centres it"},
    {0},
};
/* clang-format on */

void lf_camera_deepen(lf_camera *camera)
{
    camera->cone *= camera->depthiness;
    camera->track *= camera->depthiness;
    camera->rows_height *= camera->depthiness;
    camera->depthiness = 1;
}

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
