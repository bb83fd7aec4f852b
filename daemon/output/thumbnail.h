/* thumbnail: a small JPEG of a picture file, for lists of files. Of a quilt, by its name, it shows
 * the middle view. Thread: any. */
#ifndef LF_DAEMON_THUMBNAIL_H
#define LF_DAEMON_THUMBNAIL_H

#include "quilt/quilt.h"

/* Reads the picture with a reader process (base/sandbox/raster.h) and writes the JPEG. It is at
 * most `width` pixels wide and 2 width high, and not larger than the picture. Each pixel is the
 * mean of the light on its area. Floating-point pictures get the automatic exposure
 * (lf_meter_exposure). The caller commits the file, or abandons it on failure. LF_E_FORMAT: not a
 * picture, damaged, or without a pixel per tile; errors of lf_raster_open and lf_jpeg_write_rows.
 */
LF_NODISCARD lf_status lf_thumbnail_write(const char *path, const lf_roots *roots, int width,
                                          lf_outfile *file, int *out_width, int *out_height,
                                          lf_error *err);

#endif
