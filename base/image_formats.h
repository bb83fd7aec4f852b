/* Private to base: one picture format is one table of functions in a file of its own, and one line
 * in image_io.c.
 *
 * Readers get an open descriptor at offset 0 (not theirs to close) or the file's bytes, its size,
 * and the name for errors. They fill *out on LF_OK only; a format leaves the function of the other
 * kind NULL and image_io.c converts. */
#ifndef LF_BASE_IMAGE_FORMATS_H
#define LF_BASE_IMAGE_FORMATS_H

#include "base/image_io.h"
#include "base/image_metadata.h"

typedef struct lf_image_source {
    int fd;
    uint64_t size_bytes;
    const char *where;
    const uint8_t *data;     /* the whole file, of 8-bit formats alone; NULL: it is behind fd */
    int channels;            /* that read8 is asked for: 3, or 4 with coverage */
    lf_image_metadata *meta; /* filled; NULL: nobody listens */
} lf_image_source;

typedef struct lf_image_format {
    const char *name;
    const char *const *endings; /* of files' names, ".png"; NULL after the last */
    lf_image_kind kind;
    bool (*recognises)(const uint8_t *head, size_t n);
    /* kind LF_IMAGE_8BIT */
    lf_status (*read8)(const lf_image_source *source, lf_image8 *out, lf_error *err);
    /* kind LF_IMAGE_FLOAT; ends with lf_image_settle (image_colours.h) */
    lf_status (*read32)(const lf_image_source *source, lf_image32 *out, lf_error *err);
} lf_image_format;

extern const lf_image_format lf_format_png, lf_format_jpeg, lf_format_exr, lf_format_hdr;
/* Of bytes in memory, with 4 channels: in no table but that of image_rgba.c, so that no program
 * needs its library but the one that reads meshes. */
extern const lf_image_format lf_format_webp;

/* Bytes that recognises() is shown. */
#define LF_IMAGE_HEAD_BYTES 16

/* Refuses shapes over the limits, and shapes that no honest file of this size holds (so that a few
 * hostile bytes cannot ask for gigabytes): more than 512 MiB of pixels at over 4096 times the
 * file's size. LF_E_FORMAT. */
LF_NODISCARD lf_status lf_image_check_shape(const lf_image_source *source, int64_t width,
                                            int64_t height, size_t bytes_per_pixel, lf_error *err);

/* What an error about a file being written is about: its name, or that it has none. */
const char *lf_outfile_name(const lf_outfile *file);

#endif
