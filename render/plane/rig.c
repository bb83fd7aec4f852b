#include "render/plane/rig.h"

#include <string.h>

#include "render/scene/limits.h"
#include "render/scene/vec_double.h"

lf_status lf_rig_check_size(const lf_render_settings *s, lf_error *err)
{
    const lf_camera *c = &s->camera;
    if (c->n_views < 1 || c->n_views > LF_MAX_VIEWS)
        return lf_error_set(err, LF_E_ARG, "views", "%d is not between 1 and %d", c->n_views,
                            LF_MAX_VIEWS);
    if (s->width < 1 || s->width > LF_MAX_VIEW_SIDE || s->height < 1 ||
        s->height > LF_MAX_VIEW_SIDE)
        return lf_error_set(err, LF_E_ARG, "view size",
                            "%dx%d: each side must be between 1 and %d pixels", s->width, s->height,
                            LF_MAX_VIEW_SIDE);
    if (!(c->aspect > 0.0 && c->aspect < 1e3))
        return lf_error_set(err, LF_E_ARG, "camera.aspect", "must be above 0");
    return LF_OK;
}

static lf_status check(const lf_render_settings *s, lf_error *err)
{
    const lf_camera *c = &s->camera;
    if (c->list)
        return lf_error_set(
            err, LF_E_ARG, "camera.views",
            "cameras listed one by one do not form a rig; use an arc, a track or a grid");
    lf_status status = lf_rig_check_size(s, err);
    if (status != LF_OK)
        return status;
    if (!(c->fov_y > 0.0 && c->fov_y < 3.1))
        return lf_error_set(err, LF_E_ARG, "camera.fov_y", "must be above 0 and below 178 degrees");
    if (!(c->cone >= 0.0 && c->cone < 3.1))
        return lf_error_set(err, LF_E_ARG, "camera.cone",
                            "must be at least 0 and, times depthiness, below 178 degrees");
    if (c->first_view < 0 || (c->all_views > 0 && c->all_views < c->first_view + c->n_views))
        return lf_error_set(err, LF_E_ARG, "camera.views", "a part is not within its track");
    if (!(c->track >= 0.0))
        return lf_error_set(err, LF_E_ARG, "camera.views",
                            "the length of a track must not be negative");
    if (!isfinite(c->rise) || !(c->rows_step >= 0.0 && isfinite(c->rows_step)))
        return lf_error_set(err, LF_E_ARG, "camera.views", "the height of a row must be finite");
    if (!(c->lens_radius >= 0.0))
        return lf_error_set(err, LF_E_ARG, "camera.lens_radius", "must not be negative");
    if (!(c->view_blur >= 0.0 && c->view_blur <= LF_MAX_VIEW_BLUR))
        return lf_error_set(err, LF_E_ARG, "camera.view_blur", "must be between 0 and %d",
                            LF_MAX_VIEW_BLUR);
    if (c->view_blur > 0.0 && c->lens_radius > 0.0)
        return lf_error_set(err, LF_E_ARG, "camera.view_blur",
                            "cannot be combined with lens_radius; remove one of them");
    return LF_OK;
}

static lf_vec3 scaled(const double a[3], double s)
{
    return lf_v3((float)(a[0] * s), (float)(a[1] * s), (float)(a[2] * s));
}

static lf_status axes(lf_rig *rig, const lf_camera *c, double *out_distance, lf_error *err)
{
    double forward[3], right[3], up[3];
    lf_sub_double(c->target, c->position, forward);
    double distance = lf_length_double(forward);
    if (!(distance >= LF_MIN_DISTANCE) || !isfinite(distance))
        return lf_error_set(err, LF_E_ARG, "camera",
                            "position and target must be at least %g apart", LF_MIN_DISTANCE);
    lf_cross_double(forward, c->up, right);
    double r = lf_length_double(right);
    if (!(r > 1e-12 * distance * lf_length_double(c->up)))
        return lf_error_set(err, LF_E_ARG, "camera.up",
                            "must not be parallel to the view direction");
    lf_cross_double(right, forward, up);
    rig->forward = scaled(forward, 1.0 / distance);
    rig->right = scaled(right, 1.0 / r);
    rig->up = scaled(up, 1.0 / lf_length_double(up));
    *out_distance = distance;
    return LF_OK;
}

/* Position of view k along the rig, from its middle. */
static double place_in(const lf_camera *c, int k)
{
    const int n = c->n_views;
    if (c->track > 0.0 && c->all_views > 0)
        return (double)(c->first_view + k) / (c->all_views - 1) - 0.5;
    if (c->inclusive || c->track > 0.0)
        return n > 1 ? (double)k / (n - 1) - 0.5 : 0.0;
    return (k + 0.5) / n - 0.5;
}

/* Offset of view i is D tan(a_i), or a share of the track (docs/developer/estimators.md, "2. The
 * rig and its row planes"). */
static void place_views(lf_rig *rig, const lf_camera *c, double distance)
{
    int n = c->n_views;
    for (int i = 0; i < LF_MAX_LANES; i++) {
        const double t = place_in(c, i < n ? i : n - 1);
        rig->b[i] = (float)(c->track > 0.0 ? t * c->track : distance * tan(t * c->cone));
        rig->skew[i] = rig->still * rig->b[i];
    }
    if (n > 1)
        rig->blur =
            (float)(0.5 * c->view_blur * ((double)rig->b[n - 1] - (double)rig->b[0]) / (n - 1));
    rig->blur_up = (float)(0.5 * c->view_blur * c->rows_step);
}

lf_status lf_rig_init(lf_rig *rig, const lf_render_settings *settings, const double origin[3],
                      lf_error *err)
{
    const lf_camera *c = &settings->camera;
    lf_status status = check(settings, err);
    double distance = 0.0;
    lf_rig r;
    memset(&r, 0, sizeof r);
    if (status == LF_OK)
        status = axes(&r, c, &distance, err);
    if (status != LF_OK)
        return status;
    r.n_views = c->n_views;
    r.width = settings->width;
    r.height = settings->height;
    const lf_vec3 middle =
        lf_v3((float)(c->position[0] - origin[0]), (float)(c->position[1] - origin[1]),
              (float)(c->position[2] - origin[2]));
    r.eye = lf_madd(middle, (float)c->rise, r.up);
    r.distance = (float)distance;
    const bool own = c->track > 0.0 && c->own_windows;
    r.window = own ? LF_FAR_WINDOW : r.distance;
    r.still = own ? 0.0f : 1.0f;
    r.lens_radius = (float)c->lens_radius;
    r.focus = c->lens_radius > 0.0 && c->focus_distance > 0.0 ? (float)c->focus_distance : r.window;
    double window_height = 2.0 * distance * tan(0.5 * c->fov_y);
    double window_width = window_height * c->aspect;
    const double *w = settings->window;
    bool whole = w[0] == 0.0 && w[1] == 0.0 && w[2] == 0.0 && w[3] == 0.0;
    double left = whole ? 0.0 : w[0], top = whole ? 0.0 : w[1], right = whole ? 1.0 : w[2],
           bottom = whole ? 1.0 : w[3];
    if (!(right > left && bottom > top))
        return lf_error_set(err, LF_E_ARG, "window", "must have a positive size");
    r.tangent = c->rolled ? INFINITY : (float)tan(0.5 * c->fov_y);
    r.x0 = (float)((left - 0.5) * window_width);
    r.dx = (float)((right - left) * window_width / settings->width);
    r.sink = (float)((own ? 0.0 : c->rise) / distance);
    r.y0 = (float)((0.5 - top) * window_height - (own ? 0.0 : c->rise));
    r.dy = (float)(-(bottom - top) * window_height / settings->height);
    place_views(&r, c, distance);
    *rig = r;
    return LF_OK;
}

lf_status lf_rig_init_at(lf_rig *rig, const lf_render_settings *settings, const double origin[3],
                         double time, lf_error *err)
{
    lf_render_settings then = *settings;
    const lf_camera_shift *open = &settings->camera.shift[0], *close = &settings->camera.shift[1];
    for (int i = 0; i < 3; i++) {
        then.camera.position[i] +=
            open->position[i] + time * (close->position[i] - open->position[i]);
        then.camera.target[i] += open->target[i] + time * (close->target[i] - open->target[i]);
    }
    then.camera.focus_distance +=
        open->focus_distance + time * (close->focus_distance - open->focus_distance);
    return lf_rig_init(rig, &then, origin, err);
}

void lf_rig_row_plane(const lf_rig *rig, float v, const float u_lens[2], lf_row_plane *out)
{
    float yw = rig->y0 + v * rig->dy;
    out->ly = rig->blur_up > 0.0f ? rig->blur_up * (2.0f * u_lens[0] - 1.0f) : 0.0f;
    out->lens_chord = rig->blur;
    if (rig->lens_radius > 0.0f) {
        /* The height of a uniform point of the disk; lx given ly is then uniform on the chord. */
        float y = sqrtf(u_lens[0]) * sinf(2.0f * LF_PI * u_lens[1]);
        out->ly = rig->lens_radius * y;
        out->lens_chord = rig->lens_radius * sqrtf(lf_max(0.0f, 1.0f - y * y));
    }
    out->my = yw / rig->distance - out->ly / rig->focus;
}

/* Maps (X, Y, Z, 1) from the camera space of `from` to the camera space of `to`. */
static void find_pose(const lf_rig *from, const lf_rig *to, double out[3][4])
{
    const lf_vec3 old[3] = {from->right, from->up, from->forward},
                  axis[3] = {to->right, to->up, to->forward}, away = lf_sub(from->eye, to->eye);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            out[i][j] = (double)lf_dot(axis[i], old[j]);
        out[i][3] = (double)lf_dot(axis[i], away);
    }
}

void lf_rig_map_between(const lf_rig *from, const lf_rig *to, double out[4][4])
{
    /* (X_w, Y_w, D, D/Z) is a point's (X, Y, Z, 1) times D/Z. */
    const double there[4][4] = {{(double)from->dx, 0.0, 0.0, (double)from->x0},
                                {0.0, (double)from->dy, 0.0, (double)from->y0},
                                {0.0, 0.0, 0.0, (double)from->distance},
                                {0.0, 0.0, 1.0, 0.0}};
    double pose[3][4], here[4];
    find_pose(from, to, pose);
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 3; i++) {
            here[i] = 0.0;
            for (int k = 0; k < 4; k++)
                here[i] += pose[i][k] * there[k][j];
        }
        here[3] = there[3][j];
        double d = (double)to->distance;
        out[0][j] = (d * here[0] - (double)to->x0 * here[2]) / (double)to->dx;
        out[1][j] = (d * here[1] - (double)to->y0 * here[2]) / (double)to->dy;
        out[2][j] = d * here[3];
        out[3][j] = here[2];
    }
}

float lf_rig_view_between(const lf_rig *from, const lf_rig *to)
{
    double pose[3][4], d = (double)from->distance, n = to->n_views,
                       width = (double)to->b[to->n_views - 1] - (double)to->b[0];
    find_pose(from, to, pose);
    /* the middle of the window is d of the view axis away from the eye */
    double x = d * pose[0][2], z = d * pose[2][2];
    if (!(width > 0.0) || !(z > 0.0))
        return 0.0f;
    double b = pose[0][3] - pose[2][3] * x / z;
    return (float)(b * (n - 1.0) / (width * n));
}
