/* The position of a scene in the window of a rig: its depth, whether it is visible, and camera
 * positions that frame it. */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/nearest.h"
#include "render/bounds.h"
#include "render/plane/rig.h"
#include "render/render.h"
#include "render/scene/vec_double.h"

/* ------------------------------------------------------------------------------------- depth -- */

/* Share of a view's width, and pixels. */
#define LIMIT 0.04
#define LEAST_LIMIT 4.0

/* Where n . p <= d, in camera space. */
typedef struct half_space {
    double n[3], d;
} half_space;

enum { FACES = 6, SIDES = 4, HALF_SPACES = FACES + SIDES };

/* The box, and the pyramid of the window in front of a camera at distance `aside` to the right of
 * the rig's middle. */
static void make_half_spaces(const lf_rig *rig, double aside, const lf_box *box,
                             half_space out[HALF_SPACES])
{
    const lf_vec3 axes[3] = {rig->right, rig->up, rig->forward};
    const float lo[3] = {box->min.x, box->min.y, box->min.z},
                hi[3] = {box->max.x, box->max.y, box->max.z},
                eye[3] = {rig->eye.x, rig->eye.y, rig->eye.z},
                right[3] = {rig->right.x, rig->right.y, rig->right.z};
    double across[2] = {(double)rig->x0 - aside,
                        (double)rig->x0 + rig->width * (double)rig->dx - aside},
           up[2] = {(double)rig->y0 + rig->height * (double)rig->dy, (double)rig->y0},
           distance = (double)rig->distance;
    for (int i = 0; i < 3; i++) {
        half_space *below = &out[2 * i], *above = &out[2 * i + 1];
        for (int a = 0; a < 3; a++) {
            const float axis[3] = {axes[a].x, axes[a].y, axes[a].z};
            below->n[a] = (double)axis[i];
            above->n[a] = -(double)axis[i];
        }
        const double at = (double)eye[i] + aside * (double)right[i];
        below->d = (double)hi[i] - at;
        above->d = at - (double)lo[i];
    }
    for (int i = 0; i < 2; i++) {
        double sign = i == 0 ? -1.0 : 1.0;
        out[FACES + i] = (half_space){{sign, 0.0, -sign * across[i] / distance}, 0.0};
        out[FACES + 2 + i] = (half_space){{0.0, sign, -sign * up[i] / distance}, 0.0};
    }
}

/* The point that three planes share; false: they share none, or many. */
static bool meet(const half_space *a, const half_space *b, const half_space *c, double out[3])
{
    double bc[3], ca[3], ab[3];
    lf_cross_double(b->n, c->n, bc);
    lf_cross_double(c->n, a->n, ca);
    lf_cross_double(a->n, b->n, ab);
    double volume = lf_dot_double(a->n, bc);
    for (int i = 0; i < 3; i++)
        out[i] = (a->d * bc[i] + b->d * ca[i] + c->d * ab[i]) / volume;
    return fabs(volume) > 1e-9;
}

/* The intersection is convex: its nearest and farthest points are among its corners. */
static void see_box(const lf_rig *rig, double aside, const lf_box *box, lf_depth *depth)
{
    half_space sides[HALF_SPACES];
    lf_vec3 size = lf_sub(box->max, box->min);
    double slack = 1e-6 * ((double)lf_max3(size) + (double)rig->distance), p[3];
    make_half_spaces(rig, aside, box, sides);
    for (int i = 0; i < HALF_SPACES; i++)
        for (int j = i + 1; j < HALF_SPACES; j++)
            for (int k = j + 1; k < HALF_SPACES; k++) {
                bool inside = meet(&sides[i], &sides[j], &sides[k], p) && p[2] >= 0.0;
                for (int l = 0; l < HALF_SPACES && inside; l++)
                    inside = lf_dot_double(sides[l].n, p) <= sides[l].d + slack;
                depth->nearest = inside ? fmin(depth->nearest, p[2]) : depth->nearest;
                depth->farthest = inside ? fmax(depth->farthest, p[2]) : depth->farthest;
            }
}

/* Steps of an infinitely far point. */
static double far_step(const lf_rig *rig)
{
    double outer = (double)rig->b[rig->n_views - 1] - (double)rig->b[0];
    return rig->n_views > 1 ? outer / (rig->n_views - 1) / (double)rig->dx : 0.0;
}

/* A ground that the scene marks extends to the horizon, like a sky. */
static bool is_endless(const lf_scene *scene, int thing)
{
    return thing >= scene->n_volumes &&
           scene->meshes[thing - scene->n_volumes].ground == LF_GROUND_SAID;
}

bool lf_scene_depth(const lf_scene *scene, const lf_render_settings *settings, lf_depth *out)
{
    lf_depth depth = {.nearest = INFINITY, .farthest = -INFINITY};
    lf_rig rig;
    if (lf_rig_init(&rig, settings, scene->origin, NULL) != LF_OK || rig.n_views < 2 ||
        rig.still < 1.0f)
        return false;
    for (int i = 0; i < lf_scene_things(scene); i++) {
        lf_box box;
        if (!is_endless(scene, i) && lf_thing_box(scene, i, &box))
            see_box(&rig, 0.0, &box, &depth);
    }
    if (!(depth.nearest <= depth.farthest && depth.farthest > 0.0))
        return false;
    depth.nearest = fabs(depth.nearest); /* no -0 */
    double step = far_step(&rig), distance = (double)rig.distance;
    depth.nearest_step = step * (1.0 - distance / depth.nearest);
    depth.farthest_step = step * (1.0 - distance / depth.farthest);
    depth.limit = fmax(LEAST_LIMIT, LIMIT * settings->width);
    depth.sharp_from = distance * step / (step + depth.limit);
    depth.sharp_to = step > depth.limit ? distance * step / (step - depth.limit) : (double)INFINITY;
    depth.exceeded = settings->camera.view_blur < 1.0 &&
                     fmax(-depth.nearest_step, depth.farthest_step) > depth.limit;
    *out = depth;
    return true;
}

/* -------------------------------------------------------------------------------------- sees -- */

/* The outer cameras, and the middle of the rig. */
static bool sees_box(const lf_rig *rig, const lf_box *box)
{
    const double aside[3] = {0.0, (double)rig->b[0], (double)rig->b[rig->n_views - 1]};
    lf_depth depth = {.nearest = INFINITY, .farthest = -INFINITY};
    for (int i = 0; i < 3 && !(depth.farthest >= 0.0); i++)
        see_box(rig, aside[i], box, &depth);
    return depth.farthest >= 0.0;
}

bool lf_scene_is_seen(const lf_scene *scene, const lf_render_settings *settings)
{
    lf_rig rig;
    bool *left_out = lf_calloc((size_t)lf_scene_things(scene) + 1, sizeof *left_out), any = false,
         seen = false;
    if (left_out && !settings->camera.list && !(settings->camera.track > 0.0) &&
        lf_rig_init(&rig, settings, scene->origin, NULL) == LF_OK) {
        (void)lf_find_grounds(scene, left_out);
        for (int i = 0; i < lf_scene_things(scene) && !seen; i++) {
            lf_box box;
            if (left_out[i] || !lf_thing_box(scene, i, &box))
                continue;
            any = true;
            seen = sees_box(&rig, &box);
        }
    }
    lf_free(left_out);
    return seen || !any;
}

/* --------------------------------------------------------------------------------------- fit -- */

/* The outer cameras of a track or grid, from its middle: across and up. */
static void find_outer(const lf_rig *rig, const lf_camera *camera, double out[2])
{
    const double step =
        camera->n_rows > 1 && !camera->has_parts ? camera->rows_height / (camera->n_rows - 1) : 0.0;
    out[0] = (double)rig->b[rig->n_views - 1] + (double)rig->blur;
    out[1] = 0.5 * (step * (camera->n_rows - 1) + camera->view_blur * step);
}

/* The least D with D (share D + share z - x) >= deep: for cameras whose places do not depend on
 * their distance D. */
static double root(double share, double x, double z, double deep)
{
    const double b = share * z - x;
    return (sqrt(b * b + 4.0 * share * deep) - b) / (2.0 * share);
}

/* Required distance of the cameras from the middle of the box for this corner, at (x, y, z) from it
 * in camera space. For the outer cameras, at b, |X_w| = |x D + z b| / (D + z), and |Y_w| alike,
 * must be within their share of the window's half, and the step within steps. On an arc, b is
 * proportional to D. */
static double distance_for(const lf_rig *rig, const lf_camera *camera, const double corner[3],
                           double fill, double steps)
{
    double distance = (double)rig->distance, z = corner[2],
           across = fill * 0.5 * rig->width * (double)rig->dx / distance,
           up = fill * 0.5 * rig->height * -(double)rig->dy / distance, outer[2], least;
    find_outer(rig, camera, outer);
    if (camera->track > 0.0) {
        least = fmax(root(across, fabs(corner[0]), z, fabs(z) * outer[0]),
                     root(up, fabs(corner[1]), z, fabs(z) * outer[1]));
        if (steps > 0.0)
            least = fmax(least, root(1.0, 0.0, z, fabs(z) * far_step(rig) * distance / steps));
        return least;
    }
    least = (fabs(corner[0]) + outer[0] / distance * fabs(z)) / across - z;
    least = fmax(least, fabs(corner[1]) / up - z);
    if (steps > 0.0)
        least = fmax(least, fabs(z) * far_step(rig) / steps - z);
    return least;
}

/* The camera position for these bounds, in the direction of the current camera. */
static lf_status stand(const lf_scene *scene, const lf_render_settings *settings,
                       const double bounds[2][3], double fill, double steps, double out_target[3],
                       double out_position[3], lf_error *err)
{
    double middle[3], distance = 0.0;
    lf_rig rig;
    lf_status status = lf_rig_init(&rig, settings, scene->origin, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < 3; i++)
        middle[i] = 0.5 * (bounds[0][i] + bounds[1][i]);
    for (int i = 0; i < 8; i++) {
        lf_vec3 p =
            lf_v3((float)(bounds[i & 1][0] - middle[0]), (float)(bounds[i >> 1 & 1][1] - middle[1]),
                  (float)(bounds[i >> 2][2] - middle[2]));
        const double corner[3] = {(double)lf_dot(p, rig.right), (double)lf_dot(p, rig.up),
                                  (double)lf_dot(p, rig.forward)};
        distance = fmax(distance, distance_for(&rig, &settings->camera, corner, fill, steps));
    }
    if (!(distance > 0.0))
        return lf_error_set(err, LF_E_ARG, "fit", "the object to frame has no size");
    const lf_vec3 f = rig.forward;
    const float forward[3] = {f.x, f.y, f.z};
    for (int i = 0; i < 3; i++) {
        out_target[i] = middle[i];
        out_position[i] = middle[i] - distance * (double)forward[i];
    }
    return LF_OK;
}

/* The axis that is nearest to the camera's up. */
static int upward(const lf_camera *camera)
{
    const double *up = camera->up;
    int axis = fabs(up[1]) >= fabs(up[0]) ? 1 : 0;
    return fabs(up[2]) > fabs(up[axis]) ? 2 : axis;
}

/* Whether a ground lies between the framed box and a camera below it. */
static bool is_beneath(const lf_scene *scene, int axis, double sign, const double target[3],
                       const double position[3])
{
    bool *left_out = lf_calloc((size_t)lf_scene_things(scene) + 1, sizeof *left_out), found = false;
    if (left_out && lf_find_grounds(scene, left_out)) {
        for (int i = 0; i < lf_scene_things(scene); i++) {
            lf_box box;
            double side[3];
            if (!left_out[i] || !lf_thing_box(scene, i, &box) || lf_box_sides(&box, side) != axis)
                continue;
            const float lo[3] = {box.min.x, box.min.y, box.min.z},
                        hi[3] = {box.max.x, box.max.y, box.max.z};
            const double top = sign * ((double)(sign > 0 ? hi : lo)[axis] + scene->origin[axis]);
            found = found || (sign * target[axis] >= top && sign * position[axis] < top);
        }
    }
    lf_free(left_out);
    return found;
}

/* No mesh or volume has that name. */
static lf_status refuse_name(const lf_scene *scene, const char *name, lf_error *err)
{
    static const char *const sections[] = {"volumes", "meshes"};
    const size_t room = json_object_size(json_object_get(scene->json, sections[0])) +
                        json_object_size(json_object_get(scene->json, sections[1]));
    const char **names = lf_calloc(room + 1, sizeof *names), *key;
    size_t n = 0;
    json_t *value;
    for (int s = 0; s < 2 && names; s++)
        json_object_foreach(json_object_get(scene->json, sections[s]), key, value) names[n++] = key;
    const char *meant = names ? lf_nearest_name(name, names) : NULL;
    bool is_said = false;
    for (size_t i = 0; i < n; i++)
        is_said = is_said || strcmp(names[i], name) == 0;
    lf_free(names);
    if (is_said)
        return lf_error_set(err, LF_E_ARG, "fit", "\"%s\" has no visible part to frame", name);
    return meant
               ? lf_error_set(err, LF_E_ARG, "fit",
                              "the scene has no mesh or volume \"%s\"; did you mean \"%s\"?", name,
                              meant)
               : lf_error_set(err, LF_E_ARG, "fit", "the scene has no mesh or volume \"%s\"", name);
}

lf_status lf_camera_fit(const lf_scene *scene, const lf_render_settings *settings, const char *name,
                        double fill, double steps, double out_target[3], double out_position[3],
                        lf_error *err)
{
    double bounds[2][3], target[3], position[3];
    const lf_camera *camera = &settings->camera;
    const int axis = upward(camera);
    if (!(fill > 0.0 && fill <= 1.0) || !(steps >= 0.0))
        return lf_error_set(err, LF_E_ARG, "fit", "fill must be above 0 and at most 1");
    if (camera->track > 0.0 && camera->own_windows)
        return lf_error_set(err, LF_E_ARG, "fit",
                            "cameras with windows of their own cannot be fitted to an object; use "
                            "\"window\": \"shared\", or give position and target");
    if (!lf_scene_bounds(scene, name, bounds))
        return name ? refuse_name(scene, name, err)
                    : lf_error_set(err, LF_E_ARG, "fit", "the scene has no object to frame");
    const double(*box)[3] = (const double(*)[3])bounds;
    lf_status status = stand(scene, settings, box, fill, steps, target, position, err);
    if (status == LF_OK &&
        is_beneath(scene, axis, camera->up[axis] < 0.0 ? -1.0 : 1.0, target, position)) {
        lf_render_settings level = *settings;
        level.camera.position[axis] = level.camera.target[axis];
        status = stand(scene, &level, box, fill, steps, target, position, err);
    }
    if (status != LF_OK)
        return status;
    memcpy(out_target, target, sizeof target);
    memcpy(out_position, position, sizeof position);
    return LF_OK;
}
