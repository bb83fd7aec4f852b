/* Colour information of 8-bit pictures: ICC profiles and EXIF. Private to base; data is untrusted.
 * Thread safe. */
#ifndef LF_BASE_IMAGE_PROFILE_H
#define LF_BASE_IMAGE_PROFILE_H

#include <stddef.h>
#include <stdint.h>

#include "base/image_metadata.h"

/* Reads four bytes, big-endian. */
static inline uint32_t lf_be32(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* True if an ICC profile (ICC.1:2010) is sRGB: its primaries to three digits, and its curve to 1 %.
 * The beginning of a profile is enough if it contains the tags. */
bool lf_icc_is_srgb(const uint8_t *data, size_t size);

/* Reads EXIF (a TIFF, starting with its byte order). Takes the orientation of the main picture (the
 * first one given) and the focal length, and notes a colour space other than sRGB. */
void lf_exif_read(const uint8_t *data, size_t size, lf_image_metadata *meta);

#endif
