/* Reading and writing picture files: a table of formats, one file a format (image_png.c,
 * image_exr.c, image_jpeg.c, image_hdr.c). Format is found by contents when reading and by the
 * name's ending when writing. Limits: 65536 pixels a side, 2^31 samples, files up to 4 GiB.
 * Malformed input gives LF_E_FORMAT, never a crash; all the same the programs have what comes from
 * outside read elsewhere (base/sandbox/raster.h). Thread safe. */
#ifndef LF_BASE_IMAGE_IO_H
#define LF_BASE_IMAGE_IO_H

#include "base/file.h"
#include "base/image.h"
#include "base/image_metadata.h"

#define LF_IMAGE_MAX_BYTES ((uint64_t)1 << 32)
#define LF_IMAGE_MAX_SIDE 65536

/* Which form the picture in a file has by nature. */
typedef enum lf_image_kind {
    LF_IMAGE_8BIT /* PNG, JPEG */,
    LF_IMAGE_FLOAT /* EXR, HDR */
} lf_image_kind;

/* Looks at the first bytes only. LF_E_FORMAT when it is none of PNG, JPEG, EXR, HDR. */
LF_NODISCARD lf_status lf_image_probe(const char *path, const lf_roots *roots,
                                      lf_image_kind *out_kind, lf_error *err);
/* This and what ends in _open: of a file that is open, whatever its name leads to by now. fd stays
 * the caller's, and stands anywhere afterwards; path names the file in errors. */
LF_NODISCARD lf_status lf_image_probe_open(int fd, const char *path, lf_image_kind *out_kind,
                                           lf_error *err);

/* Where the ending of a name (".PNG") begins, in path, when it is a picture format's; else NULL. */
const char *lf_image_ending(const char *path);
/* The endings of formats of floats one after the other, without the dot; NULL after the last. */
const char *lf_image_float_ending(int index);

/* 8-bit RGB (3 channels; grey is spread, alpha dropped, 16-bit PNG rounded, palettes expanded), the
 * way up that EXIF's orientation says.
 * Floats are not accepted. */
LF_NODISCARD lf_status lf_image8_read(const char *path, const lf_roots *roots, lf_image8 *out,
                                      lf_error *err);
LF_NODISCARD lf_status lf_image8_read_open(int fd, const char *path, lf_image8 *out, lf_error *err);

/* Linear float RGB (3 channels) of Rec. 709, all finite. docs/formats/images.md says what becomes
 * of everything that the formats know. EXR: scan lines and tiles, half, float and uint, every
 * compression of OpenEXRCore (DWA too), the channels R,G,B or Y of the first part that has them,
 * else of the only layer, else the only channel; data window placed in the display window. HDR:
 * Radiance RGBE and XYZE, new and old run lengths, flipped axes. Both are converted from the
 * primaries that they name. 8-bit pictures are decoded from sRGB. */
LF_NODISCARD lf_status lf_image32_read(const char *path, const lf_roots *roots, lf_image32 *out,
                                       lf_error *err);
LF_NODISCARD lf_status lf_image32_read_open(int fd, const char *path, lf_image32 *out,
                                            lf_error *err);

/* The same two, and what else the file says: *said is filled anew, whatever comes of it. */
LF_NODISCARD lf_status lf_image8_read_metadata(int fd, const char *path, lf_image8 *out,
                                               lf_image_metadata *meta, lf_error *err);
LF_NODISCARD lf_status lf_image32_read_metadata(int fd, const char *path, lf_image32 *out,
                                                lf_image_metadata *meta, lf_error *err);

/* A text attribute written into an EXR header or PNG tEXt chunk. */
typedef struct lf_attribute {
    const char *name, *value;
} lf_attribute;

/* Asked for rows 0, 1, ... in order, so that a picture need not lie in memory whole: fills row
 * [width][3]. */
typedef void (*lf_rows8_fn)(void *context, int y, uint8_t *row);
typedef void (*lf_rows32_fn)(void *context, int y, float *row);

/* PNG, 8-bit RGB, sRGB chunk; level 1..9 is zlib's (1 for live pictures). attributes[n] may be NULL
 * with n 0; names up to 79 characters, values UTF-8. Nothing is published or closed: that is
 * lf_outfile_commit's. LF_E_IO, LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_png_write_rows(lf_outfile *file, int width, int height, lf_rows8_fn rows,
                                         void *context, int level, const lf_attribute *attributes,
                                         int n, lf_error *err);
/* The same of pixels whose width / height is not 1, which a pHYs says. */
typedef struct lf_png_size {
    int width, height;
    double pixel_aspect; /* 0.01..100; 0: square */
} lf_png_size;
LF_NODISCARD lf_status lf_png_write_oblong(lf_outfile *file, lf_png_size size, lf_rows8_fn rows,
                                           void *context, int level, const lf_attribute *attributes,
                                           int n, lf_error *err);
LF_NODISCARD lf_status lf_png_write(lf_outfile *file, const lf_image8 *image, int level,
                                    const lf_attribute *attributes, int n, lf_error *err);
/* JPEG, sRGB, colours at full resolution (4:4:4); quality 1..100 is libjpeg's. No attributes. Else
 * as lf_png_write_rows. LF_E_ARG: more than 65500 pixels a side. */
#define LF_JPEG_QUALITY 92 /* where nobody says one */
LF_NODISCARD lf_status lf_jpeg_write_rows(lf_outfile *file, int width, int height, lf_rows8_fn rows,
                                          void *context, int quality, lf_error *err);
/* Channels by name, each once; rows fills [width][n] in their order. */
#define LF_EXR_MAX_CHANNELS 32
typedef struct lf_channels32 {
    const char *const *names;
    int n; /* at most LF_EXR_MAX_CHANNELS */
    lf_rows32_fn rows;
    void *context;
    double pixel_aspect; /* width / height of a pixel; 0: square */
} lf_channels32;

/* EXR, 32-bit float, ZIP scan lines, of these channels; else as lf_exr_write_rows. */
LF_NODISCARD lf_status lf_exr_write_channels(lf_outfile *file, int width, int height,
                                             const lf_channels32 *channels,
                                             const lf_attribute *attributes, int n, lf_error *err);
/* EXR, 32-bit float RGB, ZIP scan lines; attributes become string attributes (names up to 255
 * characters). The file must be seekable. The same pixels and attributes give the same bytes. */
LF_NODISCARD lf_status lf_exr_write_rows(lf_outfile *file, int width, int height, lf_rows32_fn rows,
                                         void *context, const lf_attribute *attributes, int n,
                                         lf_error *err);
LF_NODISCARD lf_status lf_exr_write(lf_outfile *file, const lf_image32 *image,
                                    const lf_attribute *attributes, int n, lf_error *err);

#endif
