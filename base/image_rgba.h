/* Pictures that lie on surfaces: a file's bytes in memory, its numbers as they are. For the program
 * that reads meshes: whoever links it needs libwebp, too. Thread safe. */
#ifndef LF_BASE_IMAGE_RGBA_H
#define LF_BASE_IMAGE_RGBA_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* PNG, JPEG and WebP, whichever the first bytes say, into [height][width][4] of 8 bits: red, green,
 * blue, and a coverage that is not multiplied into them, 255 where the file has none. Grey is
 * spread, palettes are expanded, 16-bit PNG is rounded, CMYK becomes RGB; no gamma, profile or
 * orientation is applied, as glTF wants it. where
 * names the picture in errors. Limits as image_io.h. The caller releases *out_rgba by lf_free.
 * LF_E_FORMAT: it is none of them, damaged, cut off, too large or a moving WebP; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_image_rgba_decode(const void *data, size_t size, const char *where,
                                            uint8_t **out_rgba, int *out_width, int *out_height,
                                            lf_error *err);

#endif
