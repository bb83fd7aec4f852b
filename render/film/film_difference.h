/* Three small numbers in 32 bits: a shared power of two and signed bytes; private to render/. For
 * differences between the film's halves, which only the error estimate reads. Rounded at random in
 * proportion, so that a difference that builds up in small steps neither stagnates nor drifts. One
 * rounding adds a standard error of at most 1/128 of the largest. */
#ifndef LF_RENDER_FILM_DIFFERENCE_H
#define LF_RENDER_FILM_DIFFERENCE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* random in [0, 1). Non-finite values give 0. */
static inline uint32_t lf_difference_pack(const float x[3], float random)
{
    float largest = fmaxf(fabsf(x[0]), fmaxf(fabsf(x[1]), fabsf(x[2])));
    uint32_t bits, packed;
    /* each, because the largest number is none that is not a number */
    if (!(largest > 1e-30f && fabsf(x[0]) < 1e30f && fabsf(x[1]) < 1e30f && fabsf(x[2]) < 1e30f))
        return 0;
    memcpy(&bits, &largest, sizeof bits);
    /* The largest number is 64 to 127 steps of a power of two. */
    uint32_t exponent = (bits >> 23) - 6;
    if ((bits & 0x7fffffu) > 0x7e0000u)
        exponent++;
    uint32_t inverse_bits = (254 - exponent) << 23;
    float inverse;
    memcpy(&inverse, &inverse_bits, sizeof inverse);
    packed = exponent << 24;
    for (int c = 0; c < 3; c++)
        packed |= ((uint32_t)(int32_t)floorf(x[c] * inverse + random) & 0xffu) << (8 * c);
    return packed;
}

static inline void lf_difference_unpack(uint32_t packed, float x[3])
{
    uint32_t bits = packed >> 24 << 23;
    float step;
    memcpy(&step, &bits, sizeof step);
    for (int c = 0; c < 3; c++)
        x[c] = step * (float)(int8_t)(packed >> (8 * c) & 0xffu);
}

#endif
