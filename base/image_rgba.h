/* Textures: decodes a file in memory without changing its values. For the program that reads
 * meshes; linking it requires libwebp. Thread safe. */
#ifndef LF_BASE_IMAGE_RGBA_H
#define LF_BASE_IMAGE_RGBA_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Decodes PNG, JPEG or WebP, recognised by the first bytes, into 8-bit [height][width][4]: red,
 * green, blue, and an alpha that is not premultiplied (255 if the file has none). Grey is
 * replicated, palettes are expanded, 16-bit PNG is rounded, CMYK becomes RGB. No gamma, profile or
 * orientation is applied, as glTF requires. `where` names the picture in errors. Limits as in
 * image_io.h. The caller releases *out_rgba with lf_free. LF_E_FORMAT: another format, damaged,
 * truncated, too large or an animated WebP; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_image_rgba_decode(const void *data, size_t size, const char *where,
                                            uint8_t **out_rgba, int *out_width, int *out_height,
                                            lf_error *err);

#endif
