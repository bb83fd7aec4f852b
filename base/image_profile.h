/* What 8-bit pictures say of their colours in foreign words: ICC profiles and EXIF. Private to
 * base; data is a stranger's. Thread safe. */
#ifndef LF_BASE_IMAGE_PROFILE_H
#define LF_BASE_IMAGE_PROFILE_H

#include <stddef.h>
#include <stdint.h>

#include "base/image_metadata.h"

/* Four bytes, the highest first. */
static inline uint32_t lf_be32(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* Whether an ICC profile (ICC.1:2010; its first bytes are enough, where its tags lie in them) is
 * one of sRGB: its primaries to three digits, and a curve that is sRGB's to 1 %. */
bool lf_icc_is_srgb(const uint8_t *data, size_t size);

/* Takes what EXIF (a TIFF, beginning with its byte order) says of the pixels: the orientation of
 * the main picture (the first that is said counts), and notes a colour space other than sRGB. */
void lf_exif_read(const uint8_t *data, size_t size, lf_image_metadata *meta);

#endif
