#include "render/transport/sampler.h"

#include <stdbool.h>

static inline uint32_t reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/* A permutation in which every bit is flipped by a hash of the bits BELOW it and the seed (Laine
 * and Karras 2011; this one is Vegdahl's): Owen's nested scramble of a number with reversed bits.
 */
static inline uint32_t permute_upwards(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Second Sobol' dimension before its bits are reversed. Bit i is the sum mod 2 of the index bits j
 * with C(j, i) odd, that is i subset of j (Lucas). Pascal's matrix mod 2 is a Kronecker power, so
 * five steps suffice. */
static inline uint32_t pascal(uint32_t x)
{
    x ^= x >> 16;
    x ^= (x >> 8) & 0x00ff00ffu;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 2) & 0x33333333u;
    return x ^ ((x >> 1) & 0x55555555u);
}

static inline float unit(uint32_t x)
{
    return (float)(x >> 8) * 0x1p-24f;
}

/* An order of the points: of every 2^k in turn, some permutation within themselves. */
static inline uint32_t shuffle(uint64_t h, uint32_t index)
{
    return reverse_bits(permute_upwards(reverse_bits(index), (uint32_t)h));
}

static inline bool is_owen(const lf_sampler *s)
{
    return s->kind == LF_SAMPLER_OWEN && s->dimension < LF_SAMPLER_DIMENSIONS;
}

void lf_sampler_init(lf_sampler *s, lf_sampler_kind kind, uint64_t key, uint32_t index)
{
    *s = (lf_sampler){.key = key, .index = index, .state = lf_hash64(key, index), .kind = kind};
}

/* With a key of its own: samples of the same pixel that are not split use the same dimensions. */
void lf_sampler_split(lf_sampler *s, int n)
{
    const uint32_t dimension = s->dimension;
    lf_sampler_init(s, s->kind, lf_hash64(s->key, LF_SAMPLER_DIMENSIONS), s->index * (uint32_t)n);
    s->dimension = dimension;
}

void lf_sampler_next(lf_sampler *s, uint32_t dimension)
{
    lf_sampler_init(s, s->kind, s->key, s->index + 1);
    s->dimension = dimension;
}

float lf_sampler_1d(lf_sampler *s)
{
    uint32_t dimension = s->dimension;
    bool owen = is_owen(s);
    s->dimension += 1;
    if (!owen)
        return (float)(lf_hash64(s->state, dimension) >> 40) * 0x1p-24f;
    uint64_t h = lf_hash64(s->key, dimension);
    uint32_t shuffled = shuffle(h, s->index);
    return unit(reverse_bits(permute_upwards(shuffled, (uint32_t)(h >> 32))));
}

void lf_sampler_2d(lf_sampler *s, float out[2])
{
    uint32_t dimension = s->dimension;
    bool owen = is_owen(s);
    s->dimension += 2;
    if (!owen) {
        uint64_t h = lf_hash64(s->state, dimension);
        out[0] = (float)(h >> 40) * 0x1p-24f;
        out[1] = (float)((h >> 8) & 0xffffffu) * 0x1p-24f;
        return;
    }
    uint64_t h = lf_hash64(s->key, dimension), h1 = lf_hash64(h, dimension);
    uint32_t shuffled = shuffle(h, s->index);
    out[0] = unit(reverse_bits(permute_upwards(shuffled, (uint32_t)(h >> 32))));
    out[1] = unit(reverse_bits(permute_upwards(pascal(shuffled), (uint32_t)(h1 >> 32))));
}

/* Without its own shuffle, each of two such sequences would determine the other, and no mean over
 * both would converge. */
float lf_sampler_radical(uint64_t key, uint32_t index)
{
    uint64_t h = lf_hash64(key, 0);
    return unit(reverse_bits(permute_upwards(shuffle(h, index), (uint32_t)(h >> 32))));
}

float lf_sampler_partner(uint64_t key, uint64_t scramble, uint32_t index)
{
    uint32_t shuffled = shuffle(lf_hash64(key, 0), index);
    return unit(
        reverse_bits(permute_upwards(pascal(shuffled), (uint32_t)(lf_hash64(scramble, 0) >> 32))));
}
