/* The kernels for AVX2, 8 lanes; no FMA, so that they equal kernel_c.c bit for bit. */
#if defined(__x86_64__)

#include <immintrin.h>
#include <string.h>

#include "render/plane/kernel.h"
#include "render/plane/kernel_exp.h"

/* row[i + offset], row[i + offset + 1] for 8 samples that lie within 8 or 16 of each other: loads
 * and permutations, half the time of two gathers. Lanes out of order by rounding fall outside too.
 */
static inline void neighbours(const float *row, __m256i i, __m256 *a, __m256 *b)
{
    int first = _mm256_extract_epi32(i, 0), last = _mm256_extract_epi32(i, 7),
        low = first < last ? first : last;
    __m256i off = _mm256_sub_epi32(i, _mm256_set1_epi32(low)),
            next = _mm256_add_epi32(off, _mm256_set1_epi32(1));
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
        *a = _mm256_blendv_ps(_mm256_permutevar8x32_ps(v, off), _mm256_permutevar8x32_ps(w, off),
                              upper_a);
        *b = _mm256_blendv_ps(_mm256_permutevar8x32_ps(v, next), _mm256_permutevar8x32_ps(w, next),
                              upper_b);
        return;
    }
    *a = _mm256_i32gather_ps(row, i, 4);
    *b = _mm256_i32gather_ps(row + 1, i, 4);
}

/* lf_slice_at for 8 lanes of one plane. */
static inline __m256 at(const lf_slice *slice, const float *row, __m256 x)
{
    __m256 g = _mm256_mul_ps(_mm256_sub_ps(x, _mm256_set1_ps(slice->x_min)),
                             _mm256_set1_ps(slice->inv_dx));
    g = _mm256_min_ps(_mm256_max_ps(g, _mm256_setzero_ps()),
                      _mm256_set1_ps((float)(slice->nx - 1)));
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
    return _mm256_blendv_ps(_mm256_sub_ps(_mm256_set1_ps(1.0f), tail), tail,
                            _mm256_cmp_ps(t, _mm256_setzero_ps(), _CMP_LT_OQ));
}

/* One group of 8 lanes. */
static inline void march8(const lf_slice *slice, const float *x0, const float *slope,
                          const float *z_end, float *tau, float *sigma)
{
    const __m256 vx = _mm256_loadu_ps(x0), vs = _mm256_loadu_ps(slope),
                 end = _mm256_loadu_ps(z_end), one = _mm256_set1_ps(1.0f);
    const __m256 zero = _mm256_setzero_ps(), inv_dz = _mm256_set1_ps(slice->inv_dz),
                 dz = _mm256_set1_ps(slice->dz);
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
        __m256 step =
            _mm256_max_ps(_mm256_sub_ps(share(t), _mm256_set1_ps(slice->behind[s])), zero);
        depth = _mm256_add_ps(depth, _mm256_mul_ps(v, _mm256_mul_ps(dz, step)));
        density = _mm256_add_ps(density, _mm256_mul_ps(v, _mm256_sub_ps(one, absolute(t))));
    }
    _mm256_storeu_ps(tau, depth);
    if (sigma)
        _mm256_storeu_ps(sigma, density);
}

static void march(const lf_slice *slice, int n, const float *x0, const float *slope,
                  const float *z_end, float *tau, float *sigma)
{
    for (int k = 0; k < n; k += LF_LANES)
        march8(slice, x0 + k, slope + k, z_end + k, tau + k, sigma ? sigma + k : NULL);
}

/* One group of 8 lanes. */
static inline void moments8(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                            float *const sums[3], int k)
{
    const float *x0 = rays->x0, *slope = rays->slope, *z_end = rays->z_end;
    const __m256 vx = _mm256_loadu_ps(x0 + k), vs = _mm256_loadu_ps(slope + k),
                 end = _mm256_loadu_ps(z_end + k), one = _mm256_set1_ps(1.0f),
                 half = _mm256_set1_ps(0.5f), zero = _mm256_setzero_ps(),
                 dz = _mm256_set1_ps(slice->dz), inv_dz = _mm256_set1_ps(slice->inv_dz),
                 per_z = _mm256_loadu_ps(rays->length + k);
    __m256 depth = _mm256_loadu_ps(tau + k), rest = one, lost = zero, near = zero, square = zero;
    float z_min = z_end[k], z_max = z_end[k];
    for (int i = k + 1; i < k + LF_LANES; i++) {
        z_min = lf_min(z_min, z_end[i]);
        z_max = lf_max(z_max, z_end[i]);
    }
    for (int s = slice->first; s <= slice->last; s++) {
        float z = slice->z0 + (float)s * slice->dz;
        if (z - slice->dz >= z_max)
            break;
        float xa = x0[k] + slope[k] * z, xb = x0[k + LF_LANES - 1] + slope[k + LF_LANES - 1] * z,
              y = lf_nearness(rays->distance, z);
        if (lf_max(xa, xb) <= slice->spans[s].x_lo || lf_min(xa, xb) >= slice->spans[s].x_hi)
            continue;
        const float *row = slice->sigma + (size_t)s * (size_t)slice->stride;
        __m256 v = at(slice, row, _mm256_add_ps(vx, _mm256_mul_ps(vs, _mm256_set1_ps(z)))), step;
        if (z + slice->dz <= z_min) {
            step = _mm256_set1_ps(slice->dz * lf_max(1.0f - slice->behind[s], 0.0f));
        } else {
            __m256 t = _mm256_mul_ps(_mm256_sub_ps(end, _mm256_set1_ps(z)), inv_dz);
            t = _mm256_min_ps(_mm256_max_ps(t, _mm256_set1_ps(-1.0f)), one);
            step = _mm256_sub_ps(share(t), _mm256_set1_ps(slice->behind[s]));
            step = _mm256_mul_ps(dz, _mm256_max_ps(step, zero));
        }
        step = _mm256_mul_ps(v, step);
        depth = _mm256_add_ps(depth, step);
        __m256 x = _mm256_mul_ps(step, per_z);
        x = _mm256_add_ps(one, _mm256_mul_ps(x, _mm256_add_ps(one, _mm256_mul_ps(half, x))));
        __m256 behind = _mm256_div_ps(rest, x), w = _mm256_sub_ps(rest, behind);
        rest = behind;
        lost = _mm256_add_ps(lost, w);
        near = _mm256_add_ps(near, _mm256_mul_ps(w, _mm256_set1_ps(y)));
        square = _mm256_add_ps(square, _mm256_mul_ps(w, _mm256_set1_ps(y * y)));
    }
    _mm256_storeu_ps(tau + k, depth);
    _mm256_storeu_ps(sums[0] + k, lost);
    _mm256_storeu_ps(sums[1] + k, near);
    _mm256_storeu_ps(sums[2] + k, square);
}

static void moments(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                    float *const sums[3])
{
    for (int k = 0; k < rays->n; k += LF_LANES)
        moments8(slice, rays, tau, sums, k);
}

/* Two consecutive 16-bit values at each of 8 positions. */
static inline void pairs8(const uint16_t *shorts, __m256i from, __m256 scale, __m256 *a, __m256 *b)
{
    __m256i both = _mm256_i32gather_epi32((const int *)shorts, from, 2);
    *a = _mm256_mul_ps(_mm256_castsi256_ps(_mm256_srli_epi32(_mm256_slli_epi32(both, 16), 3)),
                       scale);
    *b = _mm256_mul_ps(_mm256_castsi256_ps(_mm256_slli_epi32(_mm256_srli_epi32(both, 16), 13)),
                       scale);
}

/* lf_grid_value times sigma_scale for 8 points of a line. */
static inline __m256 sample8(const lf_volume *volume, const lf_line *line, __m256 x, bool is_short)
{
    const lf_grid *grid = volume->grid;
    const __m256i seven = _mm256_set1_epi32(LF_BRICK - 1);
    __m256 t[3], here = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    __m256i brick = _mm256_setzero_si256(), cell = brick;
    for (int i = 2; i >= 0; i--) {
        __m256 p = _mm256_add_ps(_mm256_set1_ps(line->origin[i]),
                                 _mm256_mul_ps(x, _mm256_set1_ps(line->across[i])));
        here = _mm256_and_ps(here, _mm256_cmp_ps(p, _mm256_set1_ps(-1.0f), _CMP_GT_OQ));
        here =
            _mm256_and_ps(here, _mm256_cmp_ps(p, _mm256_set1_ps((float)grid->size[i]), _CMP_LT_OQ));
        /* -1 there */
        __m256i below = _mm256_castps_si256(_mm256_cmp_ps(p, _mm256_setzero_ps(), _CMP_LT_OQ));
        __m256i c = _mm256_add_epi32(_mm256_cvttps_epi32(p), below);
        t[i] = _mm256_sub_ps(p, _mm256_cvtepi32_ps(c));
        c = _mm256_add_epi32(c, _mm256_set1_epi32(1));
        brick = _mm256_add_epi32(_mm256_mullo_epi32(brick, _mm256_set1_epi32(grid->bricks[i])),
                                 _mm256_srli_epi32(c, 3));
        cell = _mm256_add_epi32(_mm256_mullo_epi32(cell, _mm256_set1_epi32(LF_BRICK_VALUES)),
                                _mm256_and_si256(c, seven));
    }
    __m256i mask = _mm256_castps_si256(here);
    __m256i number =
        _mm256_i32gather_epi32((const int *)grid->index, _mm256_and_si256(brick, mask), 4);
    __m256i from =
        _mm256_add_epi32(_mm256_mullo_epi32(number, _mm256_set1_epi32(LF_BRICK_STRIDE)), cell);
    from = _mm256_and_si256(from, mask);
    __m256 v[4];
    for (int i = 0; i < 4; i++) {
        int line_at = lf_in_brick(0, i & 1, i >> 1);
        __m256 a, b;
        if (is_short) {
            pairs8(grid->shorts + line_at, from, _mm256_set1_ps(grid->short_scale), &a, &b);
        } else {
            a = _mm256_i32gather_ps(grid->values + line_at, from, 4);
            b = _mm256_i32gather_ps(grid->values + line_at + 1, from, 4);
        }
        v[i] = _mm256_add_ps(a, _mm256_mul_ps(t[0], _mm256_sub_ps(b, a)));
    }
    __m256 a = _mm256_add_ps(v[0], _mm256_mul_ps(t[1], _mm256_sub_ps(v[1], v[0])));
    __m256 b = _mm256_add_ps(v[2], _mm256_mul_ps(t[1], _mm256_sub_ps(v[3], v[2])));
    __m256 value = _mm256_add_ps(a, _mm256_mul_ps(t[2], _mm256_sub_ps(b, a)));
    return _mm256_mul_ps(_mm256_set1_ps(volume->sigma_scale), _mm256_and_ps(value, here));
}

static void sample(const lf_volume *volume, const lf_line *line, int n, const float *x,
                   float *sigma)
{
    bool is_short = !volume->grid->values;
    for (int k = 0; k < n && !is_short; k += LF_LANES)
        _mm256_storeu_ps(sigma + k, sample8(volume, line, _mm256_loadu_ps(x + k), false));
    for (int k = 0; k < n && is_short; k += LF_LANES)
        _mm256_storeu_ps(sigma + k, sample8(volume, line, _mm256_loadu_ps(x + k), true));
}

static inline void compare8(const lf_probe *probe, const float *x0, const float *slope,
                            const float *z_end, float *factor, bool is_short)
{
    const lf_slice *slice = probe->slice;
    const __m256 x = _mm256_loadu_ps(x0), s = _mm256_loadu_ps(slope), one = _mm256_set1_ps(1.0f);
    const __m256 depth = _mm256_set1_ps(probe->z);
    __m256 density = _mm256_setzero_ps();
    float t;
    int plane = lf_slice_plane(slice, probe->z, &t);
    for (int i = 0; i < 2; i++) {
        if (plane + i < 0 || plane + i >= slice->nz)
            continue;
        float z = slice->z0 + (float)(plane + i) * slice->dz;
        const float *row = slice->sigma + (size_t)(plane + i) * (size_t)slice->stride;
        __m256 v = at(slice, row, _mm256_add_ps(x, _mm256_mul_ps(s, _mm256_set1_ps(z))));
        density = _mm256_add_ps(density, _mm256_mul_ps(_mm256_set1_ps(i ? t : 1.0f - t), v));
    }
    __m256 truth =
        sample8(probe->volume, &probe->line, _mm256_add_ps(x, _mm256_mul_ps(s, depth)), is_short);
    __m256 length = _mm256_sqrt_ps(_mm256_add_ps(_mm256_set1_ps(probe->my2), _mm256_mul_ps(s, s)));
    __m256 off = _mm256_mul_ps(_mm256_mul_ps(_mm256_sub_ps(truth, density), length),
                               _mm256_set1_ps(probe->inverse));
    __m256 reached = _mm256_cmp_ps(depth, _mm256_loadu_ps(z_end), _CMP_LT_OQ);
    __m256 ratio = _mm256_blendv_ps(one, _mm256_sub_ps(one, off), reached);
    _mm256_storeu_ps(factor, _mm256_mul_ps(_mm256_loadu_ps(factor), ratio));
}

static void compare(const lf_probe *probe, int n, const float *x0, const float *slope,
                    const float *z_end, float *factor)
{
    bool is_short = !probe->volume->grid->values;
    for (int k = 0; k < n && !is_short; k += LF_LANES)
        compare8(probe, x0 + k, slope + k, z_end + k, factor + k, false);
    for (int k = 0; k < n && is_short; k += LF_LANES)
        compare8(probe, x0 + k, slope + k, z_end + k, factor + k, true);
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

static inline __m256 exp_kernel(__m256 x)
{
    x = _mm256_max_ps(x, _mm256_set1_ps(LF_EXP_MIN));
    __m256 i = _mm256_round_ps(_mm256_mul_ps(x, _mm256_set1_ps(LF_LOG2E)),
                               _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
    __m256 f = _mm256_sub_ps(_mm256_sub_ps(x, _mm256_mul_ps(i, _mm256_set1_ps(LF_LN2_HI))),
                             _mm256_mul_ps(i, _mm256_set1_ps(LF_LN2_LO)));
    __m256 p = _mm256_set1_ps(LF_EXP_C6);
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C5));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C4));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C3));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(LF_EXP_C2));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(1.0f));
    p = _mm256_add_ps(_mm256_mul_ps(p, f), _mm256_set1_ps(1.0f));
    __m256i bits =
        _mm256_slli_epi32(_mm256_add_epi32(_mm256_cvtps_epi32(i), _mm256_set1_epi32(127)), 23);
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
        __m256 x =
            _mm256_min_ps(_mm256_sub_ps(_mm256_set1_ps(tau_min), _mm256_loadu_ps(tau + k)), zero);
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

const lf_kernels lf_kernels_avx2 = {.name = "avx2",
                                    .march = march,
                                    .moments = moments,
                                    .through = through,
                                    .within = within,
                                    .sample = sample,
                                    .compare = compare,
                                    .densities = densities,
                                    .suffixes = &lf_suffixes_avx2,
                                    .fans = &lf_fans_avx2,
                                    .surfaces = &lf_surface_fans_avx2};

#else
typedef int lf_kernels_avx2_not_here;
#endif
