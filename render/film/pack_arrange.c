#include <string.h>

#include "render/film/film_pack.h"

/* of floats */
typedef uint32_t __attribute__((may_alias)) lf_bits;

enum { NUMBERS = sizeof(lf_packed_feature) / sizeof(uint16_t) };

size_t lf_pack_spare(const lf_pack_planes *planes)
{
    return planes->features ? 2 * planes->pixels * sizeof(lf_packed_feature) : 0;
}

/* W' becomes W' xor W, and the other way round. */
static void mix(size_t n, const lf_bits *restrict scattered, lf_bits *restrict w2)
{
    for (size_t i = 0; i < n; i++)
        w2[i] ^= scattered[4 * i + 3];
}

static void split(size_t n, const uint16_t *restrict from, uint16_t *restrict to)
{
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < NUMBERS; k++)
            to[k * n + i] = from[NUMBERS * i + k];
}

static void join(size_t n, const uint16_t *restrict from, uint16_t *restrict to)
{
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < NUMBERS; k++)
            to[NUMBERS * i + k] = from[k * n + i];
}

/* Where a half's arrays are (film.h: half_at). */
static lf_bits *w2_of(const lf_pack_planes *planes, unsigned char *row, int half)
{
    return (lf_bits *)(void *)(row + (size_t)half * planes->half_bytes +
                               planes->pixels * sizeof(lf_film_scattered));
}

static uint16_t *features_of(const lf_pack_planes *planes, unsigned char *row, int half)
{
    return (uint16_t *)(void *)(row + (size_t)(half + 1) * planes->half_bytes) -
           NUMBERS * planes->pixels;
}

static void mix_halves(const lf_pack_planes *planes, unsigned char *row)
{
    for (int h = 0; h < 2 && planes->w2; h++)
        mix(planes->pixels, (lf_bits *)(void *)(row + (size_t)h * planes->half_bytes),
            w2_of(planes, row, h));
}

void lf_pack_arrange(const lf_pack_planes *planes, unsigned char *row, unsigned char *spare)
{
    const size_t n = planes->pixels;
    mix_halves(planes, row);
    for (int h = 0; h < 2 && planes->features; h++) {
        uint16_t *features = features_of(planes, row, h),
                 *arranged = (uint16_t *)(void *)spare + (size_t)h * NUMBERS * n;
        split(n, features, arranged);
        memcpy(features, arranged, n * sizeof(lf_packed_feature));
    }
}

void lf_pack_restore(const lf_pack_planes *planes, unsigned char *row, unsigned char *spare,
                     bool known)
{
    const size_t n = planes->pixels;
    mix_halves(planes, row);
    for (int h = 0; h < 2 && planes->features; h++) {
        uint16_t *features = features_of(planes, row, h),
                 *arranged = (uint16_t *)(void *)spare + (size_t)h * NUMBERS * n;
        if (!known)
            memcpy(arranged, features, n * sizeof(lf_packed_feature));
        join(n, arranged, features);
    }
}
