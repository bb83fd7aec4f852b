/* How a scene lies in the window of a rig: its bounds, its depth, and where to stand. */
#include <math.h>
#include <string.h>

#include "render/render.h"
#include "render/rows/rig.h"
#include "render/scene/vec_double.h"

/* ------------------------------------------------------------------------------------ bounds -- */

static bool is_there(const lf_box *box)
{
    return box->min.x <= box->max.x;
}

static void grow_by_volume(const lf_volume *volume, lf_box *box)
{
    if (!(volume->sigma_max > 0.0f))
        return;
    box->min =
        lf_v3(lf_min(box->min.x, volume->bounds_min.x), lf_min(box->min.y, volume->bounds_min.y),
              lf_min(box->min.z, volume->bounds_min.z));
    box->max =
        lf_v3(lf_max(box->max.x, volume->bounds_max.x), lf_max(box->max.y, volume->bounds_max.y),
              lf_max(box->max.z, volume->bounds_max.z));
}

/* The box of the i-th thing: volumes with what they emit, then meshes. Volumes that are empty and
 * meshes that the camera does not see have none. */
static lf_box box_at(const lf_scene *scene, int i)
{
    lf_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    if (i >= scene->n_volumes) {
        const lf_mesh *mesh = &scene->meshes[i - scene->n_volumes];
        return mesh->hidden ? box : mesh->box;
    }
    grow_by_volume(&scene->volumes[i], &box);
    for (int f = 0; f < scene->flames.n; f++)
        if (scene->flames.light[f].volume == i)
            grow_by_volume(&scene->flames.field[f], &box);
    return box;
}

static void grow(const lf_scene *scene, const lf_box *box, double bounds[2][3])
{
    const float lo[3] = {box->min.x, box->min.y, box->min.z},
                hi[3] = {box->max.x, box->max.y, box->max.z};
    for (int i = 0; i < 3 && is_there(box); i++) {
        bounds[0][i] = fmin(bounds[0][i], (double)lo[i] + scene->origin[i]);
        bounds[1][i] = fmax(bounds[1][i], (double)hi[i] + scene->origin[i]);
    }
}

/* Volumes and meshes are in the order of the document; lights that are faces come behind them. */
static void grow_by_section(const lf_scene *scene, const char *section, int first, const char *name,
                            double bounds[2][3])
{
    const char *key;
    json_t *value;
    json_object_foreach(json_object_get(scene->json, section), key, value)
    {
        lf_box box = box_at(scene, first++);
        if (!name || strcmp(key, name) == 0)
            grow(scene, &box, bounds);
    }
}

bool lf_scene_bounds(const lf_scene *scene, const char *name, double out_bounds[2][3])
{
    double bounds[2][3];
    for (int i = 0; i < 3; i++) {
        bounds[0][i] = INFINITY;
        bounds[1][i] = -INFINITY;
    }
    grow_by_section(scene, "volumes", 0, name, bounds);
    grow_by_section(scene, "meshes", scene->n_volumes, name, bounds);
    if (!(bounds[0][0] <= bounds[1][0]))
        return false;
    memcpy(out_bounds, bounds, sizeof bounds);
    return true;
}

/* ------------------------------------------------------------------------------------- depth -- */

/* Share of a view's width, and pixels. */
#define LIMIT 0.04
#define LEAST_LIMIT 4.0

/* Where n . p <= d, in camera space. */
typedef struct half_space {
    double n[3], d;
} half_space;

enum { FACES = 6, SIDES = 4, HALF_SPACES = FACES + SIDES };

/* The box, and the pyramid of the window before the middle of the rig. */
static void make_half_spaces(const lf_rig *rig, const lf_box *box, half_space out[HALF_SPACES])
{
    const lf_vec3 axes[3] = {rig->right, rig->up, rig->forward};
    const float lo[3] = {box->min.x, box->min.y, box->min.z},
                hi[3] = {box->max.x, box->max.y, box->max.z},
                eye[3] = {rig->eye.x, rig->eye.y, rig->eye.z};
    double across[2] = {(double)rig->x0, (double)rig->x0 + rig->width * (double)rig->dx},
           up[2] = {(double)rig->y0 + rig->height * (double)rig->dy, (double)rig->y0},
           distance = (double)rig->distance;
    for (int i = 0; i < 3; i++) {
        half_space *below = &out[2 * i], *above = &out[2 * i + 1];
        for (int a = 0; a < 3; a++) {
            const float axis[3] = {axes[a].x, axes[a].y, axes[a].z};
            below->n[a] = (double)axis[i];
            above->n[a] = -(double)axis[i];
        }
        below->d = (double)hi[i] - (double)eye[i];
        above->d = (double)eye[i] - (double)lo[i];
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

/* What both hold is convex: its nearest and farthest points are among its corners. */
static void see_box(const lf_rig *rig, const lf_box *box, lf_depth *depth)
{
    half_space sides[HALF_SPACES];
    lf_vec3 size = lf_sub(box->max, box->min);
    double slack = 1e-6 * ((double)lf_max3(size) + (double)rig->distance), p[3];
    make_half_spaces(rig, box, sides);
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

bool lf_scene_depth(const lf_scene *scene, const lf_render_settings *settings, lf_depth *out)
{
    lf_depth depth = {.nearest = INFINITY, .farthest = -INFINITY};
    lf_rig rig;
    if (lf_rig_init(&rig, settings, scene->origin, NULL) != LF_OK || rig.n_views < 2 ||
        rig.still < 1.0f)
        return false;
    for (int i = 0; i < scene->n_volumes + scene->n_meshes; i++) {
        lf_box box = box_at(scene, i);
        if (is_there(&box))
            see_box(&rig, &box, &depth);
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

/* --------------------------------------------------------------------------------------- fit -- */

/* How far from the middle of the box the cameras must be for this corner, which lies (x, y, z) from
 * it in camera space: |X_w| = D |x + z b/D| / (D + z), for the outer cameras, and |Y_w| within
 * their share of the window's half, and the step within steps. */
static double distance_for(const lf_rig *rig, const double corner[3], double fill, double steps)
{
    double distance = (double)rig->distance, z = corner[2],
           outer = ((double)rig->b[rig->n_views - 1] + (double)rig->blur) / distance,
           across = fill * 0.5 * rig->width * (double)rig->dx / distance,
           up = fill * 0.5 * rig->height * -(double)rig->dy / distance;
    double least = (fabs(corner[0]) + outer * fabs(z)) / across - z;
    least = fmax(least, fabs(corner[1]) / up - z);
    if (steps > 0.0)
        least = fmax(least, fabs(z) * far_step(rig) / steps - z);
    return least;
}

lf_status lf_camera_fit(const lf_scene *scene, const lf_render_settings *settings, const char *name,
                        double fill, double steps, double out_target[3], double out_position[3],
                        lf_error *err)
{
    double bounds[2][3], middle[3], distance = 0.0;
    lf_rig rig;
    if (!(fill > 0.0 && fill <= 1.0) || !(steps >= 0.0))
        return lf_error_set(err, LF_E_ARG, "fit", "fill must be above 0 and at most 1");
    if (settings->camera.track > 0.0)
        return lf_error_set(err, LF_E_ARG, "fit",
                            "camera.views is a track: its cameras see what they pass");
    lf_status status = lf_rig_init(&rig, settings, scene->origin, err);
    if (status != LF_OK)
        return status;
    if (!lf_scene_bounds(scene, name, bounds))
        return lf_error_set(err, LF_E_ARG, "fit",
                            name ? "no mesh or volume \"%s\" is there"
                                 : "nothing is there that could be framed%s",
                            name ? name : "");
    for (int i = 0; i < 3; i++)
        middle[i] = 0.5 * (bounds[0][i] + bounds[1][i]);
    for (int i = 0; i < 8; i++) {
        lf_vec3 p =
            lf_v3((float)(bounds[i & 1][0] - middle[0]), (float)(bounds[i >> 1 & 1][1] - middle[1]),
                  (float)(bounds[i >> 2][2] - middle[2]));
        const double corner[3] = {(double)lf_dot(p, rig.right), (double)lf_dot(p, rig.up),
                                  (double)lf_dot(p, rig.forward)};
        distance = fmax(distance, distance_for(&rig, corner, fill, steps));
    }
    if (!(distance > 0.0))
        return lf_error_set(err, LF_E_ARG, "fit", "what is to be framed has no size");
    const lf_vec3 f = rig.forward;
    const float forward[3] = {f.x, f.y, f.z};
    for (int i = 0; i < 3; i++) {
        out_target[i] = middle[i];
        out_position[i] = middle[i] - distance * (double)forward[i];
    }
    return LF_OK;
}
