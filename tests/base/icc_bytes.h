/* Small ICC profiles (ICC.1:2010) of three colours and one curve. */
#ifndef LF_TESTS_BASE_ICC_BYTES_H
#define LF_TESTS_BASE_ICC_BYTES_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { ICC_BYTES = 512 };

static inline void icc_put(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(value >> (24 - 8 * i));
}

static inline void icc_put_xyz(uint8_t *to, const double xyz[3])
{
    memcpy(to, "XYZ ", 4);
    for (int i = 0; i < 3; i++)
        icc_put(to + 8 + 4 * i, (uint32_t)lround(xyz[i] * 65536));
}

/* The parametric curve of sRGB. */
static inline void icc_put_srgb_curve(uint8_t *to)
{
    static const double numbers[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    memcpy(to, "para", 4);
    to[9] = 3;
    for (int i = 0; i < 5; i++)
        icc_put(to + 12 + 4 * i, (uint32_t)lround(numbers[i] * 65536));
}

/* Returns its size. As D50 sees them; red is that of sRGB, or of Adobe RGB. */
static inline size_t icc_make(uint8_t profile[ICC_BYTES], bool srgb)
{
    static const char *const tags[] = {"rXYZ", "gXYZ", "bXYZ", "wtpt", "rTRC", "gTRC", "bTRC"};
    static const double red[3] = {0.43607, 0.22249, 0.01392}, wide[3] = {0.60974, 0.31111, 0.01947},
                        green[3] = {0.38515, 0.71687, 0.09708},
                        blue[3] = {0.14307, 0.06061, 0.71410}, d50[3] = {0.9642, 1, 0.82491};
    const double *const colours[] = {srgb ? red : wide, green, blue, d50};
    const uint32_t size = 132 + 7 * 12 + 4 * 20 + 32;
    memset(profile, 0, ICC_BYTES);
    icc_put(profile, size);
    icc_put(profile + 8, 0x04000000);
    memcpy(profile + 12, "mntrRGB XYZ ", 12);
    memcpy(profile + 36, "acsp", 4);
    for (int i = 0; i < 3; i++)
        icc_put(profile + 68 + 4 * i, (uint32_t)lround(d50[i] * 65536));
    icc_put(profile + 128, 7);
    for (uint32_t i = 0; i < 7; i++) {
        uint8_t *entry = profile + 132 + 12 * i;
        const uint32_t at = 216 + 20 * (i < 4 ? i : 4);
        memcpy(entry, tags[i], 4);
        icc_put(entry + 4, at);
        icc_put(entry + 8, i < 4 ? 20 : 32);
        if (i < 4)
            icc_put_xyz(profile + at, colours[i]);
        else
            icc_put_srgb_curve(profile + at);
    }
    return size;
}

#endif
