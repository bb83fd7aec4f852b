/* Private to base: a picture format is a table of functions in a file of its own, and a line in
 * image_io.c.
 *
 * Readers get the file's size, a name for errors, and an open descriptor at offset 0 (which they do
 * not close) or the file's bytes. They fill *out only on LF_OK. A format leaves the function of the
 * other kind NULL; image_io.c converts. */
#ifndef LF_BASE_IMAGE_FORMATS_H
#define LF_BASE_IMAGE_FORMATS_H

#include "base/image_io.h"
#include "base/image_metadata.h"

typedef struct lf_image_source {
    int fd;
    uint64_t size_bytes;
    const char *where;
    const uint8_t *data;     /* the whole file, for 8-bit formats only; NULL: read from fd */
    bool on_white;           /* 3 channels: transparent parts show white, in linear light */
    int channels;            /* channels wanted from read8: 3, or 4 with coverage */
    lf_image_metadata *meta; /* to be filled; NULL: not wanted */
} lf_image_source;

typedef struct lf_image_format {
    const char *name;
    const char *const *endings; /* endings of file names, ".png"; NULL after the last */
    lf_image_kind kind;
    bool (*recognises)(const uint8_t *head, size_t n);
    /* kind LF_IMAGE_8BIT */
    lf_status (*read8)(const lf_image_source *source, lf_image8 *out, lf_error *err);
    /* kind LF_IMAGE_FLOAT; ends with lf_image_settle (image_colours.h) */
    lf_status (*read32)(const lf_image_source *source, lf_image32 *out, lf_error *err);
} lf_image_format;

extern const lf_image_format lf_format_png, lf_format_jpeg, lf_format_exr, lf_format_hdr;
/* For bytes in memory, with 4 channels. Only the table of image_rgba.c lists it, so that only the
 * program that reads meshes needs its library. */
extern const lf_image_format lf_format_webp;

/* Number of bytes passed to recognises(). */
#define LF_IMAGE_HEAD_BYTES 16

/* Refuses shapes over the limits, and implausible ones: more than 512 MiB of pixels if this is over
 * 4096 times the file's size. A few hostile bytes then cannot request gigabytes. LF_E_FORMAT. */
LF_NODISCARD lf_status lf_image_check_shape(const lf_image_source *source, int64_t width,
                                            int64_t height, size_t bytes_per_pixel, lf_error *err);

/* The name of a file being written, for errors, or text saying that it has none. */
const char *lf_outfile_name(const lf_outfile *file);

#endif
