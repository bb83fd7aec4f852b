#include "quilt/rgbd.h"

#include <math.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>

/* ----------------------------------------------------------------------------------- options -- */

static const char *const sides[] = {[LF_RGBD_IN_AUTO] = "auto",
                                    [LF_RGBD_IN_OFF] = "off",
                                    [LF_RGBD_IN_RIGHT] = "right",
                                    [LF_RGBD_IN_LEFT] = "left",
                                    [LF_RGBD_IN_TOP] = "top",
                                    [LF_RGBD_IN_BOTTOM] = "bottom",
                                    NULL};
static const char *const switches[] = {"off", "on", NULL};

#define PLACE(field) .place = offsetof(lf_standing, field)

/* clang-format off */
const lf_param lf_standing_params[] = {
    {.name = "rgbd_in", .option = "rgbd-in", .argument = "SIDE", PLACE(rgbd_in),
     .type = LF_PARAM_WORD, .words = sides, .optional = true, .low = LF_RGBD_IN_RIGHT,
     .help = "where the depth of an RGBD image is; auto: right if named ..._rgbd",
     .about = "where the depth of an RGBD image is; auto: right if the name ends with _rgbd"},
    {.name = "depth_inversion", .option = "depth-inversion", .argument = "off|on",
     PLACE(depth_inversion), .type = LF_PARAM_WORD, .words = switches,
     .help = "on: near is black, far white, in the depth of an RGBD image"},
    {.name = "chroma_depth", .option = "chroma-depth", .argument = "off|on", PLACE(chroma_depth),
     .type = LF_PARAM_WORD, .words = switches,
     .help = "on: the depth of an RGBD image is a hue, from red, near, to blue, far"},
    {.name = "depthiness", .option = "depthiness", .argument = "N", PLACE(depthiness), .low = 0,
     .high = 4, .initial = 1, .help = "factor of the depth of an RGBD image"},
    {.name = "depth_cutoff", .option = "depth-cutoff", .argument = "C", PLACE(depth_cutoff),
     .low = 0, .high = 1,
     .help = "least depth code of an RGBD image; farther points come up to it"},
    {.name = "focus", .option = "focus", .argument = "F", PLACE(focus), .low = -1, .high = 1,
     .help = "shift of a finished image between views; above 0 it moves behind the glass",
     .about = "shift of a finished image: view i of N moves to the right by (2 i/(N-1) - 1) F of "
              "its width; above 0 it moves behind the glass"},
    {.name = "zoom", .option = "zoom", .argument = "N", PLACE(zoom), .low = 0.1, .high = 4,
     .initial = 1, .help = "scale of a finished image about the middle of the view"},
    {.name = "crop_x", .option = "crop-x", .argument = "X", PLACE(crop_x), .low = -2, .high = 2,
     .help = "part of a finished image in the middle of the view: half widths to the right"},
    {.name = "crop_y", .option = "crop-y", .argument = "Y", PLACE(crop_y), .low = -2, .high = 2,
     .help = "part of a finished image in the middle of the view: half heights down"},
    {0},
};
/* clang-format on */

lf_status lf_standing_check(const lf_standing *standing, const char *where, lf_error *err)
{
    lf_standing filled = *standing;
    if (filled.zoom == 0)
        filled.zoom = 1;
    return lf_param_check(lf_standing_params, &filled, where, err);
}

bool lf_rgbd_named(const char *path)
{
    static const char mark[] = "_rgbd";
    const size_t length = sizeof mark - 1;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
               *dot = strrchr(name, '.');
    const size_t n = dot ? (size_t)(dot - name) : 0;
    return n >= length && strncasecmp(name + n - length, mark, length) == 0;
}

lf_rgbd_in lf_rgbd_side_of(const lf_standing *standing, const char *path)
{
    if (standing->rgbd_in != LF_RGBD_IN_AUTO)
        return standing->rgbd_in;
    return lf_rgbd_named(path) ? LF_RGBD_IN_RIGHT : LF_RGBD_IN_OFF;
}

bool lf_standing_is_plain(const lf_standing *standing)
{
    return standing->focus == 0 && (standing->zoom == 0 || standing->zoom == 1) &&
           standing->crop_x == 0 && standing->crop_y == 0;
}

/* ---------------------------------------------------------------------------------- geometry -- */

/* The margin of a view and its surface allow no larger disparity, in widths. */
#define MOST_DISPARITY 4.0

static double camera_at(double t, double cone)
{
    return cone > 0 ? tan(t * cone) / (2 * tan(0.5 * cone)) : t;
}

/* Takes the geometry of a picture that quiltd wrote. */
static void take_geometry(const lf_image_depth *d, lf_rgbd *rgbd)
{
    const double radians = M_PI / 180, cone = d->cone * radians,
                 line = tan(0.5 * cone) / (tan(0.5 * d->fov_y * radians) * d->aspect),
                 depth = 1 / d->near - 1 / d->far, disparity = line * d->distance * depth,
                 middle = floor(d->views / 2);
    if (!(disparity > 0 && isfinite(disparity)))
        return;
    rgbd->is_known = true;
    rgbd->is_flattened = disparity > MOST_DISPARITY;
    rgbd->disparity = fmin(disparity, MOST_DISPARITY);
    rgbd->plane = (1 / d->distance - 1 / d->far) / depth;
    rgbd->cone = cone;
    rgbd->centred = d->centred == 1;
    rgbd->offset = lf_rgbd_camera(rgbd, (int)middle, (int)d->views);
}

lf_rgbd lf_rgbd_of(const lf_standing *standing, lf_rgbd_in side, const lf_image_metadata *meta)
{
    const bool is_filled = standing->zoom > 0;
    lf_rgbd rgbd = {.side = side,
                    .near_is_black = standing->depth_inversion,
                    .is_hue = standing->chroma_depth,
                    .disparity = LF_RGBD_DISPARITY,
                    .plane = 0.5,
                    .cutoff = standing->depth_cutoff,
                    .focus = standing->focus,
                    .zoom = is_filled ? standing->zoom : 1,
                    .crop_x = standing->crop_x,
                    .crop_y = standing->crop_y};
    if (meta && lf_image_depth_is_valid(&meta->depth))
        take_geometry(&meta->depth, &rgbd);
    if (is_filled || standing->depthiness > 0)
        rgbd.disparity *= standing->depthiness;
    return rgbd;
}

void lf_rgbd_narrow(lf_rgbd *rgbd, double factor)
{
    const double shorter =
        rgbd->cone > 0 ? tan(0.5 * factor * rgbd->cone) / tan(0.5 * rgbd->cone) : factor;
    rgbd->cone *= factor;
    rgbd->disparity *= shorter;
    rgbd->offset /= shorter;
}

void lf_rgbd_turn(lf_rgbd *rgbd, int orientation, double aspect)
{
    if (!rgbd->is_known)
        return;
    if (lf_orientation_swaps(orientation)) {
        rgbd->disparity *= aspect;
        rgbd->offset = 0;
    } else if (orientation == 2 || orientation == 3) {
        rgbd->offset = -rgbd->offset;
    }
}

int lf_rgbd_tiles(const lf_image_depth *depth, int width, int height)
{
    if (!(depth->width >= 1 && depth->height >= 1))
        return 1;
    const double columns = width / depth->width, rows = height / depth->height;
    const bool is_quilt = columns == floor(columns) && rows == floor(rows) && columns * rows > 1 &&
                          columns * rows >= depth->views;
    return is_quilt ? (int)(columns * rows) : 1;
}

lf_status lf_rgbd_size(lf_rgbd_in side, int width, int height, const char *where, int *out_width,
                       int *out_height, lf_error *err)
{
    const bool beside = side == LF_RGBD_IN_RIGHT || side == LF_RGBD_IN_LEFT;
    if ((beside ? width : height) % 2 != 0)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "has no depth: %d %s do not have two halves of the same size; pass "
                            "rgbd_in off, or the side of the depth",
                            beside ? width : height, beside ? "columns" : "rows");
    *out_width = beside ? width / 2 : width;
    *out_height = beside ? height : height / 2;
    return LF_OK;
}

double lf_rgbd_camera(const lf_rgbd *rgbd, int view, int n_views)
{
    if (n_views < 2)
        return rgbd->offset; /* the picture itself */
    const double t = rgbd->centred ? (view + 0.5) / n_views : (double)view / (n_views - 1);
    return camera_at(t - 0.5, rgbd->cone);
}

double lf_rgbd_shift(const lf_rgbd *rgbd, int view, int n_views, double code)
{
    return (lf_rgbd_camera(rgbd, view, n_views) - rgbd->offset) * rgbd->disparity *
           (rgbd->plane - code);
}

double lf_rgbd_step(const lf_rgbd *rgbd, int n_views)
{
    double most = 0;
    const double ends[] = {rgbd->cutoff, 1};
    for (int i = 1; i < n_views; i++)
        for (int k = 0; k < 2; k++)
            most = fmax(most, fabs(lf_rgbd_shift(rgbd, i, n_views, ends[k]) -
                                   lf_rgbd_shift(rgbd, i - 1, n_views, ends[k]) +
                                   2 * rgbd->focus / (n_views - 1)));
    return most;
}
