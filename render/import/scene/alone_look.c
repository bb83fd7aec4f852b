#include "render/import/scene/alone_look.h"

/* So much of the studio's light that white paint keeps its shapes. */
#define WHITE_KEPT 0.82

/* Its soft boxes are placed for a camera at +z, and turn with it. */
static json_t *light_studio(double yaw)
{
    return json_pack("{s:{s:s, s:f, s:f, s:b}}", "studio", "type", "studio", "rotate", yaw, "scale",
                     WHITE_KEPT, "visible", 0);
}

/* A sun and an even sky, of which volumes are quick to show. */
static json_t *light_day(double yaw)
{
    (void)yaw;
    return json_pack("{s:{s:s, s:[f,f,f], s:b}, s:{s:s, s:[f,f,f], s:[f,f,f], s:f}}", "sky", "type",
                     "environment", "radiance", 0.25, 0.33, 0.45, "visible", 0, "sun", "type",
                     "distant", "direction", 0.6, -1.0, -0.5, "irradiance", 4.0, 3.7, 3.3, "angle",
                     0.5);
}

static json_t *light_night(double yaw)
{
    (void)yaw;
    return json_pack("{s:{s:s, s:[f,f,f], s:b}}", "night", "type", "environment", "radiance", 0.1,
                     0.12, 0.17, "visible", 0);
}

/* Far away, with the angular size of a studio light. */
static json_t *make_lamp(double x, double y, double z, double irradiance, double angle)
{
    return json_pack("{s:s, s:[f,f,f], s:f, s:f}", "type", "distant", "direction", x, y, z,
                     "irradiance", irradiance, "angle", angle);
}

/* A large light on the left in front of it, one on the right behind it, and a room that is bright
 * above. */
static json_t *light_bare(double yaw)
{
    (void)yaw;
    return json_pack("{s:o, s:o, s:{s:s, s:f, s:f, s:b, s:f, s:b}}", "front",
                     make_lamp(1.6, -1.5, -1.8, 2.4, 26.0), "back",
                     make_lamp(-1.8, -1.2, 1.5, 2.4, 17.0), "room", "type", "sky", "elevation",
                     50.0, "azimuth", -40.0, "sun", 0, "scale", 0.004, "visible", 0);
}

static const struct {
    json_t *(*lights)(double yaw);
    double top[3], bottom[3]; /* of the backdrop */
    const char *tonemap;
} looks[] = {
    [LF_ALONE_STUDIO] = {light_studio, {0.27, 0.28, 0.3}, {0.58, 0.575, 0.565}, "neutral"},
    [LF_ALONE_DAY] = {light_day, {0.07, 0.16, 0.38}, {0.36, 0.47, 0.62}, "filmic"},
    [LF_ALONE_NIGHT] = {light_night, {0.012, 0.016, 0.028}, {0.07, 0.066, 0.062}, "aces"},
    [LF_ALONE_BARE_MESH] = {light_bare, {0.05, 0.06, 0.08}, {0.2, 0.2, 0.2}, "filmic"},
    [LF_ALONE_BARE_VOLUME] = {light_day, {0.05, 0.06, 0.08}, {0.2, 0.2, 0.2}, "filmic"},
};

bool lf_alone_light(json_t *document, lf_alone_look look, double yaw)
{
    const double *top = looks[look].top, *bottom = looks[look].bottom;
    json_t *rest =
        json_pack("{s:o, s:{s:s}, s:{s:[f,f,f], s:[f,f,f]}}", "lights", looks[look].lights(yaw),
                  "film", "tonemap", looks[look].tonemap, "backdrop", "top", top[0], top[1], top[2],
                  "bottom", bottom[0], bottom[1], bottom[2]);
    const bool done = rest && json_object_update(document, rest) == 0;
    json_decref(rest);
    return done;
}
