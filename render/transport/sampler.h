/* Random numbers; private to render/. A sampler is a stream of dimensions of one sample, a pure
 * function of (key, index, dimension), independent of threads and order. "owen": Sobol' points
 * (first two dimensions, padded in pairs) with Owen scrambling by hash (Laine and Karras 2011;
 * Burley 2020, JCGT 9(4)). Each pair of dimensions has its own shuffle of the index and its own
 * scramble. After LF_SAMPLER_DIMENSIONS it continues with independent numbers. "independent": a
 * counter-based hash. */
#ifndef LF_RENDER_SAMPLER_H
#define LF_RENDER_SAMPLER_H

#include <stdint.h>

#define LF_SAMPLER_DIMENSIONS 64

typedef enum lf_sampler_kind { LF_SAMPLER_OWEN, LF_SAMPLER_INDEPENDENT } lf_sampler_kind;

typedef struct lf_sampler {
    uint64_t key;       /* which sequence: hash of pixel, view, half, seed */
    uint32_t index;     /* which point of the sequence */
    uint32_t dimension; /* next dimension */
    uint64_t state;     /* stream of the independent numbers */
    lf_sampler_kind kind;
} lf_sampler;

/* A 64-bit mix of two words; the building block of keys (splitmix64's finaliser). */
static inline uint64_t lf_hash64(uint64_t a, uint64_t b)
{
    uint64_t z = a + 0x9e3779b97f4a7c15u * (b + 1);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

void lf_sampler_init(lf_sampler *s, lf_sampler_kind kind, uint64_t key, uint32_t index);
/* Turns the sampler to the first of n points of a finer sequence, at its present dimension: the n
 * points of all indices together are as even as one sequence. */
void lf_sampler_split(lf_sampler *s, int n);
/* The next of the n points, from this dimension on. */
void lf_sampler_next(lf_sampler *s, uint32_t dimension);
/* In [0, 1), multiples of 2^-24. */
float lf_sampler_1d(lf_sampler *s);
void lf_sampler_2d(lf_sampler *s, float out[2]);
/* Point `index` of a one-dimensional Owen-scrambled radical inverse with this key, in an order that
 * depends on the key (for numbers that a whole visit of a row shares). Sequences of different keys
 * are independent. */
float lf_sampler_radical(uint64_t key, uint32_t index);
/* The second dimension of a net whose first is lf_sampler_radical(key, index), with a scramble of
 * its own. These are (0, 2)-nets in base 2, one for every scramble, with a shared first coordinate
 * (film points of the unscattered light next to row offsets). */
float lf_sampler_partner(uint64_t key, uint64_t scramble, uint32_t index);

#endif
