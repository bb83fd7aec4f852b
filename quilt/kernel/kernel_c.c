/* The kernels in plain C: the reference for the others. */
#include <string.h>

#include "quilt/kernel/kernel_place.h"

static void interlace(size_t n, const uint8_t *view, const uint16_t *place, uint32_t stride,
                      const uint8_t *from, uint8_t *out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = from[view[i] * stride + place[i]];
}

static void views8(const lf_places *places, size_t n, uint8_t *out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = (uint8_t)(int)lf_place_at(places, i, i % 6);
}

static void views16(const lf_places *places, size_t n, uint16_t *out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = (uint16_t)(int)lf_place_at(places, i, i % 6);
}

#define INFINITY_BITS 0x7f800000
#define BLOCK_SAMPLES 256

/* Two loops, because only the first can be vectorised. Bits of floats above 0 have the order of the
 * floats; all other values (and NaN) become the lowest. */
static void tone(const lf_tone_table *table, size_t n, const float *in, uint8_t *out)
{
    const uint32_t *entries = table->entries;
    const int32_t low = table->low, high = table->high;
    const int shift = table->shift;
    const uint32_t mask = (1u << shift) - 1;
    for (size_t done = 0; done < n; done += BLOCK_SAMPLES) {
        size_t m = n - done < BLOCK_SAMPLES ? n - done : BLOCK_SAMPLES;
        int32_t offset[BLOCK_SAMPLES];
        memcpy(offset, in + done, m * sizeof *in);
        for (size_t i = 0; i < m; i++) {
            int32_t bits = offset[i] > INFINITY_BITS ? low : offset[i];
            bits = bits < low ? low : bits;
            offset[i] = (bits > high ? high : bits) - low;
        }
        for (size_t i = 0; i < m; i++) {
            uint32_t entry = entries[(uint32_t)offset[i] >> shift];
            out[done + i] = (uint8_t)((entry & 255) + (((uint32_t)offset[i] & mask) >= entry >> 8));
        }
    }
}

const lf_quilt_kernels lf_quilt_kernels_c = {
    .name = "c", .interlace = interlace, .views8 = views8, .views16 = views16, .tone = tone};
