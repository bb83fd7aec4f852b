#include "render/layers/caught.h"

#include <math.h>

#include "render/transport/sampler.h"

/* Reflections use separate random numbers, so that shadows do not depend on them. */
#define REFLECTIONS ((uint64_t)1 << 32)

int lf_catch_points(double native)
{
    return (int)fmin(fmax(native, LF_CATCH_LEAST), LF_CATCH_MOST);
}

lf_catch_pixel lf_catch_pixel_of(const lf_renderer *renderer, const lf_rig *rig, int view, int row,
                                 int column)
{
    const lf_render_settings *settings = &renderer->settings;
    return (lf_catch_pixel){
        rig, settings->seed, lf_max_depth(renderer->scene, settings->max_depth), view, row, column};
}

uint64_t lf_catch_key(const lf_catch_pixel *p)
{
    return lf_hash64(p->seed, (uint64_t)(unsigned)p->row << 40 | (uint64_t)(unsigned)p->view << 32 |
                                  (unsigned)p->column);
}

lf_catch_ray lf_catch_ray_of(const lf_catch_pixel *p, uint64_t key, int i)
{
    const lf_rig *rig = p->rig;
    lf_sampler sampler;
    lf_catch_ray ray;
    float film[2];
    lf_sampler_init(&sampler, LF_SAMPLER_OWEN, key, (uint32_t)i);
    lf_sampler_2d(&sampler, film);
    lf_sampler_2d(&sampler, ray.u + 1);
    lf_sampler_2d(&sampler, ray.u + 3);
    ray.u[0] = lf_sampler_1d(&sampler);
    ray.x = (float)p->column + film[0];
    float y = rig->y0 + ((float)p->row + film[1]) * rig->dy;
    ray.eye = lf_rig_point(rig, rig->b[p->view], 0.0f, 0.0f);
    ray.w = lf_rig_direction(rig, lf_rig_slope(rig, p->view, ray.x), y / rig->distance, 1.0f);
    return ray;
}

float lf_catch_open(const lf_scene *scene, double met)
{
    return scene->n_volumes > 0 ? 1.0f : (float)fmin(fmax(1.0 - met, 0.0), 1.0);
}

double lf_catch_met(const lf_film *film, int row, size_t pixel)
{
    double n[2] = {film->rows[row].n[0], film->rows[row].n[1]};
    if (film->rows[row].provisional)
        lf_film_row_known(&film->rows[row], n);
    double met = 0.0;
    for (int h = 0; h < 2; h++)
        met += n[h] > 0.0 ? n[h] * (double)lf_film_at(film, row, h).q[pixel] : 0.0;
    return met / fmax(n[0] + n[1], 1e-30);
}

double lf_catch_shade(lf_tracer *tracer, const lf_catch_pixel *pixel, int n, float open)
{
    const uint64_t key = lf_catch_key(pixel);
    double light[2] = {0.0, 0.0};
    double caught = 0.0;
    tracer->rng = lf_hash64(key, 1);
    for (int i = 0; i < n; i++) {
        const lf_catch_ray ray = lf_catch_ray_of(pixel, key, i);
        lf_hit hit;
        float passed;
        lf_trace_caught(tracer, ray.eye, ray.w, &hit, &passed);
        if (!(passed > 0.0f))
            continue;
        lf_catcher_light(tracer, &hit, ray.u, light);
        caught += (double)passed;
    }
    return light[1] > 0.0 ? fmax(1.0 - light[0] / light[1], 0.0) * fmin(caught / n, (double)open)
                          : 0.0;
}

lf_vec3 lf_catch_reflected(lf_tracer *tracer, const lf_catch_pixel *pixel, uint64_t key, int i,
                           const lf_catch_ray *ray, const lf_hit *hit, float passed)
{
    tracer->rng = lf_hash64(key, REFLECTIONS + (uint64_t)i);
    lf_vec3 r = lf_scale(
        lf_catcher_reflection(tracer, hit, lf_normalize(ray->w), ray->u + 1, pixel->max_depth),
        passed);
    return isfinite(r.x + r.y + r.z) ? r : lf_v3(0.0f, 0.0f, 0.0f);
}

lf_vec3 lf_catch_reflection(lf_tracer *tracer, const lf_catch_pixel *pixel, int n)
{
    const uint64_t key = lf_catch_key(pixel);
    double sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < n; i++) {
        const lf_catch_ray ray = lf_catch_ray_of(pixel, key, i);
        lf_hit hit;
        float passed;
        tracer->rng = lf_hash64(key, 1 + (uint64_t)i);
        lf_trace_caught(tracer, ray.eye, ray.w, &hit, &passed);
        if (!(passed > 0.0f) || !hit.mesh->reflects)
            continue;
        const lf_vec3 r = lf_catch_reflected(tracer, pixel, key, i, &ray, &hit, passed);
        sum[0] += (double)r.x;
        sum[1] += (double)r.y;
        sum[2] += (double)r.z;
    }
    return lf_v3((float)(sum[0] / n), (float)(sum[1] / n), (float)(sum[2] / n));
}

lf_vec3 lf_catch_behind(const lf_scene *scene, const lf_rig *rig, int row)
{
    const float y = rig->y0 + ((float)row + 0.5f) * rig->dy;
    return lf_backdrop_at(&scene->backdrop, lf_rig_height_between(rig, y / rig->distance));
}
