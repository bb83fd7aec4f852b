/* A point that emits into a cone: full intensity around the axis, and a smooth falloff to 0 at the
 * rim, by 3 t^2 - 2 t^3 of the versine (light_distant.c) between the two. Half of the rim's solid
 * angle counts as full intensity, so the power is pi intensity (inner + outer versine). */
#include "render/transport/light/light_types.h"

/* Fraction of the intensity along the unit vector w. */
static float falloff(const lf_light *light, lf_vec3 w)
{
    lf_vec3 off_axis = lf_sub(w, light->direction);
    float versine = 0.5f * lf_dot(off_axis, off_axis), inner = light->own.spot.inner;
    if (versine <= inner)
        return 1.0f;
    if (versine >= light->versine)
        return 0.0f;
    float t = (light->versine - versine) / (light->versine - inner);
    return t * t * (3.0f - 2.0f * t);
}

static bool draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                 const float u[2], lf_light_sample *out)
{
    (void)scene, (void)place, (void)u;
    if (!lf_light_draw_point(light, p, out))
        return false;
    float share = falloff(light, lf_scale(out->wi, -1.0f));
    out->radiance = lf_scale(out->radiance, share);
    return share > 0.0f;
}

static bool emit(const lf_scene *scene, const lf_light *light, const lf_emitter_square *square,
                 const float u[6], lf_emitted *out)
{
    (void)scene, (void)square;
    const float m = u[3] * light->versine, sine = sqrtf(m * (2.0f - m)), phi = 2.0f * LF_PI * u[4];
    lf_vec3 t, b;
    lf_tangents(light->direction, &t, &b);
    out->p = light->position;
    out->w =
        lf_from_frame(t, b, light->direction, lf_v3(sine * cosf(phi), sine * sinf(phi), 1.0f - m));
    out->flux = lf_scale(light->intensity, 2.0f * LF_PI * light->versine * falloff(light, out->w));
    return true;
}

static float emit_density(const lf_scene *scene, const lf_light *light,
                          const lf_emitter_square *square, lf_vec3 p, const lf_light_end *end)
{
    (void)scene, (void)square, (void)p;
    return 1.0f / (2.0f * LF_PI * light->versine * end->distance * end->distance);
}

static double power(const lf_light *light, double radius)
{
    (void)radius;
    return (double)LF_PI * ((double)light->own.spot.inner + (double)light->versine) *
           (double)lf_mean3(light->intensity);
}

enum { POSITION, DIRECTION, INTENSITY, ANGLE, BLEND };

static const lf_param keys[] = {
    [POSITION] = {.name = "position", .type = LF_PARAM_POINT, LF_COORDINATES},
    [DIRECTION] = LF_DOWNWARDS_KEY,
    [INTENSITY] = {.name = "intensity",
                   .watts = true,
                   .type = LF_PARAM_COLOUR,
                   .high = LF_MAX_RADIANCE,
                   .point = {1, 1, 1}},
    [ANGLE] = {.name = "angle", .type = LF_PARAM_ANGLE, .low = 0.1, .high = 180, .initial = 45},
    [BLEND] = {.name = "blend", .type = LF_PARAM_NUMBER, .high = 1, .initial = 0.15},
    {0},
};

void lf_spot_say(const double position[3], const double direction[3], const double intensity[3],
                 double angle, double blend, lf_value out[])
{
    for (int i = 0; i < 3; i++) {
        out[POSITION].number[i] = position[i];
        out[DIRECTION].number[i] = direction[i];
        out[INTENSITY].number[i] = intensity[i];
    }
    out[ANGLE].number[0] = angle;
    out[BLEND].number[0] = blend;
}

static double versine_of(double angle)
{
    return 2.0 * pow(sin(0.5 * angle), 2.0);
}

static void read(const lf_value values[], const double origin[3], lf_light *light)
{
    double half = 0.5 * values[ANGLE].number[0];
    light->position = lf_light_place(values[POSITION].number, origin);
    light->direction = lf_to_vec3(values[DIRECTION].number);
    light->intensity = lf_to_vec3(values[INTENSITY].number);
    light->versine = (float)versine_of(half);
    light->own.spot.inner = (float)versine_of(half * (1.0 - values[BLEND].number[0]));
}

const lf_light_kind lf_light_spot = {
    .name = "spot",
    .keys = keys,
    .read = read,
    .draw = draw,
    .power = power,
    .extent = lf_light_point_extent,
    .emit = emit,
    .emit_density = emit_density,
};
