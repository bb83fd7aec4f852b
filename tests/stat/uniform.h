/* Random numbers of tests, in sequences that do not change. */
#ifndef LF_TESTS_UNIFORM_H
#define LF_TESTS_UNIFORM_H

#include "render/transport/sampler.h"

/* The next number from 0 to below 1, of 24 bits. */
static inline float lf_test_uniform(uint64_t *state)
{
    *state = lf_hash64(*state, 1);
    return (float)(*state >> 40) * 0x1p-24f;
}

/* The next number between 0 and 1, of 53 bits. */
static inline double lf_test_uniform53(uint64_t *state)
{
    *state = lf_hash64(*state, 1);
    return ((double)(*state >> 11) + 0.5) * 0x1p-53;
}

#endif
