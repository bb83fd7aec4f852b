/* A print file as a printer would get it: its tags, its colour profile, its rows as linear light,
 * and the manifest beside it. It is a TIFF of any program, or a PDF that quiltrender wrote. The
 * file may come from anyone. Wrong bytes give LF_E_FORMAT with one line; memory stays bounded by a
 * few rows, whatever the file says.
 *
 * Thread: an opened file belongs to one thread, except for lf_print_file_light, which is thread
 * safe. Open the file once per thread to read it in several. */
#ifndef LF_QUILT_PRINT_FILE_H
#define LF_QUILT_PRINT_FILE_H

#include <stdint.h>

#include "base/paths.h"

/* At most this many pixels a side. */
#define LF_PRINT_FILE_MAX_SIDE (1 << 21)
#define LF_PRINT_FILE_MAX_PROFILE ((uint64_t)16 << 20)
#define LF_PRINT_FILE_MAX_MANIFEST ((uint64_t)4 << 20)

/* What the first directory of the TIFF says, in TIFF's numbers and with TIFF's defaults. A PDF's
 * image is told in the same numbers, without resolution, which its matrix has. */
typedef struct lf_print_tags {
    int width, height;
    int samples;       /* of a pixel, with extra ones */
    int bits;          /* of a sample; 0: they differ */
    int extra_samples; /* how many of the samples are alpha or unknown */
    int photometric;   /* 2 RGB, 5 inks */
    int ink_set;       /* 1 CMYK */
    int compression;   /* 1 none, 5 LZW, 8 and 32946 deflate, 6 and 7 JPEG */
    int predictor;     /* 1 none, 2 horizontal, 15 of a PDF: a filter per row */
    int planar;        /* 1 one plane, 2 one per channel */
    int orientation;   /* 1 upright */
    int sample_format; /* 1 whole numbers */
    int fill_order;    /* 1 */
    int unit;          /* of the resolution: 1 none, 2 inch, 3 centimetre */
    /* numerator and denominator as stored, to the right and down; {0, 0}: no tag */
    uint32_t resolution[2][2];
    double dpi[2]; /* dots per inch, to the right and down; 0: not known, or none of a printer */
    int rows_per_strip, n_strips;
    bool tiled, palette;
    bool big;                       /* BigTIFF */
    bool big_endian;                /* MM */
    bool more_pages;                /* a second directory follows */
    uint64_t file_bytes, icc_bytes; /* icc_bytes 0: no profile */
} lf_print_tags;

/* The page of a PDF, in points (1/72 inch) from its lower left corner: left, lower, right, upper.
 */
typedef struct lf_print_boxes {
    double media[4], bleed[4], trim[4];
    double matrix[6];  /* of the image, which is 1 x 1 without it */
    bool has_intent;   /* an output intent with a profile */
    bool says_x;       /* states PDF/X-4 */
    bool interpolated; /* readers may smooth the image */
    bool turned;       /* the page is rotated or scaled */
} lf_print_boxes;

typedef struct lf_print_file lf_print_file;

/* Opens and checks a file; reads its tags and profile, no rows. A file whose rows cannot be read
 * (lf_print_file_unreadable) opens all the same, so that its tags can be judged. LF_E_PATH,
 * LF_E_IO; LF_E_FORMAT: neither a TIFF nor a PDF of quiltrender, a damaged directory, fewer bytes
 * than the raster needs, over the limits; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_print_file_open(const char *path, const lf_roots *roots,
                                          lf_print_file **out, lf_error *err);
void lf_print_file_close(lf_print_file *file); /* accepts NULL */

const lf_print_tags *lf_print_file_tags(const lf_print_file *file);
/* Of a PDF; NULL: the file is a TIFF. */
const lf_print_boxes *lf_print_file_boxes(const lf_print_file *file);
/* The embedded profile; NULL: none. Owned by the file. */
const void *lf_print_file_icc(const lf_print_file *file, size_t *out_size);
/* Name in the profile, printable ASCII; "" without a usable profile. */
const char *lf_print_file_profile_name(const lf_print_file *file);
/* Why the profile is not used, NULL: it is. Without one, RGB is read as sRGB, and CMYK as ideal
 * inks (the light that four coverages leave). */
const char *lf_print_file_profile_problem(const lf_print_file *file);
/* Why rows cannot be read, e.g. "JPEG compression"; NULL: they can. Static text. */
const char *lf_print_file_unreadable(const lf_print_file *file);

/* Row y as it is stored: [width][samples] of uint8_t or uint16_t (native order). Rows may be read
 * in any order; rising order is fast. LF_E_FORMAT: damaged or unreadable; LF_E_IO. */
LF_NODISCARD lf_status lf_print_file_raw(lf_print_file *file, int y, void *out, lf_error *err);
/* Bytes of such a row. */
size_t lf_print_file_raw_bytes(const lf_print_file *file);
/* n stored pixels as linear light (Rec. 709) [n][3]. Paper is 1, the profile's black is 0. */
void lf_print_file_light(const lf_print_file *file, const void *raw, size_t n, float *out);
/* Row y as linear light [width][3]; errors of lf_print_file_raw. */
LF_NODISCARD lf_status lf_print_file_row(lf_print_file *file, int y, float *out, lf_error *err);

struct json_t;
/* The manifest beside a print, sheet.json for sheet.tif: an object with "quiltd_print". *out is a
 * new reference, NULL if there is no such file. LF_E_FORMAT: not a manifest; LF_E_IO, LF_E_PATH. */
LF_NODISCARD lf_status lf_print_file_manifest(const char *path, const lf_roots *roots,
                                              struct json_t **out, lf_error *err);

#endif
