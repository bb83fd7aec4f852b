/* A density of each channel. */
#include "render/rows/extinction.h"

static void depths(const lf_visit *visit, int medium)
{
    lf_scratch *w = visit->worker;
    const lf_rays rays = lf_visit_rays(visit, 0, lf_rig_lanes(visit->rig));
    lf_media_depths_of_channels(&w->media, &rays, w->channels.tau, medium, w->sigma);
}

static void mean_of_channels(lf_scratch *w, int n)
{
    const float *d = w->channels.density;
    for (int k = 0; k < n; k++)
        w->density[k] = (d[k] + d[n + k] + d[2 * n + k]) * (1.0f / 3.0f);
}

static float densities(const lf_visit *visit, const lf_pivot *pivot)
{
    lf_scratch *w = visit->worker;
    lf_channels *c = &w->channels;
    const float even[3] = {1.0f, 1.0f, 1.0f}, *colour = pivot->event.kind == LF_EVENT_MEDIUM
                                                            ? w->media.item[pivot->medium].colour
                                                            : even;
    int n = lf_rig_lanes(visit->rig);
    float my2 = 1.0f + visit->plane.my * visit->plane.my, length[LF_MAX_LANES];
    for (int k = 0; k < n; k++)
        length[k] = w->media.n_here > 0 ? sqrtf(my2 + w->slope[k] * w->slope[k]) : 0.0f;
    for (int i = 0; i < 3; i++) {
        float *tau = c->tau + i * n, *scale = c->scale + i * n, share = colour[i];
        for (int k = 0; k < n; k++) {
            tau[k] = w->media.n_here > 0 ? tau[k] * length[k] : 0.0f;
            scale[k] = w->scale[k] * share;
        }
    }
    float sum = visit->kernels->densities(3 * n, c->scale, c->tau, c->density);
    mean_of_channels(w, n);
    for (int k = 0; k < n && w->equiangular.n > 0; k++) {
        float depth[3];
        for (int i = 0; i < 3; i++)
            depth[i] = c->scale[i * n + k] > 0.0f ? c->tau[i * n + k] : INFINITY;
        w->tau[k] = lf_min(depth[0], lf_min(depth[1], depth[2]));
    }
    return sum * (1.0f / 3.0f);
}

static void weigh(const lf_visit *visit, const float *factor)
{
    lf_scratch *w = visit->worker;
    const int n = lf_rig_lanes(visit->rig);
    for (int i = 0; i < 3 * n; i++)
        w->channels.density[i] *= factor[i];
    mean_of_channels(w, n);
}

static void spread(lf_visit *visit, lf_vec3 y, float scale)
{
    lf_scratch *w = visit->worker;
    const float *const *d = w->channels.received;
    for (int k = 0; k < visit->rig->n_views; k++) {
        float weight = w->density[k] * scale;
        if (weight == 0.0f)
            continue;
        size_t pixel = lf_visit_pixel(visit, k);
        lf_film_scatter(&visit->sums, pixel, d[0][k] * scale * y.x, d[1][k] * scale * y.y,
                        d[2][k] * scale * y.z);
        lf_film_weigh(&visit->sums, pixel, weight);
        w->contributions++;
    }
}

/* d: D of a channel, up to a factor that the smallest depth keeps away from underflow. */
static float own(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                 const float *factor, lf_vec3 *out_channels)
{
    const lf_media *media = &visit->worker->media;
    float tau[3 * LF_LANES], d[3], sum = 0.0f, least = INFINITY, length = lf_rays_length(ray, 0);
    bool medium = pivot->event.kind == LF_EVENT_MEDIUM;
    lf_media_depths_of_channels(media, ray, tau, -1, NULL);
    for (int c = 0; c < 3; c++) {
        d[c] = medium ? media->item[pivot->medium].colour[c] : 1.0f;
        least = lf_min(least, d[c] > 0.0f ? tau[c * LF_LANES] : INFINITY);
    }
    for (int c = 0; c < 3; c++)
        sum += d[c] *= expf(length * (least - lf_max(tau[c * LF_LANES], least)));
    *out_channels = lf_scale(
        lf_v3(d[0] * factor[0], d[1] * factor[LF_LANES], d[2] * factor[2 * LF_LANES]), 3.0f / sum);
    return 1.0f;
}

/* The mean over the channels, and the minimum of their depths. */
static float own_density(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *ray,
                         float *out_depth)
{
    const lf_media *media = &visit->worker->media;
    const float *colour = media->item[pivot->medium].colour, length = lf_rays_length(ray, 0);
    float tau[3 * LF_LANES], sigma[LF_LANES], mean = 0.0f, least = INFINITY;
    lf_media_depths_of_channels(media, ray, tau, pivot->medium, sigma);
    for (int c = 0; c < 3; c++)
        least = lf_min(least, colour[c] > 0.0f ? tau[c * LF_LANES] * length : INFINITY);
    for (int c = 0; c < 3 && least < INFINITY; c++)
        mean += colour[c] * expf(least - lf_max(tau[c * LF_LANES] * length, least));
    *out_depth = least;
    return mean * (1.0f / 3.0f) * sigma[0];
}

static void march(const lf_visit *visit, const lf_unscattered_rays *fan)
{
    lf_scratch *w = visit->worker;
    if (visit->sums.feature)
        lf_media_moments_of(&w->media, &fan->rays, w->length + fan->from, w->tau + fan->from,
                            &w->met.moments);
    lf_media_depths_of_channels(&w->media, &fan->rays, w->channels.tau, -1, NULL);
    for (int i = 0; i < 3 * fan->rays.n; i++)
        w->channels.factor[i] = 1.0f;
}

static float lost(const lf_visit *visit, const lf_unscattered_rays *fan, int k, float factor,
                  lf_vec3 *out_transmittance)
{
    const lf_scratch *w = visit->worker;
    const bool marched = k >= fan->from && k < fan->to && w->media.n_here > 0;
    float through[3], sum = 0.0f;
    for (int c = 0; c < 3; c++) {
        const int at = c * fan->rays.n + k - fan->from;
        const float depth = marched ? w->channels.tau[at] * w->length[k] : 0.0f,
                    own = marched ? w->channels.factor[at] : 1.0f;
        sum += lf_lost_in(depth, own * factor, &through[c]);
    }
    *out_transmittance = lf_v3(through[0], through[1], through[2]);
    return sum * (1.0f / 3.0f);
}

const lf_extinction lf_extinction_chromatic = {.channels = 3,
                                               .depths = depths,
                                               .densities = densities,
                                               .weigh = weigh,
                                               .spread = spread,
                                               .own = own,
                                               .own_density = own_density,
                                               .march = march,
                                               .lost = lost};
