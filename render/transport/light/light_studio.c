/* A photo studio: a uniform room, dark below and bright above, with soft boxes. Computed as an
 * environment when the scene is loaded. The camera is assumed to be at +z. */
#include "render/transport/light/light_types.h"

enum { SCALE, ROTATE, VISIBLE };

static const lf_param keys[] = {
    [SCALE] = {.name = "scale",
               .type = LF_PARAM_COLOUR,
               .high = LF_MAX_RADIANCE,
               .point = {1, 1, 1}},
    [ROTATE] = {.name = "rotate", .type = LF_PARAM_ANGLE, .low = -3600, .high = 3600},
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

/* A rectangle at distance 1, perpendicular to the direction of its middle. */
typedef struct soft_box {
    double azimuth, elevation; /* degrees; 0 is towards -z, 90 towards +x */
    double width, height;      /* halves */
    double radiance;
} soft_box;

/* The key light on the left, a strip on the right, two at the back, one above. */
static const soft_box boxes[] = {{-122, 42, 0.36, 0.34, 6.6},
                                 {112, 20, 0.14, 0.62, 1.2},
                                 {-50, 24, 0.14, 0.60, 2.2},
                                 {28, 42, 0.55, 0.20, 2.8},
                                 {150, 72, 0.30, 0.30, 1.2}};

/* Radiance of the room at the floor, horizon and ceiling. */
#define FLOOR 0.10
#define HORIZON 0.17
#define CEILING 0.36
/* Share of a box's half over which it fades at its edge. */
#define EDGE 0.12

static double smooth(double x)
{
    const double t = fmin(fmax(x, 0.0), 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/* Radiance of a box along the unit vector to w, from the direction w. */
static double from_box(const soft_box *box, const double w[3])
{
    const double a = LF_RADIANS(box->azimuth), e = LF_RADIANS(box->elevation);
    const double middle = w[0] * sin(a) * cos(e) + w[1] * sin(e) - w[2] * cos(a) * cos(e),
                 right = w[0] * cos(a) + w[2] * sin(a),
                 up = w[1] * cos(e) - (w[0] * sin(a) - w[2] * cos(a)) * sin(e);
    if (!(middle > 0.0))
        return 0.0;
    return box->radiance * smooth((1.0 - fabs(right / middle) / box->width) / EDGE) *
           smooth((1.0 - fabs(up / middle) / box->height) / EDGE);
}

static double from_room(double height)
{
    return height < 0.0 ? HORIZON + (HORIZON - FLOOR) * height
                        : HORIZON + (CEILING - HORIZON) * height;
}

static void paint(const lf_value values[], int width, int height, float *rgb)
{
    (void)values;
    for (int y = 0; y < height; y++) {
        const double e = (double)LF_PI * (0.5 - (y + 0.5) / height);
        for (int x = 0; x < width; x++) {
            const double a = 2.0 * (double)LF_PI * ((x + 0.5) / width - 0.5),
                         w[3] = {sin(a) * cos(e), sin(e), -cos(a) * cos(e)};
            double light = from_room(w[1]);
            for (size_t i = 0; i < sizeof boxes / sizeof *boxes; i++)
                light += from_box(&boxes[i], w);
            for (int c = 0; c < 3; c++)
                rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] = (float)light;
        }
    }
}

static void read(const lf_value values[], const double origin[3], lf_light *light)
{
    (void)origin;
    light->radiance = lf_to_vec3(values[SCALE].number);
    light->hidden = !values[VISIBLE].on;
    lf_environment_turn(light, values[ROTATE].number[0]);
}

const lf_light_kind lf_light_studio = {
    .name = "studio",
    .keys = keys,
    .paint = paint,
    .unpainted = 1u << SCALE | 1u << ROTATE | 1u << VISIBLE,
    .read = read,
    .draw = lf_environment_draw,
    .power = lf_environment_power,
    .escape = lf_environment_escape,
    .varies = lf_environment_varies,
};
