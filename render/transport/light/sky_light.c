#include "render/transport/light/sky_light.h"

#include "render/transport/light/light_kind.h"
#include "render/transport/sampler.h"

/* Directions drawn from each light, and as many uniform ones: a sky image draws none where it is
 * below its mean (light_environment.c). */
enum { DIRECTIONS = 2048 };

/* The real spherical harmonics of order 0, of order 1, and of order 2 for products, for z and for
 * the difference of squares. */
static const float constant = 0.282095f, linear = 0.488603f, mixed = 1.092548f, zonal = 0.315392f,
                   sectoral = 0.546274f;

static void harmonics(lf_vec3 w, float out[LF_SKY_HARMONICS])
{
    out[0] = constant;
    out[1] = linear * w.y;
    out[2] = linear * w.z;
    out[3] = linear * w.x;
    out[4] = mixed * w.x * w.y;
    out[5] = mixed * w.y * w.z;
    out[6] = zonal * (3.0f * w.z * w.z - 1.0f);
    out[7] = mixed * w.x * w.z;
    out[8] = sectoral * (w.x * w.x - w.y * w.y);
}

/* -------------------------------------------------------------------------------- projection -- */

typedef struct projection {
    double sum[LF_SKY_HARMONICS];
} projection;

static void add(projection *p, lf_vec3 w, double light)
{
    float y[LF_SKY_HARMONICS];
    harmonics(w, y);
    for (int i = 0; i < LF_SKY_HARMONICS; i++)
        p->sum[i] += light * (double)y[i];
}

/* Adds the light of a direction, with the balance heuristic of both strategies. */
static void add_found(projection *p, const lf_light *light, lf_vec3 w)
{
    const double even = 0.25 / (double)LF_PI;
    float pdf;
    const double radiance = (double)lf_mean3(light->kind->escape(light, w, &pdf));
    add(p, w, radiance / (DIRECTIONS * ((double)pdf + even)));
}

static lf_vec3 even_direction(const float u[2])
{
    const float z = 1.0f - 2.0f * u[0], r = sqrtf(lf_max(1.0f - z * z, 0.0f)),
                phi = 2.0f * LF_PI * u[1];
    return lf_v3(r * cosf(phi), r * sinf(phi), z);
}

static void add_light(projection *p, const lf_scene *scene, const lf_light *light)
{
    const lf_vec3 middle = lf_v3(0.0f, 0.0f, 0.0f);
    const bool draws = light->kind->power(light, 1.0) > 0.0;
    for (uint32_t i = 0; i < DIRECTIONS; i++) {
        const float u[2] = {((float)(int32_t)i + 0.5f) / DIRECTIONS, lf_sampler_radical(0, i)};
        lf_light_sample drawn = {.delta = false};
        add_found(p, light, even_direction(u));
        if (!draws || !light->kind->draw(scene, light, middle, (double)u[0], u, &drawn))
            continue;
        if (drawn.delta)
            add(p, drawn.wi, (double)lf_mean3(drawn.radiance) / DIRECTIONS);
        else
            add_found(p, light, drawn.wi);
    }
}

void lf_sky_light_init(lf_sky_light *light, const lf_scene *scene)
{
    /* of a clamped cosine over pi, by the order: the paper's equation 8 */
    static const double order[LF_SKY_HARMONICS] = {1.0,  2.0 / 3, 2.0 / 3, 2.0 / 3, 0.25,
                                                   0.25, 0.25,    0.25,    0.25};
    projection p = {{0}};
    for (int i = 0; i < scene->n_lights_infinite; i++)
        add_light(&p, scene, &scene->lights[i]);
    for (int i = 0; i < LF_SKY_HARMONICS; i++)
        light->white[i] = (float)(order[i] * p.sum[i]);
}

/* ---------------------------------------------------------------------------------- look-ups -- */

float lf_sky_light_white(const lf_sky_light *light, lf_vec3 n)
{
    float y[LF_SKY_HARMONICS], sum = 0.0f;
    harmonics(n, y);
    for (int i = 0; i < LF_SKY_HARMONICS; i++)
        sum += light->white[i] * y[i];
    return lf_max(sum, 0.0f);
}

float lf_sky_light_mean(const lf_sky_light *light)
{
    return light->white[0] * constant;
}
