/* A light at infinity: a direction, or a disk of constant radiance. Angles are measured by the
 * versine, 1 - cos, which keeps its digits for small angles: it is half of the squared chord from w
 * to the middle of the disk.
 *
 * Directions in single precision lie on a lattice of 6e-8, 1/15 of the radius of the smallest disk.
 * Within that distance of the rim it is undefined whether a direction is inside, and counting
 * lattice points would make the area of a small disk random. So the rim is a ramp, linear in the
 * versine and as wide as the rounding of directions. Its mean is the disk's, so that area and
 * energy are kept, and the sum of a smooth function over a lattice is as good as the integral. */
#include "render/scene/vec_double.h"
#include "render/transport/light/light_types.h"

/* Half of the ramp, radians: what a direction may be off after a reflection. */
#define BLUR 2.5e-7f

/* Versine of half of 1e-4 degrees; smaller disks count as this. */
#define LEAST_VERSINE 3.8077e-13f

static float solid_angle(const lf_light *light)
{
    return 2.0f * LF_PI * light->versine;
}

/* Projected solid angle of the disk seen face on: pi sin^2. */
static void commit(lf_light *light)
{
    light->versine = light->versine > 0.0f ? lf_max(light->versine, LEAST_VERSINE) : 0.0f;
    float projected = LF_PI * light->versine * (2.0f - light->versine);
    light->radiance =
        projected > 0.0f ? lf_scale(light->irradiance, 1.0f / projected) : lf_v3(0.0f, 0.0f, 0.0f);
}

float lf_disk_ramp(const lf_light *light)
{
    return BLUR * sqrtf(2.0f * light->versine);
}

/* Fraction of the disk's radiance along w. The difference from the middle is exact; only its part
 * perpendicular to the middle is used, because neither vector has length 1 to the last digit. */
static float coverage(const lf_light *light, lf_vec3 w)
{
    lf_vec3 d = lf_add(w, light->direction), across = lf_cross(d, light->direction);
    float cosine = -lf_dot(w, light->direction);
    if (!(light->versine > 0.0f && cosine > 0.0f))
        return 0.0f;
    float versine = lf_dot(across, across) / (1.0f + cosine), ramp = lf_disk_ramp(light);
    return lf_min(lf_max(0.5f + (light->versine - versine) / (2.0f * ramp), 0.0f), 1.0f);
}

static lf_vec3 escape(const lf_light *light, lf_vec3 w, float *out_pdf)
{
    float share = coverage(light, w);
    *out_pdf = share > 0.0f ? share / solid_angle(light) : 0.0f;
    return lf_scale(light->radiance, share);
}

static bool draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                 const float u[2], lf_light_sample *out)
{
    (void)scene, (void)p, (void)place;
    lf_vec3 axis = lf_scale(light->direction, -1.0f), t, b;
    if (!(light->versine > 0.0f)) {
        *out = (lf_light_sample){.wi = axis,
                                 .distance = INFINITY,
                                 .radiance = light->irradiance,
                                 .pdf = 1.0f,
                                 .delta = true};
        return true;
    }
    float m = u[0] * light->versine, sine = sqrtf(m * (2.0f - m)), phi = 2.0f * LF_PI * u[1];
    lf_tangents(axis, &t, &b);
    out->wi = lf_from_frame(t, b, axis, lf_v3(sine * cosf(phi), sine * sinf(phi), 1.0f - m));
    return true;
}

static double power(const lf_light *light, double radius)
{
    return (double)LF_PI * radius * radius * (double)lf_mean3(light->irradiance);
}

static bool varies(const lf_light *light)
{
    return light->versine > 0.0f;
}

/* ------------------------------------------------------------------------------- light paths -- */

static bool emit(const lf_scene *scene, const lf_light *light, const lf_emitter_square *square,
                 const float u[6], lf_emitted *out)
{
    float area;
    lf_light_sample towards;
    const lf_vec3 at = lf_emitter_square_draw(square, u, &out->cell, &area);
    if (!draw(scene, light, at, 0.0, u + 3, &towards))
        return false;
    out->w = lf_scale(towards.wi, -1.0f);
    out->p = lf_madd(at, 4.0f * square->half, towards.wi);
    out->flux = light->versine > 0.0f
                    ? lf_scale(light->radiance,
                               area * solid_angle(light) * lf_dot(out->w, light->direction))
                    : lf_scale(light->irradiance, area);
    return true;
}

static float emit_density(const lf_scene *scene, const lf_light *light,
                          const lf_emitter_square *square, lf_vec3 p, const lf_light_end *end)
{
    (void)scene;
    const float per_area = lf_emitter_square_density(square, p, end->wi);
    return light->versine > 0.0f ? per_area / solid_angle(light) : per_area;
}

/* ---------------------------------------------------------------------------------- its keys -- */

enum { DIRECTION, IRRADIANCE, ANGLE, VISIBLE };

static const lf_param keys[] = {
    [DIRECTION] = {.name = "direction",
                   .type = LF_PARAM_DIRECTION,
                   LF_COORDINATES,
                   .point = {0, -1, 0}},
    [IRRADIANCE] = {.name = "irradiance",
                    .type = LF_PARAM_COLOUR,
                    .high = LF_MAX_RADIANCE,
                    .point = {1, 1, 1}},
    [ANGLE] = {.name = "angle", .type = LF_PARAM_ANGLE, .high = 90},
    [VISIBLE] = LF_VISIBLE_KEY,
    {0},
};

void lf_distant_say(const double direction[3], const double irradiance[3], double angle,
                    bool visible, lf_value out[])
{
    for (int i = 0; i < 3; i++) {
        out[DIRECTION].number[i] = direction[i];
        out[IRRADIANCE].number[i] = irradiance[i];
    }
    out[ANGLE].number[0] = angle;
    out[VISIBLE].on = visible;
}

static void read(const lf_value values[], const double origin[3], lf_light *light)
{
    (void)origin;
    light->direction = lf_to_vec3(values[DIRECTION].number);
    light->irradiance = lf_to_vec3(values[IRRADIANCE].number);
    light->hidden = !values[VISIBLE].on;
    light->versine = (float)(2.0 * pow(sin(0.25 * values[ANGLE].number[0]), 2.0));
}

const lf_light_kind lf_light_distant = {
    .name = "distant",
    .keys = keys,
    .read = read,
    .commit = commit,
    .draw = draw,
    .power = power,
    .escape = escape,
    .varies = varies,
    .emit = emit,
    .emit_density = emit_density,
};
