#include "render/import/scene/file_alone.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/frame_name.h"
#include "render/import/scene/alone_look.h"
#include "render/import/scene/member_read.h"
#include "render/import/scene/scene_parse.h"
#include "render/scene/geometry.h"
#include "render/scene/scene.h"
#include "render/scene/vec_double.h"

/* Degrees: from a little to the right of the front, and from above. */
#define YAW 22.0
#define PITCH 13.0
/* An object thinner than this share of its other extents is shown from its broad side: turned by a
 * quarter if its edge faces the camera, from high above if it is lying. */
#define EDGE_ON 0.35
#define LYING 0.08
#define PITCH_LYING 45.0
#define CONE 35.0
#define FILL 0.96
/* Assumed aspect of the window for a camera of the file: a Portrait panel. */
#define ASPECT 0.75

/* A camera of the file is used if the object fills at least this share of its window. */
#define FILE_CAMERA_SHARE 0.75

/* Optical thickness of the densest part, as if the whole box were that dense; smoke and clouds are
 * as dense only in small parts. */
#define THICKNESS 40.0
/* Grids with a larger maximum are in kelvin; others are scaled to HOT there. */
#define KELVIN 500.0
#define HOT 2300.0

static const char *up_at(int index)
{
    static const char *const words[] = {"file", "y", "z"};
    return index <= LF_UP_Z ? words[index] : NULL;
}

/* clang-format off */
const lf_param lf_alone_params[] = {
    {.name = "yaw", .option = "yaw", .argument = "DEGREES", .place = offsetof(lf_alone, yaw),
     .has = offsetof(lf_alone, has_yaw), .low = -360, .high = 360, .unit = "degrees",
     .help = "file without a scene: how far the eye is to the right of the front (22)",
     .about = "file without a scene: how far the eye is to the right of the front (as on the "
              "command line, else 22)"},
    {.name = "pitch", .option = "pitch", .argument = "DEGREES", .place = offsetof(lf_alone, pitch),
     .has = offsetof(lf_alone, has_pitch), .low = -89, .high = 89, .unit = "degrees",
     .help = "file without a scene: how far the eye is above the front (13)",
     .about = "file without a scene: how far the eye is above the front (as on the command "
              "line, else 13)"},
    {.name = "up", .option = "up", .argument = "file|y|z", .place = offsetof(lf_alone, up),
     .type = LF_PARAM_WORD, .word_at = up_at,
     .help = "without a scene: up axis; file: z in STL, else y",
     .about = "file without a scene: its up axis; file: z in STL files, else y"},
    {.name = "bare", .option = "bare", .place = offsetof(lf_alone, bare), .type = LF_PARAM_SWITCH,
     .help = "without a scene: dark backdrop, no ground, no studio; of volumes the density grid "
             "alone",
     .about = "file without a scene: dark backdrop, no ground, no studio; of a volume the "
              "density grid alone"},
    {0},
};
/* clang-format on */

const char *lf_alone_kind(const char *path)
{
    if (lf_is_file_of(path, lf_mesh_endings))
        return "model";
    return lf_is_file_of(path, lf_volume_endings) ? "volume" : NULL;
}

bool lf_is_file_alone(const char *path)
{
    return lf_alone_kind(path);
}

#define MOST_FRAMES 10000

int lf_alone_frame(const char *path)
{
    off_t most = 0;
    int best = -1;
    for (int n = 0; n < MOST_FRAMES && lf_frame_name_varies(path); n++) {
        struct stat file;
        char *name = lf_frame_name(path, n);
        if (name && stat(name, &file) == 0 && file.st_size > most) {
            most = file.st_size;
            best = n;
        }
        lf_free(name);
    }
    return best;
}

char *lf_alone_file(const char *path, int frame)
{
    return frame < 0 ? lf_strdup(path) : lf_frame_name(path, frame);
}

/* --------------------------------------------------------------------------------- its grids -- */

static const char *const burning[] = {"flames",      "flame", "fire", "heat",
                                      "temperature", "burn",  NULL};
static const char *const smoking[] = {"density", "smoke", "fog", "cloud", "soot", NULL};

/* The first of the names that matches a line of grids, as written in that line; out[512] is "" if
 * there is none. */
static void find_grid(const char *grids, const char *const *names, char out[512])
{
    out[0] = '\0';
    for (int i = 0; names[i] && !out[0]; i++)
        for (const char *line = grids; *line; line += strcspn(line, "\n"), line += *line != '\0') {
            const size_t n = strcspn(line, "\n"),
                         plain = n - (n > 3 && !strncmp(line + n - 3, "[0]", 3) ? 3 : 0);
            if (!out[0] && plain == strlen(names[i]) && strncasecmp(line, names[i], plain) == 0)
                snprintf(out, 512, "%.*s", (int)plain, line);
        }
}

/* The only grid, with any name. */
static void find_only(const char *grids, char out[512])
{
    const size_t n = strcspn(grids, "\n");
    if (n > 0 && strlen(grids) <= n + 1)
        snprintf(out, 512, "%.*s", (int)n, grids);
}

/* Smoke from one grid, and fire from another; fire alone has no smoke. */
static json_t *make_volume(const char *name, const char *grids)
{
    char smoke[512], fire[512];
    find_grid(grids, smoking, smoke);
    find_grid(grids, burning, fire);
    if (!smoke[0] && !fire[0])
        find_only(grids, smoke);
    json_t *volume = json_pack("{s:s}", "file", name);
    if (smoke[0] || fire[0])
        json_object_set_new(volume, "grid", json_string(smoke[0] ? smoke : fire));
    if (fire[0])
        json_object_set_new(volume, "emission", json_pack("{s:s}", "grid", fire));
    if (fire[0] && !smoke[0])
        json_object_set_new(volume, "scale", json_integer(0));
    return volume;
}

/* ------------------------------------------------------------------------------ the document -- */

/* Files for printers are drawn with z up, by custom; all others are taken as y up. */
static bool is_z_up(const char *path, const lf_alone *how)
{
    return how->up == LF_UP_Z ||
           (how->up == LF_UP_OF_FILE && !how->bare && lf_path_has_ending(path, ".stl"));
}

json_t *lf_alone_document(const char *path, int frame, const lf_alone *how, const char *grids)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const bool is_volume = lf_is_file_of(path, lf_volume_endings);
    json_t *object =
        is_volume && !how->bare ? make_volume(name, grids) : json_pack("{s:s}", "file", name);
    json_t *document = json_pack("{s:i, s:{s:O}}", "quiltd", 1, is_volume ? "volumes" : "meshes",
                                 is_volume ? "volume" : "model", object);
    if (is_z_up(path, how))
        json_object_set_new(object, "transform",
                            json_pack("{s:[f,f,f]}", "rotate", -90.0, 0.0, 0.0));
    json_decref(object);
    if (document && frame >= 0)
        json_object_set_new(document, "frame", json_integer(frame));
    if (document && !how->bare) {
        json_t *ground = json_pack("{s:{s:s, s:b, s:b, s:s}}", "ground", "shape", "quad", "ground",
                                   1, "catcher", 1, "material", "ground");
        json_t *meshes = json_object_get(document, "meshes");
        if (meshes)
            json_object_update(meshes, ground);
        else
            json_object_set(document, "meshes", ground);
        json_decref(ground);
        json_object_set_new(document, "materials", json_pack("{s:{s:f}}", "ground", "albedo", 0.6));
    }
    return document;
}

/* -------------------------------------------------------------------------------- its camera -- */

static bool find_size(const lf_scene *scene, double bounds[2][3], double size[3])
{
    if (!lf_scene_bounds(scene, NULL, bounds))
        return false;
    lf_sub_double(bounds[1], bounds[0], size);
    return true;
}

/* Whether the front view shows only the edge of a flat object. */
static bool is_flat_across(const lf_scene *scene)
{
    double bounds[2][3], size[3];
    return find_size(scene, bounds, size) && size[0] < 1e-3 * fmin(size[1], size[2]);
}

/* Direction of the camera around the object, in degrees. */
static void choose_angles(const lf_scene *scene, const lf_alone *how, double *yaw, double *pitch)
{
    double bounds[2][3], size[3];
    *yaw = YAW;
    *pitch = PITCH;
    if (find_size(scene, bounds, size)) {
        if (size[1] < LYING * fmin(size[0], size[2]))
            *pitch = PITCH_LYING;
        else if (size[0] < EDGE_ON * size[2])
            *yaw += 90.0;
    }
    if (how->has_yaw)
        *yaw = how->yaw;
    if (how->has_pitch)
        *pitch = how->pitch;
}

static json_t *stand(const lf_scene *scene, const double from[3], double fill)
{
    lf_render_settings settings = {.camera = *lf_scene_camera(scene), .width = 420, .height = 560};
    lf_camera *camera = &settings.camera;
    double *to = camera->target;
    camera->cone = LF_RADIANS(CONE);
    for (int i = 0; i < 3; i++) {
        to[i] = 0.0;
        camera->position[i] = from[i];
    }
    if (lf_camera_fit(scene, &settings, NULL, fill, 0.0, to, camera->position, NULL) != LF_OK)
        return json_object();
    const double *at = camera->position;
    return json_pack("{s:[f,f,f], s:[f,f,f], s:f}", "target", to[0], to[1], to[2], "position",
                     at[0], at[1], at[2], "cone", CONE);
}

/* From the front and a little above; flat objects from the right. */
static json_t *make_bare_camera(const lf_scene *scene)
{
    const bool flat = is_flat_across(scene);
    const double from[3] = {flat ? 1.0 : 0.0, 0.16, flat ? 0.0 : 1.0};
    return stand(scene, from, LF_CAMERA_FILL);
}

static json_t *make_turned_camera(const lf_scene *scene, double yaw, double pitch)
{
    const double y = LF_RADIANS(yaw), p = LF_RADIANS(pitch),
                 from[3] = {sin(y) * cos(p), sin(p), cos(y) * cos(p)};
    return stand(scene, from, FILL);
}

/* The larger of the shares of the window's height and width that a box fills; 0: part of it is
 * outside, or behind the camera. *depth: of the box's middle along the axis. */
static double share_of_window(const lf_file_camera *camera, const double bounds[2][3],
                              double *depth)
{
    double across[2] = {1.0, -1.0}, up[2] = {1.0, -1.0}, nearest = INFINITY, farthest = 0.0,
           right[3];
    lf_cross_double(camera->look, camera->up, right);
    for (int corner = 0; corner < 8; corner++) {
        double d[3];
        for (int i = 0; i < 3; i++)
            d[i] = bounds[corner >> i & 1][i] - camera->position[i];
        const double z = lf_dot_double(d, camera->look), half = z * tan(0.5 * camera->fov_y),
                     x = lf_dot_double(d, right) / (half * ASPECT),
                     y = lf_dot_double(d, camera->up) / half;
        if (!(z > 0.0 && fabs(x) <= 1.0 && fabs(y) <= 1.0))
            return 0.0;
        across[0] = fmin(across[0], x);
        across[1] = fmax(across[1], x);
        up[0] = fmin(up[0], y);
        up[1] = fmax(up[1], y);
        nearest = fmin(nearest, z);
        farthest = fmax(farthest, z);
    }
    *depth = 0.5 * (nearest + farthest);
    return 0.5 * fmax(across[1] - across[0], up[1] - up[0]);
}

/* The file's first camera, if the whole object is in its window, and large enough; else NULL, also
 * without memory. *yaw: degrees from +z to the right. */
static json_t *make_file_camera(const lf_scene *scene, double *yaw)
{
    const lf_geometry *geometry = scene->geometry;
    double bounds[2][3], depth = 0.0;
    if (!geometry || geometry->n_meshes < 1 || !lf_scene_bounds(scene, "model", bounds))
        return NULL;
    const lf_file_cameras *cameras = &geometry->cameras[0];
    if (cameras->n < 1 || cameras->open[0].parallel ||
        share_of_window(&cameras->open[0], (const double(*)[3])bounds, &depth) < FILE_CAMERA_SHARE)
        return NULL;
    const double *look = cameras->open[0].look;
    *yaw = atan2(-look[0], -look[2]) * 180.0 / (double)LF_PI;
    return json_pack("{s:{s:s, s:i, s:f}, s:f}", "from", "mesh", "model", "camera",
                     cameras->open[0].number, "distance", depth, "cone", CONE);
}

/* ----------------------------------------------------------------------------------- volumes -- */

/* Grids have all kinds of units. */
static void scale_density(json_t *volume, const lf_volume *grid, double across)
{
    const double thickness = across * (double)grid->sigma_max;
    if (thickness > 0.0)
        json_object_set_new(volume, "scale", json_real(fmin(THICKNESS / thickness, 1e9)));
}

/* As bright as a lit surface, seen through a fifth of its box. */
static void scale_heat(json_t *emission, const lf_volume *grid, double across)
{
    const double most = (double)grid->sigma_max;
    if (!(most > 0.0 && across > 0.0))
        return;
    json_object_set_new(emission, "temperature_scale", json_real(most > KELVIN ? 1.0 : HOT / most));
    json_object_set_new(emission, "scale", json_real(fmin(24.0 / across, 1e9)));
}

static void scale_volume(json_t *volume, const lf_scene *scene)
{
    double bounds[2][3], size[3];
    json_t *emission = json_object_get(volume, "emission");
    if (!find_size(scene, bounds, size) || scene->n_volumes < 1)
        return;
    const double across = lf_length_double(size);
    if (!json_object_get(volume, "scale"))
        scale_density(volume, &scene->volumes[0], across);
    if (emission && scene->emissive.n > 0)
        scale_heat(emission, &scene->emissive.field[0], across);
}

/* ---------------------------------------------------------------------------------- together -- */

static lf_alone_look choose_look(const json_t *volume, const lf_alone *how)
{
    if (how->bare)
        return volume ? LF_ALONE_BARE_VOLUME : LF_ALONE_BARE_MESH;
    if (!volume)
        return LF_ALONE_STUDIO;
    return json_object_get(volume, "emission") ? LF_ALONE_NIGHT : LF_ALONE_DAY;
}

bool lf_alone_furnish(json_t *document, const lf_alone *how, const lf_scene *scene)
{
    json_t *volume = json_object_get(json_object_get(document, "volumes"), "volume"),
           *camera = NULL;
    const bool is_turned = how->has_yaw || how->has_pitch;
    double yaw = 0.0, pitch = 0.0;
    choose_angles(scene, how, &yaw, &pitch);
    if (volume)
        scale_volume(volume, scene);
    if (how->bare && !is_turned)
        camera = make_bare_camera(scene);
    else if (!is_turned)
        camera = make_file_camera(scene, &yaw);
    if (!camera)
        camera = make_turned_camera(scene, yaw, pitch);
    if (!how->bare) /* placed already: the same in every frame */
        json_object_set(json_object_get(document, "meshes"), "ground",
                        json_object_get(json_object_get(lf_scene_json(scene), "meshes"), "ground"));
    return camera && json_object_set_new(document, "camera", camera) == 0 &&
           lf_alone_light(document, choose_look(volume, how), yaw);
}
