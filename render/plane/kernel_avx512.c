/* The marches for AVX-512, 16 lanes; the rest is AVX2's. No FMA, so that results equal kernel_c.c
 * bit for bit. What kernel_c.c skips for a group of 8 rays is skipped here for that half. */
#if defined(__x86_64__)

#include <immintrin.h>

#include "render/plane/kernel.h"

enum { WIDTH = 16, HALVES = 2 };

/* row[i], row[i + 1] for 16 samples within 16 or 32 of each other: loads and permutations instead
 * of two gathers. Lanes that are out of order by rounding use the fallback. */
static inline void neighbours(const float *row, __m512i i, __m512 *a, __m512 *b)
{
    int first = _mm512_cvtsi512_si32(i),
        last = _mm_extract_epi32(_mm512_extracti32x4_epi32(i, 3), 3),
        low = first < last ? first : last;
    __m512i off = _mm512_sub_epi32(i, _mm512_set1_epi32(low)),
            next = _mm512_add_epi32(off, _mm512_set1_epi32(1));
    if (!_mm512_cmpgt_epu32_mask(off, _mm512_set1_epi32(WIDTH - 2))) {
        __m512 v = _mm512_loadu_ps(row + low);
        *a = _mm512_permutexvar_ps(off, v);
        *b = _mm512_permutexvar_ps(next, v);
    } else if (!_mm512_cmpgt_epu32_mask(off, _mm512_set1_epi32(2 * WIDTH - 2))) {
        __m512 v = _mm512_loadu_ps(row + low), w = _mm512_loadu_ps(row + low + WIDTH);
        *a = _mm512_permutex2var_ps(v, off, w);
        *b = _mm512_permutex2var_ps(v, next, w);
    } else {
        *a = _mm512_i32gather_ps(i, row, 4);
        *b = _mm512_i32gather_ps(i, row + 1, 4);
    }
}

/* lf_slice_at for 16 lanes of one plane. */
static inline __m512 at(const lf_slice *slice, const float *row, __m512 x)
{
    __m512 g = _mm512_mul_ps(_mm512_sub_ps(x, _mm512_set1_ps(slice->x_min)),
                             _mm512_set1_ps(slice->inv_dx));
    g = _mm512_min_ps(_mm512_max_ps(g, _mm512_setzero_ps()),
                      _mm512_set1_ps((float)(slice->nx - 1)));
    __m512i i = _mm512_cvttps_epi32(g);
    __m512 a, b;
    neighbours(row, i, &a, &b);
    __m512 f = _mm512_sub_ps(g, _mm512_cvtepi32_ps(i));
    return _mm512_add_ps(a, _mm512_mul_ps(f, _mm512_sub_ps(b, a)));
}

/* lf_slice_share for 16 lanes. */
static inline __m512 share(__m512 t)
{
    __m512 rest = _mm512_sub_ps(_mm512_set1_ps(1.0f), _mm512_abs_ps(t));
    __m512 tail = _mm512_mul_ps(_mm512_mul_ps(_mm512_set1_ps(0.5f), rest), rest);
    return _mm512_mask_blend_ps(_mm512_cmp_ps_mask(t, _mm512_setzero_ps(), _CMP_LT_OQ),
                                _mm512_sub_ps(_mm512_set1_ps(1.0f), tail), tail);
}

/* 16 rays, with the first and last end of each half. */
typedef struct group {
    __m512 x, s, end;
    const float *x0, *slope;
    float least[HALVES], farthest[HALVES];
} group;

static inline group make_group(const float *x0, const float *slope, const float *z_end)
{
    group g = {.x = _mm512_loadu_ps(x0),
               .s = _mm512_loadu_ps(slope),
               .end = _mm512_loadu_ps(z_end),
               .x0 = x0,
               .slope = slope};
    for (int h = 0; h < HALVES; h++) {
        const float *end = z_end + LF_LANES * h;
        g.least[h] = g.farthest[h] = end[0];
        for (int k = 1; k < LF_LANES; k++) {
            g.least[h] = lf_min(g.least[h], end[k]);
            g.farthest[h] = lf_max(g.farthest[h], end[k]);
        }
    }
    return g;
}

/* Bits of a half's lanes. */
static inline __mmask16 half(int h)
{
    return (__mmask16)(0xffu << LF_LANES * h);
}

/* Lanes of halves that reach the plane at z, if there is anything between them. */
static inline __mmask16 reach(const group *g, const lf_slice *slice, int plane, float z)
{
    __mmask16 lanes = 0;
    for (int h = 0; h < HALVES; h++) {
        const int a = LF_LANES * h, b = a + LF_LANES - 1;
        float xa = g->x0[a] + g->slope[a] * z, xb = g->x0[b] + g->slope[b] * z;
        bool beside = lf_max(xa, xb) <= slice->spans[plane].x_lo ||
                      lf_min(xa, xb) >= slice->spans[plane].x_hi;
        if (!beside && !(z - slice->dz >= g->farthest[h]))
            lanes |= half(h);
    }
    return lanes;
}

/* Lanes of halves that continue beyond the plane's cell. */
static inline __mmask16 beyond(const group *g, const lf_slice *slice, float z)
{
    __mmask16 lanes = 0;
    for (int h = 0; h < HALVES; h++)
        if (z + slice->dz <= g->least[h])
            lanes |= half(h);
    return lanes;
}

/* How far in units of dz the plane lies before the rays' ends, -1..1. */
static inline __m512 before_end(const group *g, const lf_slice *slice, float z, __mmask16 on)
{
    const __m512 one = _mm512_set1_ps(1.0f);
    __m512 t =
        _mm512_mul_ps(_mm512_sub_ps(g->end, _mm512_set1_ps(z)), _mm512_set1_ps(slice->inv_dz));
    t = _mm512_min_ps(_mm512_max_ps(t, _mm512_set1_ps(-1.0f)), one);
    return _mm512_mask_blend_ps(on, t, one);
}

/* The length that a plane represents. */
static inline __m512 length_of(const lf_slice *slice, int plane, __m512 t)
{
    __m512 seen = _mm512_sub_ps(share(t), _mm512_set1_ps(slice->behind[plane]));
    return _mm512_mul_ps(_mm512_set1_ps(slice->dz), _mm512_max_ps(seen, _mm512_setzero_ps()));
}

static inline __m512 values(const group *g, const lf_slice *slice, int plane, float z,
                            __mmask16 lanes)
{
    const float *row = slice->sigma + (size_t)plane * (size_t)slice->stride;
    __m512 x = _mm512_add_ps(g->x, _mm512_mul_ps(g->s, _mm512_set1_ps(z)));
    return _mm512_maskz_mov_ps(lanes, at(slice, row, x));
}

static inline void march16(const lf_slice *slice, const float *x0, const float *slope,
                           const float *z_end, float *tau, float *sigma)
{
    const __m512 one = _mm512_set1_ps(1.0f);
    const group g = make_group(x0, slope, z_end);
    __m512 depth = _mm512_loadu_ps(tau), density = _mm512_setzero_ps();
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz;
        if (z - slice->dz >= lf_max(g.farthest[0], g.farthest[1]))
            break;
        __mmask16 lanes = reach(&g, slice, s, z), on = beyond(&g, slice, z);
        if (!lanes)
            continue;
        __m512 v = values(&g, slice, s, z, lanes);
        if (on == 0xffff) {
            float step = slice->dz * lf_max(1.0f - slice->behind[s], 0.0f);
            depth = _mm512_add_ps(depth, _mm512_mul_ps(v, _mm512_set1_ps(step)));
            continue;
        }
        __m512 t = before_end(&g, slice, z, on);
        depth = _mm512_add_ps(depth, _mm512_mul_ps(v, length_of(slice, s, t)));
        density = _mm512_add_ps(density, _mm512_mul_ps(v, _mm512_sub_ps(one, _mm512_abs_ps(t))));
    }
    _mm512_storeu_ps(tau, depth);
    if (sigma)
        _mm512_storeu_ps(sigma, density);
}

static void march(const lf_slice *slice, int n, const float *x0, const float *slope,
                  const float *z_end, float *tau, float *sigma)
{
    int k = 0;
    for (; k + WIDTH <= n; k += WIDTH)
        march16(slice, x0 + k, slope + k, z_end + k, tau + k, sigma ? sigma + k : NULL);
    if (k < n)
        lf_kernels_avx2.march(slice, n - k, x0 + k, slope + k, z_end + k, tau + k,
                              sigma ? sigma + k : NULL);
}

static inline void moments16(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                             float *const sums[3], int k)
{
    const __m512 one = _mm512_set1_ps(1.0f), zero = _mm512_setzero_ps(),
                 per_z = _mm512_loadu_ps(rays->length + k);
    const group g = make_group(rays->x0 + k, rays->slope + k, rays->z_end + k);
    __m512 depth = _mm512_loadu_ps(tau + k), rest = one, lost = zero, near = zero, square = zero;
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz, y = lf_nearness(rays->distance, z);
        if (z - slice->dz >= lf_max(g.farthest[0], g.farthest[1]))
            break;
        __mmask16 lanes = reach(&g, slice, s, z), on = beyond(&g, slice, z);
        if (!lanes)
            continue;
        __m512 v = values(&g, slice, s, z, lanes);
        __m512 t = on == 0xffff ? one : before_end(&g, slice, z, on);
        __m512 step = _mm512_mul_ps(v, length_of(slice, s, t));
        depth = _mm512_add_ps(depth, step);
        __m512 x = _mm512_mul_ps(step, per_z);
        __m512 more = _mm512_add_ps(one, _mm512_mul_ps(_mm512_set1_ps(0.5f), x));
        x = _mm512_add_ps(one, _mm512_mul_ps(x, more));
        __m512 behind = _mm512_div_ps(rest, x), w = _mm512_sub_ps(rest, behind);
        rest = behind;
        lost = _mm512_add_ps(lost, w);
        near = _mm512_add_ps(near, _mm512_mul_ps(w, _mm512_set1_ps(y)));
        square = _mm512_add_ps(square, _mm512_mul_ps(w, _mm512_set1_ps(y * y)));
    }
    _mm512_storeu_ps(tau + k, depth);
    _mm512_storeu_ps(sums[0] + k, lost);
    _mm512_storeu_ps(sums[1] + k, near);
    _mm512_storeu_ps(sums[2] + k, square);
}

static void moments(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                    float *const sums[3])
{
    int k = 0;
    for (; k + WIDTH <= rays->n; k += WIDTH)
        moments16(slice, rays, tau, sums, k);
    float *const sums_left[3] = {sums[0] + k, sums[1] + k, sums[2] + k};
    const lf_feature_rays left = {.n = rays->n - k,
                                  .x0 = rays->x0 + k,
                                  .slope = rays->slope + k,
                                  .z_end = rays->z_end + k,
                                  .length = rays->length + k,
                                  .distance = rays->distance};
    if (left.n > 0)
        lf_kernels_avx2.moments(slice, &left, tau + k, sums_left);
}

static void through(const lf_body *body, int n, const float *x0, const float *slope,
                    const float *z_end, float *tau)
{
    lf_kernels_avx2.through(body, n, x0, slope, z_end, tau);
}

static void within(const lf_body *body, const lf_feature_rays *rays, float *tau,
                   float *const out[3])
{
    lf_kernels_avx2.within(body, rays, tau, out);
}

static void sample(const lf_volume *volume, const lf_line *line, int n, const float *x,
                   float *sigma)
{
    lf_kernels_avx2.sample(volume, line, n, x, sigma);
}

static void compare(const lf_probe *probe, int n, const float *x0, const float *slope,
                    const float *z_end, float *factor)
{
    lf_kernels_avx2.compare(probe, n, x0, slope, z_end, factor);
}

static float densities(int n, const float *scale, const float *tau, float *d)
{
    return lf_kernels_avx2.densities(n, scale, tau, d);
}

const lf_kernels lf_kernels_avx512 = {.name = "avx512",
                                      .march = march,
                                      .moments = moments,
                                      .through = through,
                                      .within = within,
                                      .sample = sample,
                                      .compare = compare,
                                      .densities = densities,
                                      .suffixes = &lf_suffixes_avx512,
                                      .fans = &lf_fans_avx2,
                                      .surfaces = &lf_surface_fans_avx512};

#else
typedef int lf_kernels_avx512_not_here;
#endif
