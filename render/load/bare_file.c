#include "render/load/bare_file.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/frame_name.h"
#include "render/load/member_read.h"
#include "render/load/scene_parse.h"
#include "render/scene/scene.h"
#include "render/scene/vec_double.h"

/* Optical thickness of the densest part, if all of the volume's box were as dense: smoke and clouds
 * are that in little of it. */
#define THICKNESS 40.0

bool lf_is_bare_file(const char *path)
{
    return lf_is_file_of(path, lf_mesh_endings) || lf_is_file_of(path, lf_volume_endings);
}

#define MOST_FRAMES 10000

/* -1: there is none, or the name has no place for a number. */
static int largest_frame(const char *path)
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

json_t *lf_bare_document(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const bool is_volume = lf_is_file_of(path, lf_volume_endings);
    const int frame = largest_frame(path);
    json_t *document =
        json_pack("{s:i, s:{s:{s:s}}}", "quiltd", 1, is_volume ? "volumes" : "meshes",
                  is_volume ? "volume" : "model", "file", name);
    if (frame >= 0)
        json_object_set_new(document, "frame", json_integer(frame));
    return document;
}

/* Whether the front shows nothing but the edge of something flat. */
static bool is_flat_across(const lf_scene *scene)
{
    double bounds[2][3], size[3];
    if (!lf_scene_bounds(scene, NULL, bounds))
        return false;
    lf_sub_double(bounds[1], bounds[0], size);
    return size[0] < 1e-3 * fmin(size[1], size[2]);
}

/* From the front and a little above; what is flat from its right. */
static json_t *make_camera(const lf_scene *scene)
{
    lf_render_settings settings = {.camera = *lf_scene_camera(scene), .width = 420, .height = 560};
    lf_camera *camera = &settings.camera;
    double *to = camera->target, *from = camera->position;
    camera->cone = LF_RADIANS(35.0);
    for (int i = 0; i < 3; i++)
        camera->target[i] = 0.0;
    const bool flat = is_flat_across(scene);
    from[0] = flat ? 1.0 : 0.0;
    from[1] = 0.16;
    from[2] = flat ? 0.0 : 1.0;
    if (lf_camera_fit(scene, &settings, NULL, LF_CAMERA_FILL, 0.0, to, from, NULL) != LF_OK)
        return json_object();
    return json_pack("{s:[f,f,f], s:[f,f,f], s:f}", "target", to[0], to[1], to[2], "position",
                     from[0], from[1], from[2], "cone", 35.0);
}

/* From far away, as wide as a lamp of a studio. */
static json_t *make_lamp(double x, double y, double z, double irradiance, double angle)
{
    return json_pack("{s:s, s:[f,f,f], s:f, s:f}", "type", "distant", "direction", x, y, z,
                     "irradiance", irradiance, "angle", angle);
}

/* As a photographer's: a large lamp before it at the left, one behind it at the right, and a room
 * that is bright above. Lamps that are faces would be meshes, so that the file were read again. */
static json_t *make_studio(void)
{
    return json_pack("{s:o, s:o, s:{s:s, s:f, s:f, s:b, s:f, s:b}}", "front",
                     make_lamp(1.6, -1.5, -1.8, 2.4, 26.0), "back",
                     make_lamp(-1.8, -1.2, 1.5, 2.4, 17.0), "room", "type", "sky", "elevation",
                     50.0, "azimuth", -40.0, "sun", false, "scale", 0.004, "visible", false);
}

/* A sun and an even sky, of which volumes are quick to show. */
static json_t *make_day(void)
{
    return json_pack("{s:{s:s, s:[f,f,f], s:b}, s:{s:s, s:[f,f,f], s:[f,f,f], s:f}}", "sky", "type",
                     "environment", "radiance", 0.25, 0.33, 0.45, "visible", false, "sun", "type",
                     "distant", "direction", 0.6, -1.0, -0.5, "irradiance", 4.0, 3.7, 3.3, "angle",
                     0.5);
}

/* Grids have all kinds of units. */
static bool scale_density(json_t *document, const lf_scene *scene)
{
    json_t *volume = json_object_get(json_object_get(document, "volumes"), "volume");
    double bounds[2][3], across[3];
    if (!lf_scene_bounds(scene, NULL, bounds))
        return true;
    lf_sub_double(bounds[1], bounds[0], across);
    const double thickness = lf_length_double(across) * (double)scene->volumes[0].sigma_max;
    return !(thickness > 0.0) ||
           json_object_set_new(volume, "scale", json_real(fmin(THICKNESS / thickness, 1e9))) == 0;
}

bool lf_bare_furnish(json_t *document, const lf_scene *scene)
{
    const bool is_volume = json_object_get(document, "volumes");
    json_t *rest =
        json_pack("{s:o, s:o, s:{s:s}, s:{s:[f,f,f], s:[f,f,f]}}", "camera", make_camera(scene),
                  "lights", is_volume ? make_day() : make_studio(), "film", "tonemap", "filmic",
                  "backdrop", "top", 0.05, 0.06, 0.08, "bottom", 0.2, 0.2, 0.2);
    const bool done = rest && json_object_update(document, rest) == 0 &&
                      (!is_volume || scale_density(document, scene));
    json_decref(rest);
    return done;
}
