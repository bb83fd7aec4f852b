/* A rectangle that emits to one side. */
#include "render/scene/vec_double.h"
#include "render/transport/light/light_types.h"

/* Relative to a direction's length: within this distance of +y or -y it counts as vertical. */
#define VERTICAL 1e-6

/* The height direction of a face before rotation: the part of +y perpendicular to the face's
 * direction, or -z. */
static void upright(const double direction[3], double out[3])
{
    double across = hypot(direction[0], direction[2]);
    out[0] = across > VERTICAL ? -direction[1] * direction[0] / across : 0;
    out[1] = across > VERTICAL ? across : 0;
    out[2] = across > VERTICAL ? -direction[1] * direction[2] / across : -1;
}

void lf_light_face(const double position[3], const double direction[3], const double size[2],
                   double angle, lf_affine *out)
{
    double up[3], side[3], thick = sqrt(size[0] * size[1]);
    upright(direction, up);
    lf_cross_double(up, direction, side);
    double c = cos(angle), s = sin(angle);
    for (int i = 0; i < 3; i++) {
        out->m[i][0] = 0.5 * size[0] * (c * side[i] + s * up[i]);
        out->m[i][1] = 0.5 * thick * direction[i];
        out->m[i][2] = 0.5 * size[1] * (s * side[i] - c * up[i]);
        out->m[i][3] = position[i];
    }
}

void lf_light_radiance(const lf_value *radiance, const lf_value *power, double area, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = power->given ? power->number[i] / (M_PI * area) : radiance->number[i];
}

enum { POSITION, DIRECTION, WIDTH, HEIGHT, ROTATE, RADIANCE, POWER, VISIBLE };

static const lf_param keys[] = {
    [POSITION] = {.name = "position", .type = LF_PARAM_POINT, LF_COORDINATES},
    [DIRECTION] = LF_DOWNWARDS_KEY,
    [WIDTH] = LF_LENGTH_KEY("width"),
    [HEIGHT] = LF_LENGTH_KEY("height"),
    [ROTATE] = {.name = "rotate", .type = LF_PARAM_ANGLE, .low = -3600, .high = 3600},
    [RADIANCE] = LF_RADIANCE_KEY,
    [POWER] = LF_POWER_KEY,
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

static void make(const lf_value values[], lf_area_light *out)
{
    const double size[2] = {values[WIDTH].number[0], values[HEIGHT].number[0]};
    lf_light_face(values[POSITION].number, values[DIRECTION].number, size, values[ROTATE].number[0],
                  &out->transform);
    out->area = size[0] * size[1];
    lf_light_radiance(&values[RADIANCE], &values[POWER], out->area, out->radiance);
    out->hidden = !values[VISIBLE].on;
}

const lf_light_kind lf_light_rectangle = {
    .name = "rectangle", .keys = keys, .shape = "quad", .make = make};
