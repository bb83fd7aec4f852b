/* The kernels for AVX2, 8 lanes; no FMA, so that they equal kernel_c.c bit for bit. */
#if defined(__x86_64__)

#include <immintrin.h>
#include <string.h>

#include "render/kernel.h"
#include "render/kernel_exp.h"

/* lf_slice_at for 8 lanes of one slab. */
static inline __m256 at(const lf_slice *slice, const float *row, __m256 x)
{
    __m256 g = _mm256_mul_ps(_mm256_sub_ps(x, _mm256_set1_ps(slice->x_min)), _mm256_set1_ps(slice->inv_dx));
    g = _mm256_min_ps(_mm256_max_ps(g, _mm256_setzero_ps()), _mm256_set1_ps((float)(slice->nx - 1)));
    __m256i i = _mm256_cvttps_epi32(g);
    __m256 a = _mm256_i32gather_ps(row, i, 4), b = _mm256_i32gather_ps(row + 1, i, 4);
    __m256 f = _mm256_sub_ps(g, _mm256_cvtepi32_ps(i));
    return _mm256_add_ps(a, _mm256_mul_ps(f, _mm256_sub_ps(b, a)));
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
        __m256 vm = _mm256_set1_ps(middle), vh = _mm256_set1_ps(hi), vf = _mm256_set1_ps(from);
        for (int k = 0; k < n; k += LF_LANES) {
            __m256 x = _mm256_add_ps(_mm256_loadu_ps(x0 + k), _mm256_mul_ps(_mm256_loadu_ps(slope + k), vm));
            __m256 v = at(slice, row, x);
            __m256 step = _mm256_sub_ps(_mm256_min_ps(_mm256_loadu_ps(z_end + k), vh), vf);
            __m256 t = _mm256_mul_ps(v, _mm256_max_ps(step, _mm256_setzero_ps()));
            _mm256_storeu_ps(tau + k, _mm256_add_ps(_mm256_loadu_ps(tau + k), t));
            if (here)
                _mm256_storeu_ps(here + k, v);
        }
    }
}

static inline __m256 exp_kernel(__m256 x)
{
    x = _mm256_max_ps(x, _mm256_set1_ps(LF_EXP_MIN));
    __m256 i = _mm256_round_ps(_mm256_mul_ps(x, _mm256_set1_ps(LF_LOG2E)), _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
    __m256 f =
        _mm256_sub_ps(_mm256_sub_ps(x, _mm256_mul_ps(i, _mm256_set1_ps(LF_LN2_HI))), _mm256_mul_ps(i, _mm256_set1_ps(LF_LN2_LO)));
    __m256 p = _mm256_set1_ps(LF_EXP_C6);
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C5));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C4));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C3));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C2));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(1.0f));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(1.0f));
    __m256i bits = _mm256_slli_epi32(_mm256_add_epi32(_mm256_cvtps_epi32(i), _mm256_set1_epi32(127)), 23);
    return _mm256_mul_ps(p, _mm256_castsi256_ps(bits));
}

static float densities(int n, const float *scale, const float *tau, float *d)
{
    const __m256 inf = _mm256_set1_ps(INFINITY), zero = _mm256_setzero_ps();
    __m256 least = inf, sum = zero;
    for (int k = 0; k < n; k += LF_LANES) {
        __m256 on = _mm256_cmp_ps(_mm256_loadu_ps(scale + k), zero, _CMP_GT_OQ);
        least = _mm256_min_ps(least, _mm256_blendv_ps(inf, _mm256_loadu_ps(tau + k), on));
    }
    float lanes[LF_LANES], tau_min = INFINITY;
    _mm256_storeu_ps(lanes, least);
    for (int i = 0; i < LF_LANES; i++)
        tau_min = lf_min(tau_min, lanes[i]);
    if (!(tau_min < INFINITY)) {
        memset(d, 0, sizeof *d * (size_t)n);
        return 0.0f;
    }
    for (int k = 0; k < n; k += LF_LANES) {
        __m256 sc = _mm256_loadu_ps(scale + k);
        __m256 on = _mm256_cmp_ps(sc, zero, _CMP_GT_OQ);
        __m256 x = _mm256_min_ps(_mm256_sub_ps(_mm256_set1_ps(tau_min), _mm256_loadu_ps(tau + k)), zero);
        on = _mm256_and_ps(on, _mm256_cmp_ps(x, _mm256_set1_ps(LF_EXP_MIN), _CMP_GT_OQ));
        __m256 e = _mm256_and_ps(_mm256_mul_ps(sc, exp_kernel(x)), on);
        _mm256_storeu_ps(d + k, e);
        sum = _mm256_add_ps(sum, e);
    }
    _mm256_storeu_ps(lanes, sum);
    float total = lanes[0];
    for (int i = 1; i < LF_LANES; i++)
        total += lanes[i];
    return total;
}

const lf_kernels lf_kernels_avx2 = {.name = "avx2", .march = march, .densities = densities};

#else
typedef int lf_kernels_avx2_not_here;
#endif
