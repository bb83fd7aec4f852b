/* A bitmap of Windows of known pixels: at (x, y), from the top left, red is 3 x, green is 5 y and
 * blue is 7 (x + y), modulo 256. */
#ifndef LF_TESTS_WEB_BITMAP_H
#define LF_TESTS_WEB_BITMAP_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { BITMAP_HEAD = 54 };

static inline void bitmap_pixel(int x, int y, uint8_t rgb[3])
{
    rgb[0] = (uint8_t)(3 * x);
    rgb[1] = (uint8_t)(5 * y);
    rgb[2] = (uint8_t)(7 * (x + y));
}

static inline void bitmap_word(uint8_t *at, uint32_t word)
{
    for (int i = 0; i < 4; i++)
        at[i] = (uint8_t)(word >> 8 * i);
}

/* height < 0: from the top. bits: 24 or 32. *out_n bytes, which the caller frees. */
static inline uint8_t *bitmap_make(int width, int height, int bits, size_t *out_n)
{
    const int rows = abs(height), bytes = bits / 8;
    const size_t stride = ((size_t)width * (size_t)bytes + 3) / 4 * 4,
                 n = BITMAP_HEAD + stride * (size_t)rows;
    uint8_t *bmp = calloc(n, 1);
    if (!bmp)
        return NULL;
    memcpy(bmp, "BM", 2);
    bitmap_word(bmp + 2, (uint32_t)n);
    bitmap_word(bmp + 10, BITMAP_HEAD);
    bitmap_word(bmp + 14, 40);
    bitmap_word(bmp + 18, (uint32_t)width);
    bitmap_word(bmp + 22, (uint32_t)height);
    bmp[26] = 1;
    bmp[28] = (uint8_t)bits;
    for (int row = 0; row < rows; row++)
        for (int x = 0; x < width; x++) {
            uint8_t rgb[3], *at = bmp + BITMAP_HEAD + stride * (size_t)row + (size_t)(x * bytes);
            bitmap_pixel(x, height < 0 ? row : rows - 1 - row, rgb);
            at[0] = rgb[2];
            at[1] = rgb[1];
            at[2] = rgb[0];
        }
    *out_n = n;
    return bmp;
}

#endif
