/* Private to the reader of PNG. */
#ifndef LF_BASE_IMAGE_PNG_H
#define LF_BASE_IMAGE_PNG_H

#include "base/image_formats.h"

/* Notes what the file's chunks say and the picture lacks, unless nobody listens. profile: what its
 * iCCP holds, unpacked; NULL: nothing that can be read. */
void lf_png_note(const lf_image_source *source, const uint8_t *profile, size_t size);

#endif
