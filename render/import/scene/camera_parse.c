#include "render/import/scene/camera_parse.h"

#include "render/import/scene/camera_list.h"
#include "render/import/scene/frame_file.h"
#include "render/import/scene/member_read.h"
#include "render/scene/vec_double.h"

/* The rig needs a view axis and an up vector that is not along it. */
void lf_camera_check(lf_reader *reader, const lf_node *root, lf_camera *camera)
{
    double view[3];
    const char *key = NULL,
               *fault = lf_camera_fault(camera->position, camera->target, camera->up, &key);
    const lf_node node = lf_node_child(root, "camera"), blur = lf_node_child(&node, "view_blur"),
                  depth = lf_node_child(&node, "depthiness"), at = lf_node_child(&node, key);
    if (fault) {
        lf_read_fail(reader, &at, "%s", fault);
        return;
    }
    lf_sub_double(camera->target, camera->position, view);
    if (camera->list && camera->view_blur > 0)
        lf_read_fail(
            reader, &blur,
            "cameras listed one by one cannot have view_blur; use an arc, a track or a grid");
    if (camera->list && fabs(camera->depthiness - 1) > 0)
        lf_read_fail(
            reader, &depth,
            "cameras listed one by one cannot have depthiness; use an arc, a track or a grid");
    if (camera->view_blur > 0 && camera->lens_radius > 0)
        lf_read_fail(reader, &blur, "cannot be combined with lens_radius; remove one of them");
    if (!lf_node_child(&node, "focus_distance").value)
        camera->focus_distance = camera->list ? 0.0 : lf_length_double(view);
}

/* A camera of a mesh's file. */
static void parse_framing(lf_reader *reader, const lf_node *node, lf_framing *framing)
{
    static const char *const keys[] = {"mesh", "camera", "distance", NULL};
    const lf_node from = lf_node_child(node, "from"), camera = lf_node_child(&from, "camera"),
                  distance = lf_node_child(&from, "distance");
    *framing = (lf_framing){.number = -1};
    if (!lf_read_object(reader, &from, keys))
        return;
    framing->mesh = lf_read_string(reader, &from, "mesh", NULL, LF_MAX_NAME);
    if (!framing->mesh)
        lf_read_fail(reader, &from, "\"mesh\" is missing: the mesh whose file has the camera");
    if (json_is_string(camera.value))
        framing->name = lf_read_string(reader, &from, "camera", NULL, LF_MAX_NAME);
    else if (camera.value)
        framing->number = lf_read_int(reader, &from, "camera", 0, 0, LF_MAX_FRAME);
    if (distance.value)
        framing->distance = lf_read_number(reader, &from, "distance", 1, 1e-9, LF_MAX_COORDINATE);
    framing->own_position = lf_node_child(node, "position").value;
    framing->own_target = lf_node_child(node, "target").value;
    framing->own_up = lf_node_child(node, "up").value;
    framing->own_fov = lf_node_child(node, "fov_y").value;
}

/* Cameras of a part of a track: fewer would share little. */
#define LEAST_PART 64

static const char *const windows[] = {"shared", "own", NULL};

/* As few equal parts as can be; 0: those would be too small. */
static int parts_of(int n)
{
    int parts = (n + LF_MAX_VIEWS - 1) / LF_MAX_VIEWS;
    while (n % parts != 0)
        parts++;
    return n / parts >= LEAST_PART ? parts : 0;
}

/* Divides the views into equal parts, each a rig. */
static void part_track(lf_reader *reader, const lf_node *count, int n, lf_camera *camera)
{
    int good = n;
    while (parts_of(good) == 0)
        good--;
    if (good != n)
        lf_read_fail(reader, count,
                     "%d cameras cannot be divided into equal parts of %d to %d cameras; %d can", n,
                     LEAST_PART, LF_MAX_VIEWS, good);
    camera->n_rows = parts_of(good);
    camera->n_views = good / camera->n_rows;
    camera->has_parts = true;
}

/* Cameras on a track: {"track": {"count": 100, "length": 3, "window": "own"}}. */
static void parse_track(lf_reader *reader, const lf_node *track, lf_camera *camera)
{
    static const char *const keys[] = {"count", "length", "window", NULL};
    if (!lf_read_object(reader, track, keys))
        return;
    if (!lf_node_child(track, "length").value)
        lf_read_fail(reader, track,
                     "\"length\" is missing: the distance from the first to the last camera, in "
                     "scene units");
    const int n = lf_read_int(reader, track, "count", camera->n_views, 1, LF_MAX_TRACK_VIEWS);
    const lf_node count = lf_node_child(track, "count");
    camera->n_views = n;
    if (n > LF_MAX_VIEWS && reader->status == LF_OK)
        part_track(reader, &count, n, camera);
    camera->track = lf_read_number(reader, track, "length", 1, 1e-9, LF_MAX_COORDINATE);
    camera->own_windows = lf_read_choice(reader, track, "window", windows, 1);
}

/* {"grid": {"columns": 9, "rows": 7, "width": 2, "height": 1.5, "window": "shared"}}. */
static void parse_grid(lf_reader *reader, const lf_node *grid, lf_camera *camera)
{
    static const char *const keys[] = {"columns", "rows", "width", "height", "window", NULL};
    if (!lf_read_object(reader, grid, keys))
        return;
    for (int i = 0; i < 4; i++)
        if (!lf_node_child(grid, keys[i]).value) {
            lf_read_fail(reader, grid, "\"%s\" is missing: %s", keys[i],
                         i < 2 ? "the number of cameras"
                               : "the distance between the outer cameras, in scene units");
            return;
        }
    camera->n_views = lf_read_int(reader, grid, "columns", 1, 1, LF_MAX_VIEWS);
    camera->n_rows = lf_read_int(reader, grid, "rows", 1, 1, LF_MAX_CAMERA_ROWS);
    camera->track = lf_read_number(reader, grid, "width", 1, 1e-9, LF_MAX_COORDINATE);
    camera->rows_height = lf_read_number(reader, grid, "height", 1, 0, LF_MAX_COORDINATE);
    camera->own_windows = lf_read_choice(reader, grid, "window", windows, 0);
}

static void parse_track_views(lf_reader *reader, const lf_node *track, lf_scene_desc *out)
{
    parse_track(reader, track, &out->camera);
}

static void parse_grid_views(lf_reader *reader, const lf_node *grid, lf_scene_desc *out)
{
    parse_grid(reader, grid, &out->camera);
}

static void parse_placed_views(lf_reader *reader, const lf_node *views, lf_scene_desc *out)
{
    static const char *const kinds[] = {"track", "grid", "list", "path", "circle", NULL};
    static const lf_camera_list_fn parse[] = {parse_track_views, parse_grid_views,
                                              lf_camera_list_parse, lf_camera_path_parse,
                                              lf_camera_circle_parse};
    int n = 0, kind = 0;
    if (!lf_read_object(reader, views, kinds))
        return;
    for (int i = 0; kinds[i]; i++)
        if (lf_node_child(views, kinds[i]).value) {
            kind = i;
            n++;
        }
    const lf_node instances = lf_node_child(views, kinds[kind]);
    if (n == 1)
        parse[kind](reader, &instances, out);
    else
        lf_read_fail(reader, views,
                     "expected {\"track\": {\"count\": N, \"length\": L}}, {\"grid\": {…}}, "
                     "{\"list\": […]}, {\"path\": {…}} or {\"circle\": {…}}");
}

/* A camera that is fitted later (placing.h); without a position it looks from the front right and a
 * little above. */
static void parse_fit(lf_reader *reader, const lf_node *node, const lf_node *fit, lf_camera *camera)
{
    static const double three_quarters[3] = {0.5, 0.1, 1.0};
    for (int i = 0; i < 3 && !json_is_false(fit->value) && !lf_node_child(node, "position").value;
         i++)
        camera->position[i] = camera->target[i] + three_quarters[i];
    if (json_is_string(fit->value))
        (void)lf_read_string(reader, node, "fit", NULL, LF_MAX_NAME);
    else if (!json_is_boolean(fit->value))
        lf_read_fail(reader, fit, "expected true, false or the name of a mesh or volume");
    if (!json_is_false(fit->value) && lf_node_child(node, "from").value)
        lf_read_fail(reader, fit, "\"fit\" and \"from\" both place the camera; remove one of them");
}

/* The keys of the table; views that are an object, and "fit", are read by themselves. */
static void parse_params(lf_reader *reader, const lf_node *node, lf_scene_desc *out)
{
    const lf_node views = lf_node_child(node, "views"), from = lf_node_child(node, "from"),
                  fit = lf_node_child(node, "fit");
    if (!json_is_object(views.value) && !fit.value) {
        lf_read_params(reader, node, "from", lf_camera_params, &out->camera);
        return;
    }
    lf_node others = *node;
    others.value = json_copy(node->value);
    if (json_is_object(views.value))
        json_object_del(others.value, "views");
    json_object_del(others.value, "fit");
    if (others.value)
        lf_read_params(reader, &others, "from", lf_camera_params, &out->camera);
    else
        reader->status = lf_error_set(reader->err, LF_E_NOMEM, reader->where, "out of memory");
    json_decref(others.value);
    if (fit.value)
        parse_fit(reader, node, &fit, &out->camera);
    if (!json_is_object(views.value))
        return;
    parse_placed_views(reader, &views, out);
    if (fit.value && !json_is_false(fit.value) && (out->camera.list || out->camera.own_windows))
        lf_read_fail(reader, &fit,
                     "needs as \"views\" a number, or a track or grid with \"window\": \"shared\"; "
                     "or give position and target");
    if (out->camera.list && from.value)
        lf_read_fail(reader, &from, "\"from\" cannot be combined with cameras listed one by one");
}

void lf_camera_parse(lf_reader *reader, const lf_node *root, lf_scene_desc *out)
{
    lf_camera *camera = &out->camera;
    const lf_node node = lf_node_child(root, "camera");
    *camera = (lf_camera){0};
    parse_params(reader, &node, out);
    camera->has_aspect = lf_node_child(&node, "aspect").value;
    camera->has_views = lf_node_child(&node, "views").value;
    camera->has_cone = lf_node_child(&node, "cone").value;
    parse_framing(reader, &node, &out->framing);
    if (reader->status == LF_OK && !out->framing.mesh)
        lf_camera_check(reader, root, camera);
}
