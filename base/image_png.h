/* Private to the reader of PNG. */
#ifndef LF_BASE_IMAGE_PNG_H
#define LF_BASE_IMAGE_PNG_H

#include "base/image_formats.h"

/* Notes features of the file's chunks that the picture does not use, unless meta is NULL. profile:
 * the unpacked iCCP data; NULL: none that can be read. */
void lf_png_note(const lf_image_source *source, const uint8_t *profile, size_t size);

#endif
