/* The kernels for AVX2, with gathers of eight. The plain C kernels process the rest of a row. */
#if defined(__x86_64__)

#include <immintrin.h>

#include "quilt/kernel/kernel_place.h"

/* Packs 32 lanes of 32 bits, each holding a byte, in order. */
static inline __m256i pack(__m256i a, __m256i b, __m256i c, __m256i d)
{
    const __m256i order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    __m256i mixed = _mm256_packus_epi16(_mm256_packus_epi32(a, b), _mm256_packus_epi32(c, d));
    return _mm256_permutevar8x32_epi32(mixed, order);
}

static inline __m256i fetch(const uint8_t *view, const uint16_t *place, __m256i stride,
                            const uint8_t *from)
{
    __m256i v = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)view));
    __m256i p = _mm256_cvtepu16_epi32(_mm_loadu_si128((const __m128i *)(const void *)place));
    __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(v, stride), p);
    return _mm256_and_si256(_mm256_i32gather_epi32((const int *)(const void *)from, at, 1),
                            _mm256_set1_epi32(255));
}

static void interlace(size_t n, const uint8_t *view, const uint16_t *place, uint32_t stride,
                      const uint8_t *from, uint8_t *out)
{
    const __m256i s = _mm256_set1_epi32((int)stride);
    size_t i = 0;
    for (; i + 32 <= n; i += 32) {
        __m256i a = fetch(view + i, place + i, s, from),
                b = fetch(view + i + 8, place + i + 8, s, from);
        __m256i c = fetch(view + i + 16, place + i + 16, s, from),
                d = fetch(view + i + 24, place + i + 24, s, from);
        _mm256_storeu_si256((__m256i *)(void *)(out + i), pack(a, b, c, d));
    }
    lf_quilt_kernels_c.interlace(n - i, view + i, place + i, stride, from, out + i);
}

/* Position times n_views of four subpixels, truncated. */
static inline __m128i views_of(const lf_places *p, size_t i, __m256d along)
{
    __m256d phase = _mm256_mul_pd(_mm256_add_pd(_mm256_loadu_pd(p->across + i), along),
                                  _mm256_set1_pd(p->pitch));
    phase = _mm256_sub_pd(phase, _mm256_set1_pd(p->center));
    __m256d z = _mm256_sub_pd(phase, _mm256_floor_pd(phase));
    if (p->from_right)
        z = _mm256_sub_pd(_mm256_set1_pd(1), z);
    z = _mm256_min_pd(_mm256_max_pd(z, _mm256_set1_pd(1e-5)), _mm256_set1_pd(0.999999));
    return _mm256_cvttpd_epi32(_mm256_mul_pd(z, _mm256_set1_pd(p->n_views)));
}

/* Twelve is the smallest multiple of the lanes with the same pattern of parity and channel. */
#define ROUND 12

static inline void round_of(const lf_places *p, const __m256d along[3], size_t i, __m128i out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = views_of(p, i + 4 * (size_t)k, along[k]);
}

static void along_of(const lf_places *p, __m256d along[3])
{
    const double *a = p->along;
    along[0] = _mm256_setr_pd(a[0], a[1], a[2], a[3]);
    along[1] = _mm256_setr_pd(a[4], a[5], a[0], a[1]);
    along[2] = _mm256_setr_pd(a[2], a[3], a[4], a[5]);
}

static void views8(const lf_places *places, size_t n, uint8_t *out)
{
    __m256d along[3];
    along_of(places, along);
    size_t i = 0;
    for (; i + 16 <= n; i += ROUND) { /* writes 16, of which 12 count */
        __m128i v[3];
        round_of(places, along, i, v);
        __m128i last = _mm_packus_epi32(v[2], v[2]);
        _mm_storeu_si128((__m128i *)(void *)(out + i),
                         _mm_packus_epi16(_mm_packus_epi32(v[0], v[1]), last));
    }
    lf_places rest = *places;
    rest.across += i;
    lf_quilt_kernels_c.views8(&rest, n - i, out + i);
}

static void views16(const lf_places *places, size_t n, uint16_t *out)
{
    __m256d along[3];
    along_of(places, along);
    size_t i = 0;
    for (; i + ROUND <= n; i += ROUND) {
        __m128i v[3];
        round_of(places, along, i, v);
        _mm_storeu_si128((__m128i *)(void *)(out + i), _mm_packus_epi32(v[0], v[1]));
        _mm_storel_epi64((__m128i *)(void *)(out + i + 8), _mm_packus_epi32(v[2], v[2]));
    }
    lf_places rest = *places;
    rest.across += i;
    lf_quilt_kernels_c.views16(&rest, n - i, out + i);
}

static inline __m256i codes(const lf_tone_table *t, const float *in)
{
    const __m256i low = _mm256_set1_epi32(t->low), mask = _mm256_set1_epi32((1 << t->shift) - 1);
    const __m128i shift = _mm_cvtsi32_si128(t->shift);
    __m256i bits = _mm256_loadu_si256((const __m256i *)(const void *)in);
    /* NaN sorts above infinity */
    bits = _mm256_andnot_si256(_mm256_cmpgt_epi32(bits, _mm256_set1_epi32(0x7f800000)), bits);
    bits = _mm256_sub_epi32(
        _mm256_min_epi32(_mm256_max_epi32(bits, low), _mm256_set1_epi32(t->high)), low);
    __m256i entry = _mm256_i32gather_epi32((const int *)(const void *)t->entries,
                                           _mm256_srl_epi32(bits, shift), 4);
    __m256i below = _mm256_cmpgt_epi32(_mm256_srli_epi32(entry, 8), _mm256_and_si256(bits, mask));
    __m256i code = _mm256_and_si256(entry, _mm256_set1_epi32(255));
    return _mm256_add_epi32(_mm256_add_epi32(code, _mm256_set1_epi32(1)), below);
}

static void tone(const lf_tone_table *table, size_t n, const float *in, uint8_t *out)
{
    size_t i = 0;
    for (; i + 32 <= n; i += 32) {
        __m256i a = codes(table, in + i), b = codes(table, in + i + 8);
        __m256i c = codes(table, in + i + 16), d = codes(table, in + i + 24);
        _mm256_storeu_si256((__m256i *)(void *)(out + i), pack(a, b, c, d));
    }
    lf_quilt_kernels_c.tone(table, n - i, in + i, out + i);
}

const lf_quilt_kernels lf_quilt_kernels_avx2 = {
    .name = "avx2", .interlace = interlace, .views8 = views8, .views16 = views16, .tone = tone};

#else
typedef int lf_quilt_kernels_avx2_not_here;
#endif
