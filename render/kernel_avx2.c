/* The kernels for AVX2, 8 lanes; no FMA, so that they equal kernel_c.c bit for bit. */
#if defined(__x86_64__)

#include <immintrin.h>
#include <string.h>

#include "render/kernel.h"
#include "render/kernel_exp.h"

/* row[i + offset], row[i + offset + 1] for 8 samples that lie within 8 or 16 of each other: loads and permutations, half the time of
 * two gathers. Lanes out of order by rounding fall outside too. */
static inline void neighbours(const float *row, __m256i i, __m256 *a, __m256 *b)
{
    int first = _mm256_extract_epi32(i, 0), last = _mm256_extract_epi32(i, 7), low = first < last ? first : last;
    __m256i off = _mm256_sub_epi32(i, _mm256_set1_epi32(low)), next = _mm256_add_epi32(off, _mm256_set1_epi32(1));
    __m256i farthest = _mm256_max_epu32(off, _mm256_set1_epi32(6));
    __m256 v = _mm256_loadu_ps(row + low);
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi32(farthest, _mm256_set1_epi32(6))) == -1) {
        *a = _mm256_permutevar8x32_ps(v, off);
        *b = _mm256_permutevar8x32_ps(v, next);
        return;
    }
    farthest = _mm256_max_epu32(off, _mm256_set1_epi32(14));
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi32(farthest, _mm256_set1_epi32(14))) == -1) {
        __m256 w = _mm256_loadu_ps(row + low + LF_LANES);
        __m256 upper_a = _mm256_castsi256_ps(_mm256_slli_epi32(off, 28)),
               upper_b = _mm256_castsi256_ps(_mm256_slli_epi32(next, 28));
        *a = _mm256_blendv_ps(_mm256_permutevar8x32_ps(v, off), _mm256_permutevar8x32_ps(w, off), upper_a);
        *b = _mm256_blendv_ps(_mm256_permutevar8x32_ps(v, next), _mm256_permutevar8x32_ps(w, next), upper_b);
        return;
    }
    *a = _mm256_i32gather_ps(row, i, 4);
    *b = _mm256_i32gather_ps(row + 1, i, 4);
}

/* lf_slice_at for 8 lanes of one plane. */
static inline __m256 at(const lf_slice *slice, const float *row, __m256 x)
{
    __m256 g = _mm256_mul_ps(_mm256_sub_ps(x, _mm256_set1_ps(slice->x_min)), _mm256_set1_ps(slice->inv_dx));
    g = _mm256_min_ps(_mm256_max_ps(g, _mm256_setzero_ps()), _mm256_set1_ps((float)(slice->nx - 1)));
    __m256i i = _mm256_cvttps_epi32(g);
    __m256 a, b;
    neighbours(row, i, &a, &b);
    __m256 f = _mm256_sub_ps(g, _mm256_cvtepi32_ps(i));
    return _mm256_add_ps(a, _mm256_mul_ps(f, _mm256_sub_ps(b, a)));
}

static inline __m256 absolute(__m256 x)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), x);
}

/* lf_slice_share for 8 lanes. */
static inline __m256 share(__m256 t)
{
    __m256 rest = _mm256_sub_ps(_mm256_set1_ps(1.0f), absolute(t));
    __m256 tail = _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(0.5f), rest), rest);
    return _mm256_blendv_ps(_mm256_sub_ps(_mm256_set1_ps(1.0f), tail), tail, _mm256_cmp_ps(t, _mm256_setzero_ps(), _CMP_LT_OQ));
}

/* One group of 8 lanes. */
static inline void march8(const lf_slice *slice, const float *x0, const float *slope, const float *z_end, float *tau, float *sigma)
{
    const __m256 vx = _mm256_loadu_ps(x0), vs = _mm256_loadu_ps(slope), end = _mm256_loadu_ps(z_end), one = _mm256_set1_ps(1.0f);
    const __m256 zero = _mm256_setzero_ps(), inv_dz = _mm256_set1_ps(slice->inv_dz), dz = _mm256_set1_ps(slice->dz);
    __m256 depth = _mm256_loadu_ps(tau), density = zero;
    float z_min = z_end[0], z_max = z_end[0];
    for (int k = 1; k < LF_LANES; k++) {
        z_min = lf_min(z_min, z_end[k]);
        z_max = lf_max(z_max, z_end[k]);
    }
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz;
        if (z - slice->dz >= z_max)
            break;
        float xa = x0[0] + slope[0] * z, xb = x0[LF_LANES - 1] + slope[LF_LANES - 1] * z;
        if (lf_max(xa, xb) <= slice->spans[s].x_lo || lf_min(xa, xb) >= slice->spans[s].x_hi)
            continue;
        const float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
        __m256 v = at(slice, row, _mm256_add_ps(vx, _mm256_mul_ps(vs, _mm256_set1_ps(z))));
        if (z + slice->dz <= z_min) {
            float step = slice->dz * lf_max(1.0f - slice->behind[s], 0.0f);
            depth = _mm256_add_ps(depth, _mm256_mul_ps(v, _mm256_set1_ps(step)));
            continue;
        }
        __m256 t = _mm256_mul_ps(_mm256_sub_ps(end, _mm256_set1_ps(z)), inv_dz);
        t = _mm256_min_ps(_mm256_max_ps(t, _mm256_set1_ps(-1.0f)), one);
        __m256 step = _mm256_max_ps(_mm256_sub_ps(share(t), _mm256_set1_ps(slice->behind[s])), zero);
        depth = _mm256_add_ps(depth, _mm256_mul_ps(v, _mm256_mul_ps(dz, step)));
        density = _mm256_add_ps(density, _mm256_mul_ps(v, _mm256_sub_ps(one, absolute(t))));
    }
    _mm256_storeu_ps(tau, depth);
    if (sigma)
        _mm256_storeu_ps(sigma, density);
}

static void march(const lf_slice *slice, int n, const float *x0, const float *slope, const float *z_end, float *tau, float *sigma)
{
    for (int k = 0; k < n; k += LF_LANES)
        march8(slice, x0 + k, slope + k, z_end + k, tau + k, sigma ? sigma + k : NULL);
}

static void through(const lf_body *body, int n, const float *x0, const float *slope, const float *z_end, float *tau)
{
    lf_body_depths(body, n, x0, slope, z_end, tau);
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

const lf_kernels lf_kernels_avx2 = {.name = "avx2", .march = march, .through = through, .densities = densities};

#else
typedef int lf_kernels_avx2_not_here;
#endif
