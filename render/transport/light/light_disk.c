/* A disk that emits to one side. */
#include "render/transport/light/light_types.h"

enum { POSITION, DIRECTION, RADIUS, RADIANCE, POWER, VISIBLE };

static const lf_param keys[] = {
    [POSITION] = {.name = "position", .type = LF_PARAM_POINT, LF_COORDINATES},
    [DIRECTION] = LF_DOWNWARDS_KEY,
    [RADIUS] = LF_LENGTH_KEY("radius"),
    [RADIANCE] = LF_RADIANCE_KEY,
    [POWER] = LF_POWER_KEY,
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

static void make(const lf_value values[], lf_area_light *out)
{
    const double radius = values[RADIUS].number[0], size[2] = {2 * radius, 2 * radius};
    lf_light_face(values[POSITION].number, values[DIRECTION].number, size, 0, &out->transform);
    out->area = M_PI * radius * radius;
    lf_light_radiance(&values[RADIANCE], &values[POWER], out->area, out->radiance);
    out->hidden = !values[VISIBLE].on;
}

const lf_light_kind lf_light_disk = {.name = "disk", .keys = keys, .shape = "disk", .make = make};
