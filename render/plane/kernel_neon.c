/* The kernels for NEON, which every arm64 has: 4 lanes at a time. No FMA and no min or max
 * instructions (these treat NaN and signed zeros differently), so that results equal kernel_c.c bit
 * for bit. docs/lab/performance.md has their instructions, beside those of plain C. */
#if defined(__aarch64__)

#include <arm_neon.h>
#include <string.h>

#include "render/plane/kernel.h"
#include "render/plane/kernel_exp.h"

#define GROUP 4

static inline float32x4_t min4(float32x4_t a, float32x4_t b)
{
    return vbslq_f32(vcltq_f32(a, b), a, b);
}

static inline float32x4_t max4(float32x4_t a, float32x4_t b)
{
    return vbslq_f32(vcgtq_f32(a, b), a, b);
}

/* lf_slice_at for 4 lanes of one plane; neighbouring samples are loaded in pairs. */
static inline float32x4_t at(const lf_slice *slice, const float *row, float32x4_t x)
{
    float32x4_t g = vmulq_n_f32(vsubq_f32(x, vdupq_n_f32(slice->x_min)), slice->inv_dx);
    g = min4(max4(g, vdupq_n_f32(0.0f)), vdupq_n_f32((float)(slice->nx - 1)));
    int32x4_t i = vcvtq_s32_f32(g);
    float32x4_t p =
        vcombine_f32(vld1_f32(row + vgetq_lane_s32(i, 0)), vld1_f32(row + vgetq_lane_s32(i, 1)));
    float32x4_t q =
        vcombine_f32(vld1_f32(row + vgetq_lane_s32(i, 2)), vld1_f32(row + vgetq_lane_s32(i, 3)));
    float32x4_t a = vuzp1q_f32(p, q), b = vuzp2q_f32(p, q), f = vsubq_f32(g, vcvtq_f32_s32(i));
    return vaddq_f32(a, vmulq_f32(f, vsubq_f32(b, a)));
}

/* lf_slice_share for 4 lanes. */
static inline float32x4_t share(float32x4_t t)
{
    const float32x4_t one = vdupq_n_f32(1.0f);
    float32x4_t rest = vsubq_f32(one, vabsq_f32(t));
    float32x4_t tail = vmulq_f32(vmulq_n_f32(rest, 0.5f), rest);
    return vbslq_f32(vcltzq_f32(t), tail, vsubq_f32(one, tail));
}

/* One group of 4 lanes. */
static inline void march4(const lf_slice *slice, const float *x0, const float *slope,
                          const float *z_end, float *tau, float *sigma)
{
    const float32x4_t vx = vld1q_f32(x0), vs = vld1q_f32(slope), end = vld1q_f32(z_end);
    const float32x4_t zero = vdupq_n_f32(0.0f), one = vdupq_n_f32(1.0f);
    float32x4_t depth = vld1q_f32(tau), density = zero;
    float z_min = vminvq_f32(end), z_max = vmaxvq_f32(end);
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz;
        if (z - slice->dz >= z_max)
            break;
        float xa = x0[0] + slope[0] * z, xb = x0[GROUP - 1] + slope[GROUP - 1] * z;
        if (lf_max(xa, xb) <= slice->spans[s].x_lo || lf_min(xa, xb) >= slice->spans[s].x_hi)
            continue;
        const float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
        float32x4_t v = at(slice, row, vaddq_f32(vx, vmulq_n_f32(vs, z)));
        if (z + slice->dz <= z_min) {
            float step = slice->dz * lf_max(1.0f - slice->behind[s], 0.0f);
            depth = vaddq_f32(depth, vmulq_n_f32(v, step));
            continue;
        }
        float32x4_t t = vmulq_n_f32(vsubq_f32(end, vdupq_n_f32(z)), slice->inv_dz);
        t = min4(max4(t, vdupq_n_f32(-1.0f)), one);
        float32x4_t step = max4(vsubq_f32(share(t), vdupq_n_f32(slice->behind[s])), zero);
        depth = vaddq_f32(depth, vmulq_f32(v, vmulq_n_f32(step, slice->dz)));
        density = vaddq_f32(density, vmulq_f32(v, vsubq_f32(one, vabsq_f32(t))));
    }
    vst1q_f32(tau, depth);
    if (sigma)
        vst1q_f32(sigma, density);
}

static void march(const lf_slice *slice, int n, const float *x0, const float *slope,
                  const float *z_end, float *tau, float *sigma)
{
    for (int k = 0; k < n; k += GROUP)
        march4(slice, x0 + k, slope + k, z_end + k, tau + k, sigma ? sigma + k : NULL);
}

/* One group of 4 lanes. */
static inline void moments4(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                            float *const sums[3], int k)
{
    const float *x0 = rays->x0, *slope = rays->slope, *z_end = rays->z_end;
    const float32x4_t vx = vld1q_f32(x0 + k), vs = vld1q_f32(slope + k), end = vld1q_f32(z_end + k),
                      zero = vdupq_n_f32(0.0f), one = vdupq_n_f32(1.0f),
                      per_z = vld1q_f32(rays->length + k);
    float32x4_t depth = vld1q_f32(tau + k), rest = one, lost = zero, near = zero, square = zero;
    float z_max = vmaxvq_f32(end);
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz;
        if (z - slice->dz >= z_max)
            break;
        float xa = x0[k] + slope[k] * z, xb = x0[k + GROUP - 1] + slope[k + GROUP - 1] * z,
              y = lf_nearness(rays->distance, z);
        if (lf_max(xa, xb) <= slice->spans[s].x_lo || lf_min(xa, xb) >= slice->spans[s].x_hi)
            continue;
        const float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
        float32x4_t v = at(slice, row, vaddq_f32(vx, vmulq_n_f32(vs, z)));
        float32x4_t t = vmulq_n_f32(vsubq_f32(end, vdupq_n_f32(z)), slice->inv_dz);
        t = min4(max4(t, vdupq_n_f32(-1.0f)), one);
        float32x4_t step = max4(vsubq_f32(share(t), vdupq_n_f32(slice->behind[s])), zero);
        step = vmulq_f32(v, vmulq_n_f32(step, slice->dz));
        depth = vaddq_f32(depth, step);
        float32x4_t x = vmulq_f32(step, per_z);
        x = vaddq_f32(one, vmulq_f32(x, vaddq_f32(one, vmulq_n_f32(x, 0.5f))));
        float32x4_t behind = vdivq_f32(rest, x), w = vsubq_f32(rest, behind);
        rest = behind;
        lost = vaddq_f32(lost, w);
        near = vaddq_f32(near, vmulq_n_f32(w, y));
        square = vaddq_f32(square, vmulq_n_f32(w, y * y));
    }
    vst1q_f32(tau + k, depth);
    vst1q_f32(sums[0] + k, lost);
    vst1q_f32(sums[1] + k, near);
    vst1q_f32(sums[2] + k, square);
}

static void moments(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                    float *const sums[3])
{
    for (int k = 0; k < rays->n; k += GROUP)
        moments4(slice, rays, tau, sums, k);
}

/* Look-ups are limited by memory latency: no vector code. */
static void sample(const lf_volume *volume, const lf_line *line, int n, const float *x,
                   float *sigma)
{
    lf_line_sample(volume, line, n, x, sigma);
}

static void compare4(const lf_probe *probe, const float *x0, const float *slope, const float *z_end,
                     float *factor)
{
    const lf_slice *slice = probe->slice;
    float32x4_t x = vld1q_f32(x0), s = vld1q_f32(slope), density = vdupq_n_f32(0.0f),
                one = vdupq_n_f32(1.0f);
    float t, at_z[GROUP], truth[GROUP];
    int plane = lf_slice_plane(slice, probe->z, &t);
    for (int i = 0; i < 2; i++) {
        if (plane + i < 0 || plane + i >= slice->nz)
            continue;
        float z = slice->z0 + (float)(plane + i) * slice->dz;
        const float *row = slice->sigma + (size_t)(plane + i) * (size_t)slice->stride;
        density = vaddq_f32(density, vmulq_n_f32(at(slice, row, vaddq_f32(x, vmulq_n_f32(s, z))),
                                                 i ? t : 1.0f - t));
    }
    vst1q_f32(at_z, vaddq_f32(x, vmulq_n_f32(s, probe->z)));
    lf_line_sample(probe->volume, &probe->line, GROUP, at_z, truth);
    float32x4_t length = vsqrtq_f32(vaddq_f32(vdupq_n_f32(probe->my2), vmulq_f32(s, s)));
    float32x4_t off =
        vmulq_n_f32(vmulq_f32(vsubq_f32(vld1q_f32(truth), density), length), probe->inverse);
    uint32x4_t reached = vcltq_f32(vdupq_n_f32(probe->z), vld1q_f32(z_end));
    vst1q_f32(factor, vmulq_f32(vld1q_f32(factor), vbslq_f32(reached, vsubq_f32(one, off), one)));
}

static void compare(const lf_probe *probe, int n, const float *x0, const float *slope,
                    const float *z_end, float *factor)
{
    for (int k = 0; k < n; k += GROUP)
        compare4(probe, x0 + k, slope + k, z_end + k, factor + k);
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

static inline float32x4_t exp_kernel(float32x4_t x)
{
    x = max4(x, vdupq_n_f32(LF_EXP_MIN));
    float32x4_t i = vrndnq_f32(vmulq_n_f32(x, LF_LOG2E));
    float32x4_t f = vsubq_f32(vsubq_f32(x, vmulq_n_f32(i, LF_LN2_HI)), vmulq_n_f32(i, LF_LN2_LO));
    float32x4_t p = vdupq_n_f32(LF_EXP_C6);
    p = vaddq_f32(vmulq_f32(p, f), vdupq_n_f32(LF_EXP_C5));
    p = vaddq_f32(vmulq_f32(p, f), vdupq_n_f32(LF_EXP_C4));
    p = vaddq_f32(vmulq_f32(p, f), vdupq_n_f32(LF_EXP_C3));
    p = vaddq_f32(vmulq_f32(p, f), vdupq_n_f32(LF_EXP_C2));
    p = vaddq_f32(vmulq_f32(p, f), vdupq_n_f32(1.0f));
    p = vaddq_f32(vmulq_f32(p, f), vdupq_n_f32(1.0f));
    int32x4_t bits = vshlq_n_s32(vaddq_s32(vcvtq_s32_f32(i), vdupq_n_s32(127)), 23);
    return vmulq_f32(p, vreinterpretq_f32_s32(bits));
}

/* Least tau of the lanes that have a scale. */
static float least(int n, const float *scale, const float *tau)
{
    const float32x4_t inf = vdupq_n_f32(INFINITY);
    float32x4_t low = inf;
    for (int k = 0; k < n; k += GROUP)
        low = min4(low, vbslq_f32(vcgtzq_f32(vld1q_f32(scale + k)), vld1q_f32(tau + k), inf));
    float lanes[GROUP], tau_min = INFINITY;
    vst1q_f32(lanes, low);
    for (int i = 0; i < GROUP; i++)
        tau_min = lf_min(tau_min, lanes[i]);
    return tau_min;
}

static float densities(int n, const float *scale, const float *tau, float *d)
{
    const float32x4_t zero = vdupq_n_f32(0.0f);
    float32x4_t sums[2] = {zero, zero};
    float tau_min = least(n, scale, tau);
    if (!(tau_min < INFINITY)) {
        memset(d, 0, sizeof *d * (size_t)n);
        return 0.0f;
    }
    for (int k = 0; k < n; k += GROUP) {
        float32x4_t sc = vld1q_f32(scale + k);
        float32x4_t x = min4(vsubq_f32(vdupq_n_f32(tau_min), vld1q_f32(tau + k)), zero);
        uint32x4_t on = vandq_u32(vcgtzq_f32(sc), vcgtq_f32(x, vdupq_n_f32(LF_EXP_MIN)));
        float32x4_t e = vbslq_f32(on, vmulq_f32(sc, exp_kernel(x)), zero);
        vst1q_f32(d + k, e);
        sums[k / GROUP % 2] = vaddq_f32(sums[k / GROUP % 2], e);
    }
    float lanes[LF_LANES];
    vst1q_f32(lanes, sums[0]);
    vst1q_f32(lanes + GROUP, sums[1]);
    float total = lanes[0];
    for (int i = 1; i < LF_LANES; i++)
        total += lanes[i];
    return total;
}

const lf_kernels lf_kernels_neon = {.name = "neon",
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

#else
typedef int lf_kernels_neon_not_here;
#endif
