/* Lanes: LF_WIDTH floats, integers and truth values in SIMD, with operations that GCC's vectors
 * lack; private to the suffix_*.c, fan_*.c and depth_*.c. A file includes lanes_avx2.h or defines
 * LF_LANES_AVX512 before it includes this header. Otherwise there are 4 lanes, compiled for the
 * target (SSE2, NEON). Every operation gives a lane bitwise the same result for every width. All
 * are exact or rounded once, no reciprocals are approximated, and logarithm, sine and cosine are
 * implemented here. Nothing is summed across lanes. */
#ifndef LF_RENDER_LANES_H
#define LF_RENDER_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "render/scene/vec.h"

#if defined(LF_LANES_AVX512)
#include <immintrin.h>
enum { LF_WIDTH = 16 };
#elif defined(LF_LANES_AVX2)
#include <immintrin.h>
enum { LF_WIDTH = 8 };
#else
enum { LF_WIDTH = 4 };
#endif

typedef float lanes __attribute__((vector_size(4 * LF_WIDTH), may_alias));
typedef int32_t lanes_int __attribute__((vector_size(4 * LF_WIDTH), may_alias));
typedef uint32_t lanes_bits __attribute__((vector_size(4 * LF_WIDTH), may_alias));

#define LF_INLINE static inline __attribute__((always_inline))

LF_INLINE lanes all(float x)
{
    return x - (lanes){0};
}
LF_INLINE lanes_int all_int(int32_t x)
{
    return x - (lanes_int){0};
}

/* ------------------------------------------------------------------------------------- masks -- */

#if defined(LF_LANES_AVX512)
typedef __mmask16 mask;

LF_INLINE mask is_less(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
}
LF_INLINE mask is_at_most(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
}
LF_INLINE lanes choose(mask m, lanes a, lanes b)
{
    return (lanes)_mm512_mask_blend_ps(m, (__m512)b, (__m512)a);
}
LF_INLINE lanes_int choose_int(mask m, lanes_int a, lanes_int b)
{
    return (lanes_int)_mm512_mask_blend_epi32(m, (__m512i)b, (__m512i)a);
}
LF_INLINE unsigned bits_of(mask m)
{
    return m;
}
LF_INLINE mask mask_of(unsigned bits)
{
    return (mask)bits;
}
#else
/* All bits of a lane are 1, or all are 0. */
typedef lanes_int mask;

LF_INLINE mask is_less(lanes a, lanes b)
{
    return (mask)(a < b);
}
LF_INLINE mask is_at_most(lanes a, lanes b)
{
    return (mask)(a <= b);
}
#if defined(LF_LANES_AVX2)
LF_INLINE lanes choose(mask m, lanes a, lanes b)
{
    return (lanes)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)m);
}
LF_INLINE lanes_int choose_int(mask m, lanes_int a, lanes_int b)
{
    return (lanes_int)choose(m, (lanes)a, (lanes)b);
}
LF_INLINE unsigned bits_of(mask m)
{
    return (unsigned)_mm256_movemask_ps((__m256)m);
}
#else
LF_INLINE lanes_int choose_int(mask m, lanes_int a, lanes_int b)
{
    return (a & m) | (b & ~m);
}
LF_INLINE lanes choose(mask m, lanes a, lanes b)
{
    return (lanes)choose_int(m, (lanes_int)a, (lanes_int)b);
}
LF_INLINE unsigned bits_of(mask m)
{
    unsigned bits = 0;
    for (int i = 0; i < LF_WIDTH; i++)
        bits |= (unsigned)(m[i] & 1) << i;
    return bits;
}
#endif
LF_INLINE mask mask_of(unsigned bits)
{
    mask m = {0};
    for (int i = 0; i < LF_WIDTH; i++)
        m[i] = -(int32_t)(bits >> i & 1u);
    return m;
}
#endif

LF_INLINE mask both(mask a, mask b)
{
    return (mask)(a & b);
}
LF_INLINE mask either(mask a, mask b)
{
    return (mask)(a | b);
}
LF_INLINE mask without(mask a, mask b)
{
    return (mask)(a & ~b);
}
LF_INLINE int count_of(mask m)
{
    return __builtin_popcount(bits_of(m));
}

/* -------------------------------------------------------------------------------- arithmetic -- */

/* Returns b if either is NaN, as lf_min and lf_max. */
LF_INLINE lanes least(lanes a, lanes b)
{
#if defined(LF_LANES_AVX512)
    return (lanes)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined(LF_LANES_AVX2)
    return (lanes)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return choose(is_less(a, b), a, b);
#endif
}
LF_INLINE lanes most(lanes a, lanes b)
{
#if defined(LF_LANES_AVX512)
    return (lanes)_mm512_max_ps((__m512)a, (__m512)b);
#elif defined(LF_LANES_AVX2)
    return (lanes)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return choose(is_less(b, a), a, b);
#endif
}
LF_INLINE lanes root(lanes a)
{
#if defined(LF_LANES_AVX512)
    return (lanes)_mm512_sqrt_ps((__m512)a);
#elif defined(LF_LANES_AVX2)
    return (lanes)_mm256_sqrt_ps((__m256)a);
#else
    lanes r = a;
    for (int i = 0; i < LF_WIDTH; i++)
        r[i] = sqrtf(a[i]);
    return r;
#endif
}
/* Rounds towards 0; a must fit an integer in every lane that is used. */
LF_INLINE lanes_int to_int(lanes a)
{
#if defined(LF_LANES_AVX512)
    return (lanes_int)_mm512_cvttps_epi32((__m512)a);
#elif defined(LF_LANES_AVX2)
    return (lanes_int)_mm256_cvttps_epi32((__m256)a);
#else
    return __builtin_convertvector(a, lanes_int);
#endif
}
LF_INLINE lanes to_float(lanes_int a)
{
    return __builtin_convertvector(a, lanes);
}
LF_INLINE lanes bits_to_float(lanes_bits a)
{
#if defined(LF_LANES_AVX512)
    return (lanes)_mm512_cvtepu32_ps((__m512i)a);
#else
    return __builtin_convertvector(a, lanes);
#endif
}
LF_INLINE lanes magnitude(lanes a)
{
    return (lanes)((lanes_int)a & 0x7fffffff);
}
/* lf_lerp */
LF_INLINE lanes between(lanes a, lanes b, lanes f)
{
    return a + f * (b - a);
}

/* 1 / a; for 0 a very large number. */
LF_INLINE lanes inverse_of(lanes a)
{
    return 1.0f / choose(is_less(magnitude(a), all(1e-20f)), all(1e-20f), a);
}

/* ------------------------------------------------------------------------------------ memory -- */

LF_INLINE lanes load(const float *from)
{
    lanes out;
    memcpy(&out, from, sizeof out);
    return out;
}
LF_INLINE lanes_int load_int(const int32_t *from)
{
    lanes_int out;
    memcpy(&out, from, sizeof out);
    return out;
}
/* 0, 1, 2 … */
LF_INLINE lanes_int count_up(void)
{
    lanes_int out;
    for (int k = 0; k < LF_WIDTH; k++)
        out[k] = k;
    return out;
}
/* 32-bit words at p + 4 i bytes; i must be in range in all lanes. */
LF_INLINE lanes_int gather_int(const void *p, lanes_int i)
{
#if defined(LF_LANES_AVX512)
    return (lanes_int)_mm512_i32gather_epi32((__m512i)i, p, 4);
#elif defined(LF_LANES_AVX2)
    return (lanes_int)_mm256_i32gather_epi32(p, (__m256i)i, 4);
#else
    lanes_int r = i;
    for (int k = 0; k < LF_WIDTH; k++) {
        int32_t word;
        memcpy(&word, (const char *)p + 4 * (int64_t)i[k], sizeof word);
        r[k] = word;
    }
    return r;
#endif
}
LF_INLINE lanes gather(const float *p, lanes_int i)
{
    return (lanes)gather_int(p, i);
}
/* p[i] and p[i + 1], the first in the lower half. */
LF_INLINE lanes_int gather_pairs(const uint16_t *p, lanes_int i)
{
#if defined(LF_LANES_AVX512)
    return (lanes_int)_mm512_i32gather_epi32((__m512i)i, p, 2);
#elif defined(LF_LANES_AVX2)
    return (lanes_int)_mm256_i32gather_epi32((const int *)(const void *)p, (__m256i)i, 2);
#else
    lanes_int r = i;
    for (int k = 0; k < LF_WIDTH; k++)
        r[k] = (int32_t)(p[i[k]] | (uint32_t)p[i[k] + 1] << 16);
    return r;
#endif
}
/* Interpolates between the two values of such a pair, 65535 = 1. */
LF_INLINE lanes between_pair(lanes_int pair, lanes f)
{
    return between(to_float(pair & 0xffff), to_float((lanes_int)((lanes_bits)pair >> 16)), f);
}

/* Interpolates between two 16-bit values of a grid (lf_short_value), without their scale. */
LF_INLINE lanes between_shorts(lanes_int pair, lanes f)
{
    const int32_t kept = 0xffff << 13;
    return between((lanes)((pair << 13) & kept), (lanes)((lanes_int)((lanes_bits)pair >> 3) & kept),
                   f);
}

/* --------------------------------------------------------------------------------- functions -- */

/* lf_exponential, u in (0, 1): -log(1 - u). The logarithm of 2^e m, m in [sqrt(1/2), sqrt(2)), is e
 * log 2 + 2 artanh((m - 1)/(m + 1)); the series ends after its fifth term: 1e-9. */
LF_INLINE lanes exponential_of(lanes u)
{
    lanes x = 1.0f - u;
    lanes_int bits = (lanes_int)x, e = (bits - 0x3f3504f3) >> 23;
    lanes m = (lanes)(bits - e * (1 << 23));
    lanes s = (m - 1.0f) / (m + 1.0f), z = s * s;
    lanes series =
        1.0f + z * (1.0f / 3.0f + z * (1.0f / 5.0f + z * (1.0f / 7.0f + z * (1.0f / 9.0f))));
    lanes logarithm = to_float(e) * 0.693147180560f + 2.0f * s * series;
    lanes small = u * (1.0f + u * (0.5f + u * (1.0f / 3.0f)));
    return choose(is_less(u, all(0x1p-8f)), small, -logarithm);
}

/* sin(2 pi r), r in [-1/4, 1/4], by its series up to the 11th power; error 6e-8. */
LF_INLINE lanes sine_of_part(lanes r)
{
    lanes x = r * (2.0f * LF_PI), z = x * x;
    lanes series = -1.0f / 5040.0f + z * (1.0f / 362880.0f + z * (-1.0f / 39916800.0f));
    return x * (1.0f + z * (-1.0f / 6.0f + z * (1.0f / 120.0f + z * series)));
}

/* sin and cos of 2 pi u, u in [0, 1). Shifted by half a turn, both only change sign; there the
 * cosine is even and the sine odd. */
LF_INLINE void sine_cosine(lanes u, lanes *sine, lanes *cosine)
{
    lanes v = u - 0.5f, q = magnitude(v);
    *cosine = -sine_of_part(0.25f - q);
    lanes half = sine_of_part(choose(is_less(all(0.25f), q), 0.5f - q, q));
    *sine = choose(is_less(v, all(0.0f)), half, -half);
}

/* The angle of (x, y), y >= 0, from the x axis, in turns: 0 to 1/2; (0, 0) gives 0. By the series
 * of the arc tangent up to the 15th power, for slopes below tan(pi/8); error 2e-8. */
LF_INLINE lanes turn_of(lanes y, lanes x)
{
    lanes a = magnitude(x), high = most(most(a, y), all(1e-30f)), slope = least(a, y) / high;
    mask steep = is_less(all(0.41421356f), slope);
    lanes t = choose(steep, (slope - 1.0f) / (slope + 1.0f), slope), z = t * t;
    lanes series =
        -1.0f / 7.0f +
        z * (1.0f / 9.0f + z * (-1.0f / 11.0f + z * (1.0f / 13.0f - z * (1.0f / 15.0f))));
    lanes angle = t * (1.0f + z * (-1.0f / 3.0f + z * (1.0f / 5.0f + z * series)));
    lanes turn = angle * (0.5f * LF_INV_PI) + choose(steep, all(0.125f), all(0.0f));
    turn = choose(is_less(a, y), 0.25f - turn, turn);
    return choose(is_less(x, all(0.0f)), 0.5f - turn, turn);
}

/* ---------------------------------------------------------------------------- random numbers -- */

/* sfc32 (Doty-Humphrey, PractRand): an independent stream in each lane. */
typedef struct lanes_random {
    lanes_bits a, b, c, n;
} lanes_random;

/* The next number in the lanes of m; other lanes do not advance. */
LF_INLINE lanes_bits draw(lanes_random *r, mask m)
{
    lanes_bits t = r->a + r->b + r->n, a = r->b ^ (r->b >> 9), b = r->c + (r->c << 3),
               c = ((r->c << 21) | (r->c >> 11)) + t;
    r->n = (lanes_bits)choose_int(m, (lanes_int)(r->n + 1u), (lanes_int)r->n);
    r->a = (lanes_bits)choose_int(m, (lanes_int)a, (lanes_int)r->a);
    r->b = (lanes_bits)choose_int(m, (lanes_int)b, (lanes_int)r->b);
    r->c = (lanes_bits)choose_int(m, (lanes_int)c, (lanes_int)r->c);
    return t;
}

/* Begins the stream of a key in the lanes of m. */
LF_INLINE void begin_random(lanes_random *r, mask m, lanes_bits low, lanes_bits high)
{
    enum { ROUNDS = 4 }; /* few are enough, because keys are hashes */
    r->a = (lanes_bits)choose_int(m, (lanes_int)low, (lanes_int)r->a);
    r->b = (lanes_bits)choose_int(m, (lanes_int)high, (lanes_int)r->b);
    r->c = (lanes_bits)choose_int(m, (lanes_int)(low ^ 0x9e3779b9u), (lanes_int)r->c);
    r->n = (lanes_bits)choose_int(m, all_int(1), (lanes_int)r->n);
    for (int i = 0; i < ROUNDS; i++)
        (void)draw(r, m);
}

/* lf_rng: in [0, 1), multiples of 2^-24. */
LF_INLINE lanes draw_unit(lanes_random *r, mask m)
{
    return to_float((lanes_int)(draw(r, m) >> 8)) * 0x1p-24f;
}
/* lf_rng_exponential */
LF_INLINE lanes draw_exponential(lanes_random *r, mask m)
{
    lanes fine = (bits_to_float(draw(r, m)) + 0.5f) * 0x1p-32f;
    return exponential_of(least(fine, all(1.0f - 0x1p-24f)));
}

#endif
