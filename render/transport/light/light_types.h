/* Code shared by kinds of lights; private to render/transport/light*.c. */
#ifndef LF_RENDER_LIGHT_TYPES_H
#define LF_RENDER_LIGHT_TYPES_H

#include "render/scene/vec_double.h"
#include "render/transport/light/light_kind.h"

/* Key of lights that a camera can see: "visible"; read stores it in light->hidden. */
#define LF_VISIBLE_KEY                                                                             \
    {                                                                                              \
        .name = "visible", .type = LF_PARAM_SWITCH, .initial = 1                                   \
    }

/* Direction of emission; default down. */
#define LF_DOWNWARDS_KEY                                                                           \
    {                                                                                              \
        .name = "direction", .type = LF_PARAM_DIRECTION, LF_COORDINATES, .point = { 0, -1, 0 }     \
    }

/* Lights at infinity. */

/* Functions of kinds with an environment image; light->radiance is its factor. */
bool lf_environment_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place,
                         const float u[2], lf_light_sample *out);
double lf_environment_power(const lf_light *light, double radius);
lf_vec3 lf_environment_escape(const lf_light *light, lf_vec3 w, float *out_pdf);
bool lf_environment_varies(const lf_light *light);
/* Sets light->to_environment: the middle of the image is towards -z, rotated by angle about +y. */
void lf_environment_turn(lf_light *light, double angle);

/* The texel of a direction in the scene, by rows. */
uint32_t lf_environment_texel(const lf_light *light, lf_vec3 w);
/* A direction in the scene; across and along in [0, 1): even over the texel. */
lf_vec3 lf_environment_direction(const lf_light *light, uint32_t texel, float across, float along);
/* The solid angle of each texel of a row. */
double lf_environment_texel_angle(const lf_environment *e, int row);

/* Half the width of a disk's rim, in versine. */
float lf_disk_ramp(const lf_light *light);

/* Area lights. */

/* Keys for a length, and for the emission: radiance or power. */
#define LF_LENGTH_KEY(key)                                                                         \
    {                                                                                              \
        .name = key, .type = LF_PARAM_NUMBER, .low = 1e-9, .high = LF_MAX_COORDINATE, .initial = 1 \
    }
#define LF_RADIANCE_KEY                                                                            \
    {                                                                                              \
        .name = "radiance", .type = LF_PARAM_COLOUR, .form = 1, .high = LF_MAX_RADIANCE            \
    }
#define LF_POWER_KEY                                                                               \
    {                                                                                              \
        .name = "power", .type = LF_PARAM_COLOUR, .form = 2, .high = LF_MAX_RADIANCE,              \
        .watts = true                                                                              \
    }

/* The radiance of a light of this area that emits uniformly to one side; power gives power / (pi
 * area). */
void lf_light_radiance(const lf_value *radiance, const lf_value *power, double area, double out[3]);

/* Maps [-1,1]^2 of the xz plane to a face around position that looks along direction (unit), with
 * +y to the front. size[0] is the width along x, size[1] the height along -z. The height axis is as
 * vertical as the face allows; for a face that looks up or down it is the scene's -z. Then the face
 * is rotated by angle from x towards -z, about direction. */
void lf_light_face(const double position[3], const double direction[3], const double size[2],
                   double angle, lf_affine *out);

/* Point lights. */

/* From world coordinates of the scene file to scene-local ones. */
static inline lf_vec3 lf_light_place(const double world[3], const double origin[3])
{
    double local[3];
    lf_sub_double(world, origin, local);
    return lf_to_vec3(local);
}

/* Draws the point, with the light's full intensity. */
static inline bool lf_light_draw_point(const lf_light *light, lf_vec3 p, lf_light_sample *out)
{
    lf_vec3 d = lf_sub(light->position, p);
    float distance2 = lf_dot(d, d), distance = sqrtf(distance2);
    if (!(distance2 > 1e-30f))
        return false;
    *out = (lf_light_sample){.wi = lf_scale(d, 1.0f / distance),
                             .distance = distance,
                             .point = light->position,
                             .radiance = lf_scale(light->intensity, 1.0f / distance2),
                             .pdf = 1.0f,
                             .delta = true};
    return true;
}

/* Extent of a point light: the point, and 0. */
void lf_light_point_extent(const lf_scene *scene, const lf_light *light, lf_vec3 *out_middle,
                           float *out_radius);

/* Mesh lights. */

/* Chooses one of a mesh light's triangles by area, place in [0, 1); *out_probability: its
 * probability. */
uint32_t lf_mesh_light_choose(const lf_light *light, double place, float *out_probability);
/* Appends a light for every pair of a mesh and an emissive material on it. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_mesh_lights_append(lf_scene *scene);

/* Tables of probabilities. */

/* A cumulative value rounded to the grid of the random numbers, so that the probability of an entry
 * is exactly its difference. */
static inline float lf_cumulative_round(double x)
{
    return (float)(nearbyint(x * 0x1p24) * 0x1p-24);
}

/* The entry i of n with cdf[i] <= u < cdf[i + 1], for u in [0, 1) and cdf[n] = 1. *remainder (may
 * point to u's own variable) becomes the position of u in it, in [0, 1). */
static inline int lf_cdf_find(const float *cdf, int n, float u, float *remainder)
{
    int first = 0, count = n;
    while (count > 1) {
        int half = count / 2;
        bool above = cdf[first + half] <= u;
        first = above ? first + half : first;
        count = above ? count - half : half;
    }
    *remainder = lf_min((u - cdf[first]) / (cdf[first + 1] - cdf[first]), 0x1.fffffep-1f);
    return first;
}

#endif
