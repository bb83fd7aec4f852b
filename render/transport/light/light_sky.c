/* A daylight sky (daylight.h), computed as an environment when the scene is loaded, and its sun, an
 * additional distant light. The image has the sun in its middle and is rotated to the sun's
 * direction. */
#include "render/transport/light/daylight.h"
#include "render/transport/light/light_types.h"

enum { ELEVATION, AZIMUTH, TURBIDITY, SUN, GROUND, SCALE, VISIBLE };

static const lf_param keys[] = {
    [ELEVATION] = {.name = "elevation", .type = LF_PARAM_ANGLE, .high = 90, .initial = 45},
    [AZIMUTH] = {.name = "azimuth", .type = LF_PARAM_ANGLE, .low = -3600, .high = 3600},
    [TURBIDITY] = {.name = "turbidity",
                   .type = LF_PARAM_NUMBER,
                   .low = LF_LEAST_TURBIDITY,
                   .high = LF_MOST_TURBIDITY,
                   .initial = 3},
    [SUN] = {.name = "sun", .type = LF_PARAM_SWITCH, .initial = 1},
    [GROUND] = {.name = "ground", .type = LF_PARAM_COLOUR, .high = 1, .point = {0.2, 0.2, 0.2}},
    [SCALE] = {.name = "scale",
               .type = LF_PARAM_COLOUR,
               .high = LF_MAX_RADIANCE,
               .point = {1, 1, 1}},
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

/* 0 if there is none. */
static void sun_of(const lf_value values[], double out[3])
{
    lf_daylight_sun(values[TURBIDITY].number[0], values[ELEVATION].number[0], out);
    for (int i = 0; i < 3; i++)
        out[i] = values[SUN].on ? out[i] : 0.0;
}

static void paint(const lf_value values[], int width, int height, float *rgb)
{
    lf_daylight sky;
    double sun[3];
    lf_daylight_init(&sky, values[TURBIDITY].number[0], values[ELEVATION].number[0]);
    sun_of(values, sun);
    lf_daylight_paint(&sky, values[GROUND].number, sun, width, height, rgb);
}

static const lf_light_kind *companion(const lf_value values[], lf_value out[])
{
    double elevation = values[ELEVATION].number[0], azimuth = values[AZIMUTH].number[0], sun[3];
    const double direction[3] = {-cos(elevation) * sin(azimuth), -sin(elevation),
                                 cos(elevation) * cos(azimuth)};
    if (!values[SUN].on)
        return NULL;
    sun_of(values, sun);
    for (int i = 0; i < 3; i++)
        sun[i] *= values[SCALE].number[i];
    lf_distant_say(direction, sun, LF_RADIANS(LF_SUN_ANGLE), values[VISIBLE].on, out);
    return &lf_light_distant;
}

static void read(const lf_value values[], const double origin[3], lf_light *light)
{
    (void)origin;
    light->radiance = lf_to_vec3(values[SCALE].number);
    light->hidden = !values[VISIBLE].on;
    lf_environment_turn(light, -values[AZIMUTH].number[0]);
}

const lf_light_kind lf_light_sky = {
    .name = "sky",
    .keys = keys,
    .companion = companion,
    .paint = paint,
    .unpainted = 1u << AZIMUTH | 1u << SCALE | 1u << VISIBLE,
    .read = read,
    .draw = lf_environment_draw,
    .power = lf_environment_power,
    .escape = lf_environment_escape,
    .varies = lf_environment_varies,
};
