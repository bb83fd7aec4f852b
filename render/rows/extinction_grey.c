/* One density for all channels. */
#include "render/rows/extinction.h"

static void depths(const lf_visit *visit, int medium)
{
    lf_scratch *w = visit->worker;
    const lf_rays rays = lf_visit_rays(visit, 0, lf_rig_lanes(visit->rig));
    lf_media_depths(&w->media, &rays, w->tau, medium, w->sigma);
}

static float densities(const lf_visit *visit, const lf_pivot *pivot)
{
    lf_scratch *w = visit->worker;
    const int n = lf_rig_lanes(visit->rig);
    (void)pivot;
    return w->media.n_here > 0 ? visit->kernels->densities(n, w->scale, w->tau, w->density)
                               : visit->kernels->fans->densities(n, w->scale, w->density);
}

static void weigh(const lf_visit *visit, const float *factor)
{
    lf_scratch *w = visit->worker;
    for (int k = 0; k < lf_rig_lanes(visit->rig); k++)
        w->density[k] *= factor[k];
}

static void spread(lf_visit *visit, lf_vec3 y, float scale)
{
    lf_scratch *w = visit->worker;
    const lf_film_scattered one = {{y.x, y.y, y.z}, 1.0f};
    const lf_film_sums sums = visit->sums; /* this copy is only read */
    const int views = visit->rig->n_views;
    int64_t received = 0;
    for (int k = 0; k < views; k++) {
        float weight = w->density[k] * scale;
        if (weight == 0.0f)
            continue;
        lf_film_add_times(&sums, lf_visit_pixel(visit, k), weight, &one);
        received++;
    }
    w->contributions += received;
}

static float own(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                 const float *factor, lf_vec3 *out_channels)
{
    (void)visit, (void)pivot, (void)ray, (void)out_channels;
    return factor[0];
}

static float own_density(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                         float *out_depth)
{
    float tau[LF_LANES], sigma[LF_LANES];
    lf_media_depths(&visit->worker->media, ray, tau, pivot->medium, sigma);
    *out_depth = tau[0] * lf_rays_length(ray, 0);
    return sigma[0];
}

static void march(const lf_visit *visit, const lf_unscattered_rays *fan)
{
    lf_scratch *w = visit->worker;
    if (visit->sums.feature)
        lf_media_moments_of(&w->media, &fan->rays, w->length + fan->from, w->tau + fan->from,
                            &w->met.moments);
    else
        lf_media_depths(&w->media, &fan->rays, w->tau + fan->from, -1, NULL);
}

static float lost(const lf_visit *visit, const lf_unscattered_rays *fan, int k, float factor,
                  lf_vec3 *out_transmittance)
{
    const lf_scratch *w = visit->worker;
    float through;
    (void)fan;
    const float lost = lf_lost_in(w->tau[k] * w->length[k], factor, &through);
    *out_transmittance = lf_v3(through, through, through);
    return lost;
}

const lf_extinction lf_extinction_grey = {.channels = 1,
                                          .depths = depths,
                                          .densities = densities,
                                          .weigh = weigh,
                                          .spread = spread,
                                          .own = own,
                                          .own_density = own_density,
                                          .march = march,
                                          .lost = lost};
