#include "render/light_types.h"

bool lf_point_draw(const lf_scene *scene, const lf_light *light, lf_vec3 p, double place, const float u[2], lf_light_sample *out)
{
    (void)scene, (void)place, (void)u;
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

double lf_point_power(const lf_light *light, double radius)
{
    (void)radius;
    return 4.0 * (double)LF_PI * (double)lf_mean3(light->intensity);
}
