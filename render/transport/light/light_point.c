#include "render/transport/light/light_types.h"

static bool draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                 const float u[2], lf_light_sample *out)
{
    (void)scene, (void)place, (void)u;
    return lf_light_draw_point(light, p, out);
}

static double power(const lf_light *light, double radius)
{
    (void)radius;
    return 4.0 * (double)LF_PI * (double)lf_mean3(light->intensity);
}

static bool emit(const lf_scene *scene, const lf_light *light, const lf_emitter_square *square,
                 const float u[6], lf_emitted *out)
{
    (void)scene, (void)square;
    const float z = 1.0f - 2.0f * u[3], r = sqrtf(lf_max(1.0f - z * z, 0.0f)),
                phi = 2.0f * LF_PI * u[4];
    out->p = light->position;
    out->w = lf_v3(r * cosf(phi), r * sinf(phi), z);
    out->flux = lf_scale(light->intensity, 4.0f * LF_PI);
    return true;
}

static float emit_density(const lf_scene *scene, const lf_light *light,
                          const lf_emitter_square *square, lf_vec3 p, const lf_light_end *end)
{
    (void)scene, (void)light, (void)square, (void)p;
    return LF_INV_4PI / (end->distance * end->distance);
}

void lf_light_point_extent(const lf_scene *scene, const lf_light *light, lf_vec3 *out_middle,
                           float *out_radius)
{
    (void)scene;
    *out_middle = light->position;
    *out_radius = 0.0f;
}

enum { POSITION, INTENSITY };

static const lf_param keys[] = {
    [POSITION] = {.name = "position", .type = LF_PARAM_POINT, LF_COORDINATES},
    [INTENSITY] = {.name = "intensity",
                   .watts = true,
                   .type = LF_PARAM_COLOUR,
                   .high = LF_MAX_RADIANCE,
                   .point = {1, 1, 1}},
    {0},
};

void lf_point_say(const double position[3], const double intensity[3], lf_value out[])
{
    for (int i = 0; i < 3; i++) {
        out[POSITION].number[i] = position[i];
        out[INTENSITY].number[i] = intensity[i];
    }
}

static void read(const lf_value values[], const double origin[3], lf_light *light)
{
    light->position = lf_light_place(values[POSITION].number, origin);
    light->intensity = lf_to_vec3(values[INTENSITY].number);
}

const lf_light_kind lf_light_point = {
    .name = "point",
    .keys = keys,
    .read = read,
    .draw = draw,
    .power = power,
    .extent = lf_light_point_extent,
    .emit = emit,
    .emit_density = emit_density,
};
