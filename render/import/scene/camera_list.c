#include "render/import/scene/camera_list.h"

#include <string.h>

#include "base/alloc.h"
#include "render/import/scene/member_read.h"
#include "render/scene/vec_double.h"

const char *lf_camera_fault(const double position[3], const double target[3], const double up[3],
                            const char **out_key)
{
    double view[3], cross[3];
    lf_sub_double(target, position, view);
    const double distance = lf_length_double(view);
    *out_key = "position";
    if (!(distance >= LF_MIN_DISTANCE))
        return "the camera is at its target, or less than 1e-9 from it";
    lf_cross_double(view, up, cross);
    *out_key = "up";
    return lf_length_double(cross) > 1e-6 * distance * lf_length_double(up)
               ? NULL
               : "up is zero or parallel to the view direction";
}

static bool make_room(lf_reader *reader, int n, lf_view_camera **out)
{
    *out = lf_calloc((size_t)n, sizeof **out);
    if (!*out)
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    return *out;
}

static lf_view_camera own_of(const lf_camera *camera)
{
    lf_view_camera own = {.fov_y = camera->fov_y};
    memcpy(own.position, camera->position, sizeof own.position);
    memcpy(own.target, camera->target, sizeof own.target);
    memcpy(own.up, camera->up, sizeof own.up);
    return own;
}

static void read_one(lf_reader *reader, const lf_node *node, const lf_camera *camera,
                     lf_view_camera *out)
{
    static const char *const keys[] = {"position", "target", "up", "fov_y", NULL};
    const char *key = NULL;
    *out = own_of(camera);
    if (!lf_read_object(reader, node, keys))
        return;
    if (!lf_node_child(node, "position").value)
        lf_read_fail(reader, node, "\"position\" is missing: the position of the camera");
    lf_read_numbers(reader, node, "position", 3, out->position, -LF_MAX_COORDINATE,
                    LF_MAX_COORDINATE);
    lf_read_numbers(reader, node, "target", 3, out->target, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    lf_read_numbers(reader, node, "up", 3, out->up, -LF_MAX_COORDINATE, LF_MAX_COORDINATE);
    if (lf_node_child(node, "fov_y").value)
        out->fov_y = LF_RADIANS(lf_read_number(reader, node, "fov_y", 14, 0.1, 160));
    const char *fault = lf_camera_fault(out->position, out->target, out->up, &key);
    const lf_node at = lf_node_child(node, fault ? key : "position");
    if (fault && reader->status == LF_OK)
        lf_read_fail(reader, &at, "%s", fault);
}

/* Reads an array of cameras; returns their number, 0 on errors. */
static int read_cameras(lf_reader *reader, const lf_node *node, int least, const lf_camera *camera,
                        lf_view_camera **out)
{
    const size_t n = json_array_size(node->value);
    if (!json_is_array(node->value) || n < (size_t)least || n > LF_MAX_VIEWS) {
        lf_read_fail(reader, node, "expected an array of %d to %d cameras", least, LF_MAX_VIEWS);
        return 0;
    }
    if (!make_room(reader, (int)n, out))
        return 0;
    for (size_t i = 0; i < n && reader->status == LF_OK; i++) {
        const lf_node one = lf_node_item(node, i);
        read_one(reader, &one, camera, &(*out)[i]);
    }
    return reader->status == LF_OK ? (int)n : 0;
}

/* Code that needs one camera uses the middle one. */
static void adopt(lf_scene_desc *desc, int n)
{
    const lf_view_camera *middle = &desc->views[n / 2];
    lf_camera *camera = &desc->camera;
    camera->n_views = n;
    camera->list = desc->views;
    memcpy(camera->position, middle->position, sizeof camera->position);
    memcpy(camera->target, middle->target, sizeof camera->target);
    memcpy(camera->up, middle->up, sizeof camera->up);
    camera->fov_y = middle->fov_y;
}

void lf_camera_list_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out)
{
    const int n = read_cameras(reader, node, 1, &out->camera, &out->views);
    if (n > 0)
        adopt(out, n);
}

/* ------------------------------------------------------------------------------------- paths -- */

/* A cubic between b and c, with neighbours a and d; its direction at b is c - a. */
static double along(double a, double b, double c, double d, double t)
{
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/* The camera at t after key i; an open path continues straight at its ends. */
static lf_view_camera between(const lf_view_camera *keys, int n, bool closed, int i, double t)
{
    enum { NUMBERS = sizeof(lf_view_camera) / sizeof(double) };
    double at[4][NUMBERS];
    lf_view_camera out;
    for (int k = 0; k < 4; k++) {
        int j = i + k - 1;
        j = closed ? (j + n) % n : j < 0 ? 0 : j < n ? j : n - 1;
        memcpy(at[k], &keys[j], sizeof at[k]);
    }
    for (int k = 0; k < NUMBERS && !closed; k++) {
        at[0][k] = i > 0 ? at[0][k] : 2 * at[1][k] - at[2][k];
        at[3][k] = i + 2 < n ? at[3][k] : 2 * at[2][k] - at[1][k];
    }
    for (int k = 0; k < NUMBERS; k++)
        at[0][k] = along(at[0][k], at[1][k], at[2][k], at[3][k], t);
    memcpy(&out, at[0], sizeof out);
    return out;
}

static void follow_path(lf_reader *reader, const lf_node *node, const lf_view_camera *keys, int n,
                        int count, lf_view_camera *out)
{
    const bool closed = lf_read_bool(reader, node, "closed", false);
    const int ways = closed ? n : n - 1, steps = closed ? count : count > 1 ? count - 1 : 1;
    for (int k = 0; k < count && reader->status == LF_OK; k++) {
        const double place = (double)k * ways / steps;
        const int i = place < ways ? (int)place : ways - 1;
        const char *key = NULL;
        out[k] = between(keys, n, closed, i, place - i);
        out[k].fov_y = fmin(fmax(out[k].fov_y, LF_RADIANS(0.1)), LF_RADIANS(160));
        const char *fault = lf_camera_fault(out[k].position, out[k].target, out[k].up, &key);
        if (fault)
            lf_read_fail(reader, node, "at view %d of the path, %s", k, fault);
    }
}

void lf_camera_path_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out)
{
    static const char *const members[] = {"count", "through", "closed", NULL};
    const lf_node through = lf_node_child(node, "through");
    lf_view_camera *keys = NULL;
    if (!lf_read_object(reader, node, members))
        return;
    const int count = lf_read_int(reader, node, "count", out->camera.n_views, 1, LF_MAX_VIEWS),
              n = read_cameras(reader, &through, 2, &out->camera, &keys);
    if (n > 0 && make_room(reader, count, &out->views)) {
        follow_path(reader, node, keys, n, count, out->views);
        adopt(out, count);
    }
    lf_free(keys);
}

/* ----------------------------------------------------------------------------------- circles -- */

/* v turned about the unit axis, counter-clockwise seen against it. */
static void turn(const double axis[3], double angle, const double v[3], double out[3])
{
    double across[3];
    const double c = cos(angle), s = sin(angle), along_axis = lf_dot_double(axis, v) * (1 - c);
    lf_cross_double(axis, v, across);
    for (int i = 0; i < 3; i++)
        out[i] = c * v[i] + s * across[i] + along_axis * axis[i];
}

void lf_camera_circle_parse(lf_reader *reader, const lf_node *node, lf_scene_desc *out)
{
    static const char *const members[] = {"count", "angle", NULL};
    const lf_camera *c = &out->camera;
    const char *key = NULL;
    if (!lf_read_object(reader, node, members))
        return;
    const int n = lf_read_int(reader, node, "count", c->n_views, 1, LF_MAX_VIEWS);
    const double angle = LF_RADIANS(lf_read_number(reader, node, "angle", 360, 1e-3, 360)),
                 up = lf_length_double(c->up),
                 axis[3] = {c->up[0] / up, c->up[1] / up, c->up[2] / up};
    const bool whole = angle >= 2 * M_PI - 1e-9;
    const int half = n / 2;
    const double step = whole   ? angle / n
                        : n > 1 ? angle / (n - 1)
                                : 0,
                 first = whole ? -step * half : -0.5 * step * (n - 1);
    double away[3];
    if (reader->status != LF_OK || lf_camera_fault(c->position, c->target, c->up, &key) ||
        !make_room(reader, n, &out->views))
        return; /* errors of the camera itself are reported there */
    lf_sub_double(c->position, c->target, away);
    for (int k = 0; k < n; k++) {
        out->views[k] = own_of(c);
        turn(axis, first + k * step, away, out->views[k].position);
        for (int i = 0; i < 3; i++)
            out->views[k].position[i] += c->target[i];
    }
    out->camera.n_views = n;
    out->camera.list = out->views;
}
