/* Pictures from outside, read elsewhere (import.h): skies, quilts, views. */
#ifndef LF_BASE_RASTER_H
#define LF_BASE_RASTER_H

#include "base/file.h"
#include "base/image_metadata.h"
#include "base/sandbox/parcel.h"

/* A picture in the memory that its reader handed over: not copied, read-only. */
typedef struct lf_raster {
    int width, height;
    /* one of both, [height][width][3]: display encoded, or linear and finite */
    const uint8_t *data8;
    const float *data32;
    lf_image_metadata meta; /* what else the file says; orientation has been obeyed, and is 0 */
    lf_parcel parcel;
} lf_raster;

/* Has the picture file behind fd (which stays the caller's) read by quiltimport-picture; path names
 * it in errors. floats: 8-bit pictures are decoded to linear floats, too. Formats, limits and what
 * becomes of channels: base/image_io.h. On LF_OK *out is released with lf_raster_close. Errors:
 * LF_E_FORMAT, and what lf_import_run gives. Thread: any, several at once. */
LF_NODISCARD lf_status lf_raster_import(int fd, const char *path, bool floats, lf_raster *out,
                                        lf_error *err);
/* The same of a file by its name, under roots (NULL: anywhere); LF_E_PATH as well. */
LF_NODISCARD lf_status lf_raster_open(const char *path, const lf_roots *roots, bool floats,
                                      lf_raster *out, lf_error *err);
/* Accepts a zeroed one. */
void lf_raster_close(lf_raster *picture);

#endif
