/* Stochastic rounding of the film's numbers; private to render/film/. */
#ifndef LF_RENDER_FILM_ROUND_H
#define LF_RENDER_FILM_ROUND_H

#include <stdint.h>
#include <string.h>

/* Rounds to the float below or above x, with probabilities in proportion to the distances; exact
 * values stay. Uses 29 bits of random. */
static inline float lf_film_round(double x, uint32_t random)
{
    const uint64_t below = (UINT64_C(1) << 29) - 1;
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = (bits + (random & below)) & ~below;
    memcpy(&x, &bits, sizeof x);
    return (float)x;
}

#endif
