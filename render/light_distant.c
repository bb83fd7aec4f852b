/* A light at infinity: a direction, or a disk of constant radiance. How far w is from the middle of the disk is measured as
 * |w - c|^2 = 2 (1 - cos): the cosine itself has two digits left at the size of the sun. */
#include "render/light_types.h"

static float solid_angle(const lf_light *light)
{
    return 2.0f * LF_PI * (1.0f - light->cos_angle);
}

/* Projected solid angle of the disk seen face on: pi sin^2. */
void lf_distant_commit(lf_light *light)
{
    float projected = LF_PI * (1.0f - light->cos_angle) * (1.0f + light->cos_angle);
    light->radiance = projected > 0.0f ? lf_scale(light->irradiance, 1.0f / projected) : lf_v3(0.0f, 0.0f, 0.0f);
}

lf_vec3 lf_distant_escape(const lf_light *light, lf_vec3 w, float *out_pdf)
{
    lf_vec3 d = lf_add(w, light->direction);
    bool inside = lf_dot(d, d) < 2.0f * (1.0f - light->cos_angle);
    *out_pdf = inside ? 1.0f / solid_angle(light) : 0.0f;
    return inside ? light->radiance : lf_v3(0.0f, 0.0f, 0.0f);
}

bool lf_distant_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2], lf_light_sample *out)
{
    (void)scene, (void)p, (void)place;
    lf_vec3 axis = lf_scale(light->direction, -1.0f), t, b;
    if (!(light->cos_angle < 1.0f)) {
        *out = (lf_light_sample){.wi = axis, .distance = INFINITY, .radiance = light->irradiance, .pdf = 1.0f, .delta = true};
        return true;
    }
    float m = u[0] * (1.0f - light->cos_angle), sine = sqrtf(m * (2.0f - m)), phi = 2.0f * LF_PI * u[1];
    lf_frame(axis, &t, &b);
    out->wi = lf_from_frame(t, b, axis, lf_v3(sine * cosf(phi), sine * sinf(phi), 1.0f - m));
    return true;
}

double lf_distant_power(const lf_light *light, double radius)
{
    return (double)LF_PI * radius * radius * (double)lf_mean3(light->irradiance);
}
