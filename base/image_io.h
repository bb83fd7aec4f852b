/* Reads and writes picture files: a table of formats, one file per format (image_png.c,
 * image_exr.c, image_jpeg.c, image_hdr.c). Readers find the format by contents, writers by the
 * ending of the name. Limits: 65536 pixels per side, 2^31 samples, files up to 4 GiB. Malformed
 * input gives LF_E_FORMAT, never a crash; even so, programs read external files in another process
 * (base/sandbox/raster.h). Thread safe. */
#ifndef LF_BASE_IMAGE_IO_H
#define LF_BASE_IMAGE_IO_H

#include "base/file.h"
#include "base/image.h"
#include "base/image_metadata.h"

#define LF_IMAGE_MAX_BYTES ((uint64_t)1 << 32)
#define LF_IMAGE_MAX_SIDE 65536

/* The native kind of a picture file. */
typedef enum lf_image_kind {
    LF_IMAGE_8BIT /* PNG, JPEG */,
    LF_IMAGE_FLOAT /* EXR, HDR */
} lf_image_kind;

/* Checks only the first bytes. LF_E_FORMAT: not PNG, JPEG, EXR or HDR. */
LF_NODISCARD lf_status lf_image_probe(const char *path, const lf_roots *roots,
                                      lf_image_kind *out_kind, lf_error *err);
/* Functions ending in _open read an open file, whatever its name leads to now. fd stays the
 * caller's; its offset afterwards is undefined. path names the file in errors. */
LF_NODISCARD lf_status lf_image_probe_open(int fd, const char *path, lf_image_kind *out_kind,
                                           lf_error *err);

/* The name of the format of an image that starts with these n bytes and that no function here
 * reads: TIFF, WebP, HEIC, AVIF. NULL: none. */
const char *lf_image_foreign(const uint8_t *head, size_t n);
/* True if path names a file of such a format; every reader refuses it with its name and a remedy.
 */
bool lf_image_is_foreign(const char *path, const lf_roots *roots);

/* The ending (".PNG") within path if it belongs to a picture format, otherwise NULL. */
const char *lf_image_ending(const char *path);
/* The index-th ending of float formats, without the dot; NULL after the last. */
const char *lf_image_float_ending(int index);

/* 8-bit RGB (3 channels), upright according to the EXIF orientation. Grey is replicated, alpha
 * dropped, 16-bit PNG rounded, palettes expanded. Float files are refused. */
LF_NODISCARD lf_status lf_image8_read(const char *path, const lf_roots *roots, lf_image8 *out,
                                      lf_error *err);
LF_NODISCARD lf_status lf_image8_read_open(int fd, const char *path, lf_image8 *out, lf_error *err);

/* Linear float RGB (3 channels) in Rec. 709, all finite. docs/reference/formats/images.md lists how
 * every feature of the formats is handled. EXR: scan lines and tiles; half, float and uint; every
 * compression of OpenEXRCore, including DWA; the data window is placed in the display window. Its
 * channels are R,G,B or Y of the first part that has them, otherwise those of the only layer,
 * otherwise the only channel. HDR: Radiance RGBE and XYZE, new and old run lengths, flipped axes.
 * Both are converted from the primaries they name. 8-bit pictures are decoded from sRGB. */
LF_NODISCARD lf_status lf_image32_read(const char *path, const lf_roots *roots, lf_image32 *out,
                                       lf_error *err);
LF_NODISCARD lf_status lf_image32_read_open(int fd, const char *path, lf_image32 *out,
                                            lf_error *err);

/* The same two functions with metadata: *meta is reset and filled, also on failure. */
LF_NODISCARD lf_status lf_image8_read_metadata(int fd, const char *path, lf_image8 *out,
                                               lf_image_metadata *meta, lf_error *err);
/* The same on white paper, which shows through transparent parts; otherwise alpha is ignored. */
LF_NODISCARD lf_status lf_image8_read_on_white(int fd, const char *path, lf_image8 *out,
                                               lf_image_metadata *meta, lf_error *err);
LF_NODISCARD lf_status lf_image32_read_metadata(int fd, const char *path, lf_image32 *out,
                                                lf_image_metadata *meta, lf_error *err);

/* The size of a PNG file, from its chunks alone: no pixel is read. LF_E_STATE: not a PNG;
 * LF_E_FORMAT: it has no size, or its end is missing; errors of lf_file_open. */
LF_NODISCARD lf_status lf_png_measure(const char *path, const lf_roots *roots, int *out_width,
                                      int *out_height, lf_error *err);

/* Size of a value of lf_png_texts with its NUL. */
#define LF_PNG_TEXT 320
/* The values of a PNG file's text attributes (tEXt) with these names, from its chunks alone; "":
 * there is none. Longer ones are cut. Errors as of lf_png_measure. */
LF_NODISCARD lf_status lf_png_texts(const char *path, const lf_roots *roots,
                                    const char *const *names, int n, char (*out)[LF_PNG_TEXT],
                                    lf_error *err);

/* A text attribute for an EXR header or a PNG tEXt chunk. */
typedef struct lf_attribute {
    const char *name, *value;
} lf_attribute;

/* Fills row [width][3]. Called for rows 0, 1, ... in order, so that a picture need not be in memory
 * as a whole. */
typedef void (*lf_rows8_fn)(void *context, int y, uint8_t *row);
typedef void (*lf_rows32_fn)(void *context, int y, float *row);

/* PNG, 8-bit RGB, sRGB chunk; level 1..9 is zlib's (1 for live pictures). attributes[n] may be NULL
 * with n 0; names up to 79 characters, values UTF-8. Does not publish or close: lf_outfile_commit
 * does. LF_E_IO, LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_png_write_rows(lf_outfile *file, int width, int height, lf_rows8_fn rows,
                                         void *context, int level, const lf_attribute *attributes,
                                         int n, lf_error *err);
/* PNG with a pixel aspect (width / height) other than 1, written as pHYs. */
typedef struct lf_png_size {
    int width, height;
    double pixel_aspect; /* 0.01..100; 0: square */
} lf_png_size;
LF_NODISCARD lf_status lf_png_write_oblong(lf_outfile *file, lf_png_size size, lf_rows8_fn rows,
                                           void *context, int level, const lf_attribute *attributes,
                                           int n, lf_error *err);
LF_NODISCARD lf_status lf_png_write(lf_outfile *file, const lf_image8 *image, int level,
                                    const lf_attribute *attributes, int n, lf_error *err);
/* JPEG, sRGB, colours at full resolution (4:4:4); quality 1..100 is libjpeg's. No attributes;
 * otherwise like lf_png_write_rows. LF_E_ARG: more than 65500 pixels per side. */
#define LF_JPEG_QUALITY 92 /* default */
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
    bool is_half;        /* stored as halfs, rounded to nearest; otherwise as floats */
} lf_channels32;

/* EXR, float or half, ZIP scan lines, with these channels; otherwise like lf_exr_write_rows. */
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
