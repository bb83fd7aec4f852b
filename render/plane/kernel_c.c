/* The kernels in plain C: what the others are held against. */
#include <string.h>

#include "render/plane/kernel.h"
#include "render/plane/kernel_exp.h"

static void march(const lf_slice *slice, int n, const float *x0, const float *slope,
                  const float *z_end, float *tau, float *sigma)
{
    float z_min = z_end[0], z_max = z_end[0];
    if (sigma)
        memset(sigma, 0, sizeof *sigma * (size_t)n);
    for (int k = 1; k < n; k++) {
        z_min = lf_min(z_min, z_end[k]);
        z_max = lf_max(z_max, z_end[k]);
    }
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz, behind = slice->behind[s];
        if (z - slice->dz >= z_max)
            break;
        float xa = x0[0] + slope[0] * z, xb = x0[n - 1] + slope[n - 1] * z;
        if (lf_max(xa, xb) <= slice->spans[s].x_lo || lf_min(xa, xb) >= slice->spans[s].x_hi)
            continue;
        bool whole = z + slice->dz <= z_min;
        for (int k = 0; k < n; k++) {
            float v = lf_slice_at(slice, s, x0[k] + slope[k] * z);
            float t = whole ? 1.0f : lf_min(lf_max((z_end[k] - z) * slice->inv_dz, -1.0f), 1.0f);
            tau[k] += v * (slice->dz * lf_max(lf_slice_share(t) - behind, 0.0f));
            if (sigma)
                sigma[k] += v * (1.0f - fabsf(t));
        }
    }
}

static void moments(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                    float *const sums[3])
{
    const float *x0 = rays->x0, *slope = rays->slope, *z_end = rays->z_end, *length = rays->length;
    const int n = rays->n;
    float z_max = z_end[0], rest[LF_MAX_LANES];
    for (int k = 0; k < n; k++) {
        z_max = lf_max(z_max, z_end[k]);
        rest[k] = 1.0f;
        sums[0][k] = sums[1][k] = sums[2][k] = 0.0f;
    }
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz, y = lf_nearness(rays->distance, z);
        if (z - slice->dz >= z_max)
            break;
        float xa = x0[0] + slope[0] * z, xb = x0[n - 1] + slope[n - 1] * z;
        if (lf_max(xa, xb) <= slice->spans[s].x_lo || lf_min(xa, xb) >= slice->spans[s].x_hi)
            continue;
        for (int k = 0; k < n; k++) {
            float t = lf_min(lf_max((z_end[k] - z) * slice->inv_dz, -1.0f), 1.0f);
            float depth = lf_slice_at(slice, s, x0[k] + slope[k] * z) *
                          (slice->dz * lf_max(lf_slice_share(t) - slice->behind[s], 0.0f));
            float x = depth * length[k], behind = rest[k] / (1.0f + x * (1.0f + 0.5f * x)),
                  w = rest[k] - behind;
            tau[k] += depth;
            rest[k] = behind;
            sums[0][k] += w;
            sums[1][k] += w * y;
            sums[2][k] += w * (y * y);
        }
    }
}

static void sample(const lf_volume *volume, const lf_line *line, int n, const float *x,
                   float *sigma)
{
    lf_line_sample(volume, line, n, x, sigma);
}

static void compare(const lf_probe *probe, int n, const float *x0, const float *slope,
                    const float *z_end, float *factor)
{
    for (int k = 0; k < n; k++) {
        float x = x0[k] + slope[k] * probe->z, truth;
        lf_line_sample(probe->volume, &probe->line, 1, &x, &truth);
        float difference = truth - lf_slice_density(probe->slice, x0[k], slope[k], probe->z);
        float length = sqrtf(probe->my2 + slope[k] * slope[k]);
        factor[k] *= probe->z < z_end[k] ? 1.0f - difference * length * probe->inverse : 1.0f;
    }
}

static void through(const lf_body *body, int n, const float *x0, const float *slope,
                    const float *z_end, float *tau)
{
    lf_body_depths(body, n, x0, slope, z_end, tau);
}

static void within(const lf_body *body, const lf_feature_rays *rays, float *tau,
                   float *const out[3])
{
    lf_body_moments(body, rays, tau, out);
}

static float exp_kernel(float x)
{
    x = lf_max(x, LF_EXP_MIN);
    float i = rintf(x * LF_LOG2E);
    float f = (x - i * LF_LN2_HI) - i * LF_LN2_LO;
    float p = LF_EXP_C6;
    p = p * f + LF_EXP_C5;
    p = p * f + LF_EXP_C4;
    p = p * f + LF_EXP_C3;
    p = p * f + LF_EXP_C2;
    p = p * f + 1.0f;
    p = p * f + 1.0f;
    int bits = ((int)i + 127) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

static float densities(int n, const float *scale, const float *tau, float *d)
{
    float tau_min = INFINITY, sum[LF_LANES] = {0};
    for (int k = 0; k < n; k++)
        tau_min = lf_min(tau_min, scale[k] > 0.0f ? tau[k] : INFINITY);
    if (!(tau_min < INFINITY)) {
        memset(d, 0, sizeof *d * (size_t)n);
        return 0.0f;
    }
    for (int k = 0; k < n; k++) {
        float x = lf_min(tau_min - tau[k], 0.0f), e = scale[k] * exp_kernel(x);
        d[k] = scale[k] > 0.0f && x > LF_EXP_MIN ? e : 0.0f;
        sum[k % LF_LANES] += d[k];
    }
    float total = sum[0];
    for (int i = 1; i < LF_LANES; i++)
        total += sum[i];
    return total;
}

const lf_kernels lf_kernels_c = {.name = "c",
                                 .march = march,
                                 .moments = moments,
                                 .through = through,
                                 .within = within,
                                 .sample = sample,
                                 .compare = compare,
                                 .densities = densities,
                                 .suffixes = &lf_suffixes_c,
                                 .fans = &lf_fans_c,
                                 .surfaces = &lf_surface_fans_c};
