/* A sphere that emits outwards. */
#include "render/transport/light/light_types.h"

enum { POSITION, RADIUS, RADIANCE, POWER, VISIBLE };

static const lf_param keys[] = {
    [POSITION] = {.name = "position", .type = LF_PARAM_POINT, LF_COORDINATES},
    [RADIUS] = LF_LENGTH_KEY("radius"),
    [RADIANCE] = LF_RADIANCE_KEY,
    [POWER] = LF_POWER_KEY,
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

static void make(const lf_value values[], lf_area_light *out)
{
    const double radius = values[RADIUS].number[0];
    out->transform = lf_affine_identity();
    for (int i = 0; i < 3; i++) {
        out->transform.m[i][i] = radius;
        out->transform.m[i][3] = values[POSITION].number[i];
    }
    out->area = 4 * M_PI * radius * radius;
    lf_light_radiance(&values[RADIANCE], &values[POWER], out->area, out->radiance);
    out->hidden = !values[VISIBLE].on;
}

const lf_light_kind lf_light_sphere = {
    .name = "sphere", .keys = keys, .shape = "sphere", .make = make};
