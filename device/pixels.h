/* Conversion to the pixel formats of displays. Private to device/. */
#ifndef LF_DEVICE_PIXELS_H
#define LF_DEVICE_PIXELS_H

#include <endian.h>
#include <stdint.h>
#include <string.h>

/* n >= 1 pixels of r, g, b bytes to XRGB8888: bytes b, g, r, 0 on every machine. */
static inline void lf_pixels_xrgb8888(uint8_t *restrict to, const uint8_t *restrict from, int n)
{
    uint32_t pixel;
    for (int i = 0; i < n - 1; i++) {
        memcpy(&pixel, from + (size_t)i * 3, sizeof pixel);
        pixel = htole32(be32toh(pixel) >> 8);
        memcpy(to + (size_t)i * 4, &pixel, sizeof pixel);
    }
    /* by bytes: there may be nothing after the last one */
    from += (size_t)(n - 1) * 3;
    pixel = htole32((uint32_t)from[0] << 16 | (uint32_t)from[1] << 8 | from[2]);
    memcpy(to + (size_t)(n - 1) * 4, &pixel, sizeof pixel);
}

#endif
