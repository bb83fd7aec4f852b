#include "render/rows/body.h"

/* True when all corners of the volume's box lie on one side of the plane, or behind the cameras. */
static bool misses(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane)
{
    float lowest = INFINITY, highest = -INFINITY, farthest = -INFINITY;
    for (int corner = 0; corner < 8; corner++) {
        lf_vec3 p = lf_v3(corner & 1 ? volume->bounds_max.x : volume->bounds_min.x,
                          corner & 2 ? volume->bounds_max.y : volume->bounds_min.y,
                          corner & 4 ? volume->bounds_max.z : volume->bounds_min.z);
        lf_vec3 d = lf_sub(p, rig->eye);
        float z = lf_dot(d, rig->forward), above = lf_dot(d, rig->up) - (plane->ly + plane->my * z);
        lowest = lf_min(lowest, above);
        highest = lf_max(highest, above);
        farthest = lf_max(farthest, z);
    }
    return lowest > 0.0f || highest < 0.0f || farthest <= 0.0f;
}

bool lf_body_rays(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane,
                  float origin[3], float across[3], float depth[3])
{
    lf_vec3 o = lf_rig_point(rig, 0.0f, plane->ly, 0.0f),
            d = lf_rig_direction(rig, 0.0f, plane->my, 1.0f);
    if (misses(volume, rig, plane))
        return false;
    for (int i = 0; i < 3; i++) {
        const float *m = volume->to_volume[i];
        origin[i] = m[0] * o.x + m[1] * o.y + m[2] * o.z + m[3];
        across[i] = m[0] * rig->right.x + m[1] * rig->right.y + m[2] * rig->right.z;
        depth[i] = m[0] * d.x + m[1] * d.y + m[2] * d.z;
    }
    return true;
}

bool lf_body_cut(lf_body *body, const lf_volume *volume, const lf_rig *rig,
                 const lf_row_plane *plane)
{
    body->shape = volume->kind;
    body->sigma_t = volume->sigma_scale;
    return lf_body_rays(volume, rig, plane, body->origin, body->across, body->depth);
}

/* Mean and variance of a truncated exponential on 0..1; series where the closed forms cancel. */
static void truncated(float tau, float *mean, float *variance)
{
    float t2 = tau * tau;
    if (tau < 1.0f) {
        *mean = 0.5f - tau * (1.0f / 12.0f - t2 * (1.0f / 720.0f));
        *variance = 1.0f / 12.0f - t2 * (1.0f / 240.0f - t2 * (1.0f / 6048.0f));
        return;
    }
    float e = expf(-tau), lost = 1.0f - e;
    *mean = 1.0f / tau - e / lost;
    *variance = 1.0f / t2 - e / (lost * lost);
}

void lf_body_moments(const lf_body *body, int n, const float *x0, const float *slope,
                     const float *z_end, const float *length, float distance, float *const sums[3])
{
    for (int k = 0; k < n; k++) {
        float from, to, mean, variance;
        lf_body_interval(body, x0[k], slope[k], &from, &to);
        to = lf_min(to, z_end[k]);
        float inside = lf_max(to - from, 0.0f), tau = body->sigma_t * inside * length[k];
        sums[0][k] = sums[1][k] = sums[2][k] = 0.0f;
        if (!(tau > 0.0f))
            continue;
        truncated(tau, &mean, &variance);
        float z = from + inside * mean, y = lf_nearness(distance, z),
              relative = variance * (inside / z) * (inside / z);
        sums[0][k] = -expm1f(-tau);
        sums[1][k] = sums[0][k] * lf_min(y * (1.0f + relative), LF_NEARNESS_MAX);
        sums[2][k] = sums[1][k] * sums[1][k] / sums[0][k] + sums[0][k] * y * y * relative;
    }
}
