/* External pictures (skies, quilts, views), read by a reader process (import.h). */
#ifndef LF_BASE_RASTER_H
#define LF_BASE_RASTER_H

#include "base/file.h"
#include "base/image_metadata.h"
#include "base/sandbox/parcel.h"

/* A picture in the reader's parcel: not copied, read-only. */
typedef struct lf_raster {
    int width, height;
    /* one of the two, [height][width][3]: display encoded, or linear and finite */
    const uint8_t *data8;
    const float *data32;
    lf_image_metadata meta; /* metadata; orientation has been applied and is 0 */
    lf_parcel parcel;
} lf_raster;

/* Reads the picture file behind fd (which stays the caller's) with quiltimport-picture; path names
 * it in errors. floats: also decodes 8-bit pictures to linear floats. Formats, limits and channels:
 * base/image_io.h. On LF_OK release *out with lf_raster_close. LF_E_FORMAT; errors of
 * lf_import_run. Thread: any, several at once. */
LF_NODISCARD lf_status lf_raster_import(int fd, const char *path, bool floats, lf_raster *out,
                                        lf_error *err);
/* Reads a file by name, inside roots (NULL: anywhere). Also LF_E_PATH. */
LF_NODISCARD lf_status lf_raster_open(const char *path, const lf_roots *roots, bool floats,
                                      lf_raster *out, lf_error *err);
/* The same without floats, for paper: white shows through transparent parts of 8-bit pictures. */
LF_NODISCARD lf_status lf_raster_open_on_white(const char *path, const lf_roots *roots,
                                               lf_raster *out, lf_error *err);
/* Accepts a zeroed picture. */
void lf_raster_close(lf_raster *picture);

#endif
