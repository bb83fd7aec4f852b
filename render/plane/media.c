#include "render/plane/media.h"

#include <string.h>

void lf_media_frame_init(lf_media_frame *frame, const lf_volume *volumes, int n, const lf_rig *rigs,
                         int n_rigs)
{
    frame->n = 0;
    for (int i = 0; i < n; i++) {
        const lf_volume *volume = &volumes[i];
        bool grid = volume->kind == LF_VOLUME_GRID;
        if (!(volume->sigma_max > 0.0f) ||
            (grid && !lf_slice_frame_init(&frame->item[frame->n].slice, volume, rigs, n_rigs)))
            continue;
        frame->item[frame->n].volume = i;
        frame->item[frame->n].kind = !grid             ? LF_MEDIUM_BODY
                                     : volume->nearest ? LF_MEDIUM_VOXELS
                                                       : LF_MEDIUM_SLICE;
        frame->n++;
    }
}

lf_status lf_media_init(lf_media *media, const lf_media_frame *frame)
{
    lf_status status = LF_OK;
    media->n = frame->n;
    for (int i = 0; i < frame->n && status == LF_OK; i++) {
        media->item[i].volume = frame->item[i].volume;
        media->item[i].kind = frame->item[i].kind;
        if (frame->item[i].kind == LF_MEDIUM_SLICE)
            status = lf_slice_init(&media->item[i].slice, &frame->item[i].slice);
    }
    return status;
}

void lf_media_finish(lf_media *media)
{
    for (int i = 0; i < media->n; i++)
        lf_slice_finish(&media->item[i].slice);
    memset(media, 0, sizeof *media);
}

void lf_media_cut(lf_media *media, const lf_media_frame *frame, const lf_volume *volumes,
                  const lf_media_plane *at, int64_t *lookups)
{
    media->n_here = 0;
    for (int i = 0; i < media->n; i++) {
        lf_medium *m = &media->item[i];
        const lf_volume *volume = &volumes[m->volume];
        const lf_vec3 colour = lf_volume_colour(volume);
        bool here;
        m->colour[0] = colour.x;
        m->colour[1] = colour.y;
        m->colour[2] = colour.z;
        if (m->kind == LF_MEDIUM_SLICE) {
            *lookups += lf_slice_fill(&m->slice, &frame->item[i].slice, volume, at->rig, at->plane,
                                      at->phase, at->kernels);
            here = m->slice.first <= m->slice.last;
        } else {
            here = m->kind == LF_MEDIUM_VOXELS
                       ? lf_voxels_cut(&m->voxels, volume, at->rig, at->plane)
                       : lf_body_cut(&m->body, volume, at->rig, at->plane);
        }
        if (here)
            media->here[media->n_here++] = i;
    }
}

/* Optical depth of one medium along the ray up to z_end; stops at `stop` (per unit of Z) and
 * returns where. */
static float march(const lf_medium *medium, const lf_media_ray *ray, float z_end, float stop,
                   float *out_z)
{
    if (medium->kind == LF_MEDIUM_SLICE)
        return lf_slice_march(&medium->slice, ray->x0, ray->slope, z_end, stop, out_z);
    if (medium->kind == LF_MEDIUM_VOXELS)
        return lf_voxels_march(&medium->voxels, ray->x0, ray->slope, z_end, stop, out_z);
    float from, to;
    lf_body_interval(&medium->body, ray->x0, ray->slope, &from, &to);
    to = lf_min(to, z_end);
    float depth = medium->body.sigma_t * lf_max(to - from, 0.0f);
    *out_z = depth > stop ? lf_min(from + stop / medium->body.sigma_t, to) : z_end;
    return lf_min(depth, stop);
}

/* q of each medium alone, and the probability of any collision in this medium or a later one in the
 * list. */
static void exit_probabilities(const lf_media *media, const lf_media_ray *ray, int channel,
                               float *q, float *any)
{
    float depth = 0.0f, z;
    for (int i = media->n_here - 1; i >= 0; i--) {
        const lf_medium *medium = &media->item[media->here[i]];
        float tau =
            ray->length * medium->colour[channel] * march(medium, ray, ray->z_end, INFINITY, &z);
        depth += tau;
        q[i] = -expm1f(-tau);
        any[i] = -expm1f(-depth);
    }
}

lf_collision lf_media_collide(const lf_media *media, const lf_media_ray *ray, int channel, float u,
                              bool forced, lf_tracer *tracer)
{
    lf_collision first = {.z = INFINITY, .forced_weight = 1.0f};
    float q[LF_MAX_VOLUMES], any[LF_MAX_VOLUMES], z_end = ray->z_end;
    /* The sampler's numbers are multiples of 2^-24; finer digits matter in thin media. */
    u = lf_min(u + lf_rng(tracer) * 0x1p-24f, 1.0f - 0x1p-24f);
    if (forced && media->n_here > 0) {
        exit_probabilities(media, ray, channel, q, any);
        if (!(any[0] > 0.0f))
            return first;
        first.forced_weight = any[0];
    }
    for (int i = 0; i < media->n_here; i++) {
        const lf_medium *medium = &media->item[media->here[i]];
        float x = i == 0 ? u : lf_rng_fine(tracer), z;
        /* No collision so far, and one is forced: this medium collides with probability q / any,
         * that is if x * any < q. */
        bool must = forced && first.z == INFINITY;
        if (must)
            x = lf_min(x * any[i], q[i] == any[i] ? q[i] * (1.0f - 1e-6f) : 1.0f);
        if ((must && x >= q[i]) || !(medium->colour[channel] > 0.0f))
            continue;
        float stop = lf_exponential(x) / (ray->length * medium->colour[channel]);
        float reached = march(medium, ray, z_end, stop, &z);
        if (reached >= stop && z < z_end) {
            z_end = z;
            first.z = lf_max(z, 1e-30f);
            first.medium = media->here[i];
        }
    }
    return first;
}

/* All rays of a pivot end in one voxel. */
static void through_voxels(const lf_voxels *voxels, const lf_rays *rays, float *tau, float *density)
{
    const float *x0 = rays->x0, *slope = rays->slope, *z_end = rays->z_end;
    lf_voxels_depths(voxels, rays->n, x0, slope, z_end, tau);
    float sigma = density ? lf_voxels_density(voxels, x0[0] + slope[0] * z_end[0], z_end[0]) : 0.0f;
    for (int k = 0; k < rays->n && density; k++)
        density[k] = sigma;
}

/* Adds the depths of one medium; density NULL: not needed. */
static void through(const lf_medium *medium, const lf_rays *rays, float *tau, float *density)
{
    const lf_kernels *kernels = rays->kernels;
    if (medium->kind == LF_MEDIUM_SLICE)
        kernels->march(&medium->slice, rays->n, rays->x0, rays->slope, rays->z_end, tau, density);
    else if (medium->kind == LF_MEDIUM_VOXELS)
        through_voxels(&medium->voxels, rays, tau, density);
    else
        kernels->through(&medium->body, rays->n, rays->x0, rays->slope, rays->z_end, tau);
}

void lf_media_depths(const lf_media *media, const lf_rays *rays, float *tau, int collided,
                     float *density)
{
    const int n = rays->n;
    memset(tau, 0, sizeof *tau * (size_t)n);
    for (int k = 0; k < n && collided >= 0; k++)
        density[k] = 1.0f;
    for (int i = 0; i < media->n_here; i++)
        through(&media->item[media->here[i]], rays, tau,
                media->here[i] == collided ? density : NULL);
}

void lf_media_depths_of_channels(const lf_media *media, const lf_rays *rays, float *tau,
                                 int collided, float *density)
{
    const int n = rays->n;
    memset(tau, 0, sizeof *tau * 3 * (size_t)n);
    for (int k = 0; k < n && collided >= 0; k++)
        density[k] = 1.0f;
    for (int i = 0; i < media->n_here; i++) {
        const lf_medium *medium = &media->item[media->here[i]];
        float own[LF_MAX_LANES] = {0.0f};
        through(medium, rays, own, media->here[i] == collided ? density : NULL);
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < n; k++)
                tau[c * n + k] += medium->colour[c] * own[k];
    }
}

/* The moments from one medium's sums. */
static void moments_of(int n, float *const sums[3], int first, lf_media_moments *out)
{
    for (int k = 0; k < n; k++) {
        float inverse = sums[0][k] > 0.0f ? 1.0f / sums[0][k] : 0.0f, mean = sums[1][k] * inverse;
        out->met[first + k] = sums[0][k];
        out->nearness[first + k] = mean;
        out->spread[first + k] = sqrtf(lf_max(sums[2][k] * inverse - mean * mean, 0.0f));
    }
}

/* The first of two collisions; the one of `to` is in front with probability p. */
static void join(lf_media_moments *to, const lf_media_moments *from, int first, int n)
{
    for (int k = first; k < first + n; k++) {
        float a = to->met[k], b = from->met[k], apart = to->nearness[k] - from->nearness[k],
              width = to->spread[k] + from->spread[k],
              p = lf_min(lf_max(0.5f + 0.2886751f * apart / (1e-6f + width), 0.0f), 1.0f),
              share = a * (1.0f - (1.0f - p) * b), other = b * (1.0f - p * a), sum = share + other,
              t = sum > 0.0f ? other / sum : 0.0f, s = 1.0f - t,
              variance = s * to->spread[k] * to->spread[k] +
                         t * (from->spread[k] * from->spread[k] + s * apart * apart);
        to->met[k] = sum;
        to->nearness[k] -= t * apart;
        to->spread[k] = sqrtf(variance);
    }
}

static bool any(const float *x, int n)
{
    int met = 0;
    for (int k = 0; k < n; k++)
        met |= x[k] > 0.0f;
    return met;
}

void lf_media_moments_of(const lf_media *media, const lf_rays *rays, const float *length,
                         float *tau, lf_media_moments *out)
{
    const lf_kernels *kernels = rays->kernels;
    const int first = out->first, n = rays->n;
    const lf_feature_rays of = {n, rays->x0, rays->slope, rays->z_end, length, out->distance};
    float sum[3][LF_MAX_LANES], *const sums[3] = {sum[0], sum[1], sum[2]};
    lf_media_moments other, *to = out;
    memset(tau, 0, sizeof *tau * (size_t)n);
    for (int i = 0; i < media->n_here; i++) {
        const lf_medium *medium = &media->item[media->here[i]];
        if (medium->kind == LF_MEDIUM_BODY) {
            float *const lanes[3] = {to->met + first, to->nearness + first, to->spread + first};
            kernels->within(&medium->body, &of, tau, lanes);
        } else {
            if (medium->kind == LF_MEDIUM_SLICE)
                kernels->moments(&medium->slice, &of, tau, sums);
            else
                lf_voxels_moments(&medium->voxels, &of, tau, sums);
            moments_of(n, sums, first, to);
        }
        if (to == &other && any(other.met + first, n))
            join(out, &other, first, n);
        to = &other;
    }
}
