#include "daemon/output/hld.h"

#include <math.h>

#define WIDTH 2160.0
#define HEIGHT 3840.0
#define TOP 355.0
#define BOTTOM 100.0
#define SIDE 108.0

/* The bounds of a box rotating about its vertical axis. */
typedef struct turned {
    double centre[3], radius, half_height;
} turned;

static turned box_of(double b[2][3])
{
    turned t;
    for (int i = 0; i < 3; i++)
        t.centre[i] = 0.5 * (b[0][i] + b[1][i]);
    t.radius = 0.5 * hypot(b[1][0] - b[0][0], b[1][2] - b[0][2]);
    t.half_height = 0.5 * (b[1][1] - b[0][1]);
    return t;
}

/* Moves the camera, without changing its direction, so that the box stays inside the margins.
 * focused: also set the focus distance. */
static json_t *framed(const lf_camera *camera, const turned *t, bool focused)
{
    double d[3], length = 0.0, half = tan(0.5 * camera->fov_y);
    for (int i = 0; i < 3; i++) {
        d[i] = camera->position[i] - camera->target[i];
        length += d[i] * d[i];
    }
    length = sqrt(length);
    const double rise = fabs(d[1]) / length, level = sqrt(fmax(1.0 - rise * rise, 1e-6)),
                 wide = (1.0 - 2.0 * SIDE / WIDTH) * half * WIDTH / HEIGHT,
                 high = (1.0 - (TOP + BOTTOM) / HEIGHT) * half,
                 across = t->half_height * level + t->radius * rise,
                 away = t->radius * level + t->half_height * rise +
                        fmax(t->radius / wide, across / high),
                 lower = (TOP - BOTTOM) / HEIGHT * away * half / level;
    json_t *moved =
        json_pack("{s:[f,f,f], s:[f,f,f]}", "target", t->centre[0], t->centre[1] + lower,
                  t->centre[2], "position", t->centre[0] + d[0] / length * away,
                  t->centre[1] + d[1] / length * away + lower, t->centre[2] + d[2] / length * away);
    if (moved && focused && json_object_set_new(moved, "focus_distance", json_real(away)) != 0) {
        json_decref(moved);
        return NULL;
    }
    return moved;
}

static json_t *ground(const turned *t)
{
    const double size = 20.0 * fmax(t->radius, t->half_height);
    return json_pack("{s:{s:s, s:b, s:{s:f, s:[f,f,f]}}}", "hld ground", "shape", "quad", "catcher",
                     1, "transform", "scale", size, "translate", t->centre[0],
                     t->centre[1] - t->half_height, t->centre[2]);
}

lf_status lf_hld_patch(const lf_scene *scene, double exposure, bool frames, json_t **out_patch,
                       lf_error *err)
{
    double bounds[2][3];
    if (!lf_scene_bounds(scene, NULL, bounds) ||
        !(hypot(hypot(bounds[1][0] - bounds[0][0], bounds[1][1] - bounds[0][1]),
                bounds[1][2] - bounds[0][2]) > 0.0))
        return lf_error_set(err, LF_E_STATE, "--preset hld",
                            "the scene has nothing to show; add a mesh or a volume");
    const turned t = box_of(bounds);
    json_t *patch = json_pack("{s:f, s:{s:s, s:f}}", "backdrop", exp2(-exposure), "film", "tonemap",
                              "srgb", "exposure", exposure);
    bool good = patch;
    if (good && !lf_scene_has_catchers(scene))
        good = json_object_set_new(patch, "meshes", ground(&t)) == 0;
    if (good && frames) {
        const json_t *camera = json_object_get(lf_scene_json(scene), "camera");
        good = json_object_set_new(patch, "camera",
                                   framed(lf_scene_camera(scene), &t,
                                          json_object_get(camera, "focus_distance"))) == 0;
    }
    if (!good)
        json_decref(patch);
    *out_patch = good ? patch : NULL;
    return LF_OK;
}
