#include <string.h>

#include "render/film/film_pack.h"

#define LINE LF_PACK_LINE

/* Packed: a bit for each line, 1: it follows; then these lines. */
static size_t words_of(size_t lines)
{
    return (lines + 63) / 64;
}

size_t lf_pack_most(size_t lines)
{
    return words_of(lines) * sizeof(uint64_t) + lines * LINE;
}

/* Most lines that differ do so in their first bytes. */
static inline bool repeats(const unsigned char *line)
{
    uint64_t a, b;
    memcpy(&a, line, sizeof a);
    memcpy(&b, line - LINE, sizeof b);
    return a == b && memcmp(line, line - LINE, LINE) == 0;
}

static bool is_zero(const unsigned char *line)
{
    static const unsigned char zero[LINE];
    return memcmp(line, zero, LINE) == 0;
}

/* Bits of n lines, at most 64; first: they are the row's first. */
static uint64_t bits_of(const unsigned char *in, size_t n, bool first)
{
    uint64_t bits = first && !is_zero(in);
    for (size_t i = first; i < n; i++)
        bits |= (uint64_t)!repeats(in + i * LINE) << i;
    return bits;
}

/* The number of equal bits from bit i on, 0 < i + result <= n. */
static inline size_t run_of(uint64_t bits, size_t i, size_t n)
{
    const uint64_t from = bits >> i, other = from & 1 ? ~from : from;
    const size_t run = other ? (size_t)__builtin_ctzll(other) : 64;
    return run < n - i ? run : n - i;
}

size_t lf_pack_lines(const unsigned char *in, size_t lines, unsigned char *out)
{
    unsigned char *to = out + words_of(lines) * sizeof(uint64_t);
    for (size_t at = 0; at < lines; at += 64) {
        const size_t n = lines - at < 64 ? lines - at : 64;
        const uint64_t bits = bits_of(in + at * LINE, n, at == 0);
        memcpy(out + at / 64 * sizeof bits, &bits, sizeof bits);
        for (size_t i = 0, run; i < n; i += run) {
            run = run_of(bits, i, n);
            if (!(bits >> i & 1))
                continue;
            memcpy(to, in + (at + i) * LINE, run * LINE);
            to += run * LINE;
        }
    }
    return (size_t)(to - out);
}

void lf_unpack_lines(const unsigned char *in, size_t lines, unsigned char *out)
{
    static const unsigned char zero[LINE];
    const unsigned char *from = in + words_of(lines) * sizeof(uint64_t), *last = zero;
    for (size_t at = 0; at < lines; at += 64) {
        const size_t n = lines - at < 64 ? lines - at : 64;
        uint64_t bits;
        memcpy(&bits, in + at / 64 * sizeof bits, sizeof bits);
        for (size_t i = 0, run; i < n; i += run) {
            unsigned char *to = out + (at + i) * LINE;
            run = run_of(bits, i, n);
            if (bits >> i & 1) {
                memcpy(to, from, run * LINE);
                from += run * LINE;
                last = from - LINE;
                continue;
            }
            for (size_t k = 0; k < run; k++)
                memcpy(to + k * LINE, last, LINE);
        }
    }
}
