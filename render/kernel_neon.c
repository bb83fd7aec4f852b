/* The kernels for NEON, which every arm64 has: 8 lanes as two halves of 4; no FMA and no min or max instructions (theirs treat NaN
 * and signed zeros otherwise), so that they equal kernel_c.c bit for bit. Their speed has not been measured. */
#if defined(__aarch64__)

#include <arm_neon.h>
#include <string.h>

#include "render/kernel.h"
#include "render/kernel_exp.h"

#define HALF 4

static inline float32x4_t min4(float32x4_t a, float32x4_t b)
{
    return vbslq_f32(vcltq_f32(a, b), a, b);
}

static inline float32x4_t max4(float32x4_t a, float32x4_t b)
{
    return vbslq_f32(vcgtq_f32(a, b), a, b);
}

/* lf_slice_at for 4 lanes of one slab; without gathers, neighbouring samples come in pairs. */
static inline float32x4_t at(const lf_slice *slice, const float *row, float32x4_t x)
{
    float32x4_t g = vmulq_n_f32(vsubq_f32(x, vdupq_n_f32(slice->x_min)), slice->inv_dx);
    g = min4(max4(g, vdupq_n_f32(0.0f)), vdupq_n_f32((float)(slice->nx - 1)));
    int32x4_t i = vcvtq_s32_f32(g);
    float32x4_t p = vcombine_f32(vld1_f32(row + vgetq_lane_s32(i, 0)), vld1_f32(row + vgetq_lane_s32(i, 1)));
    float32x4_t q = vcombine_f32(vld1_f32(row + vgetq_lane_s32(i, 2)), vld1_f32(row + vgetq_lane_s32(i, 3)));
    float32x4_t a = vuzp1q_f32(p, q), b = vuzp2q_f32(p, q), f = vsubq_f32(g, vcvtq_f32_s32(i));
    return vaddq_f32(a, vmulq_f32(f, vsubq_f32(b, a)));
}

static void march(const lf_slice *slice, int n, const float *x0, const float *slope, const float *z_end, float *tau, float *sigma)
{
    memset(tau, 0, sizeof *tau * (size_t)n);
    if (sigma)
        memset(sigma, 0, sizeof *sigma * (size_t)n);
    float z_max = z_end[0];
    for (int k = 1; k < n; k++)
        z_max = lf_max(z_max, z_end[k]);
    int wanted = sigma ? lf_slice_slab(slice, z_end[0]) : -1;
    for (int s = slice->first; s <= slice->last; s++) {
        float lo = slice->z0 + (float)s * slice->dz;
        if (lo >= z_max && s != wanted)
            break;
        float middle = lo + 0.5f * slice->dz, hi = lo + slice->dz, from = lf_max(lo, 0.0f);
        float xa = x0[0] + slope[0] * middle, xb = x0[n - 1] + slope[n - 1] * middle;
        if (lf_max(xa, xb) <= slice->slabs[s].x_lo || lf_min(xa, xb) >= slice->slabs[s].x_hi)
            continue;
        float *here = s == wanted ? sigma : NULL;
        const float *row = slice->sigma + (size_t)s * (size_t)(slice->nx + 1);
        for (int k = 0; k < n; k += HALF) {
            float32x4_t v = at(slice, row, vaddq_f32(vld1q_f32(x0 + k), vmulq_n_f32(vld1q_f32(slope + k), middle)));
            float32x4_t step = vsubq_f32(min4(vld1q_f32(z_end + k), vdupq_n_f32(hi)), vdupq_n_f32(from));
            float32x4_t t = vmulq_f32(v, max4(step, vdupq_n_f32(0.0f)));
            vst1q_f32(tau + k, vaddq_f32(vld1q_f32(tau + k), t));
            if (here)
                vst1q_f32(here + k, v);
        }
    }
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
    for (int k = 0; k < n; k += HALF)
        low = min4(low, vbslq_f32(vcgtzq_f32(vld1q_f32(scale + k)), vld1q_f32(tau + k), inf));
    float lanes[HALF], tau_min = INFINITY;
    vst1q_f32(lanes, low);
    for (int i = 0; i < HALF; i++)
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
    for (int k = 0; k < n; k += HALF) {
        float32x4_t sc = vld1q_f32(scale + k);
        float32x4_t x = min4(vsubq_f32(vdupq_n_f32(tau_min), vld1q_f32(tau + k)), zero);
        uint32x4_t on = vandq_u32(vcgtzq_f32(sc), vcgtq_f32(x, vdupq_n_f32(LF_EXP_MIN)));
        float32x4_t e = vbslq_f32(on, vmulq_f32(sc, exp_kernel(x)), zero);
        vst1q_f32(d + k, e);
        sums[k / HALF % 2] = vaddq_f32(sums[k / HALF % 2], e);
    }
    float lanes[LF_LANES];
    vst1q_f32(lanes, sums[0]);
    vst1q_f32(lanes + HALF, sums[1]);
    float total = lanes[0];
    for (int i = 1; i < LF_LANES; i++)
        total += lanes[i];
    return total;
}

const lf_kernels lf_kernels_neon = {.name = "neon", .march = march, .densities = densities};

#else
typedef int lf_kernels_neon_not_here;
#endif
