/* Private to quilt: a PDF 1.6 file with one page, written in one pass: at most one image, and text
 * and rectangles in Helvetica.
 *
 * Lengths are points (1/72 inch), origin at the lower left corner of the page, y UP. The bytes
 * depend only on the arguments: both dates are 2000-01-01, and the document's identity is a hash of
 * its content. Memory: the texts, and what the caller packs.
 *
 * Order of calls: open, then images, texts and rectangles in the order in which they are painted,
 * then close. Objects are used by one thread, except where said. */
#ifndef LF_QUILT_PDF_H
#define LF_QUILT_PDF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/file.h"

/* The largest page that readers accept, and the largest file that the format addresses. */
#define LF_PDF_MAX_POINTS 14400.0
#define LF_PDF_MAX_BYTES 9999999999.0

typedef struct lf_pdf lf_pdf;

/* Zeroed members after the line are a valid default. Borrowed until close. */
typedef struct lf_pdf_page {
    double width, height; /* MediaBox: 3 .. LF_PDF_MAX_POINTS */
    const char *title;    /* UTF-8; other bytes become '?' */
    /* ---- */
    double trim[4], bleed[4]; /* left, lower, right, upper; all 0: the whole page */
    /* The profile of the image and of the output intent; NULL: none. If its device class is a
     * printer's, the file states PDF/X-4, and must have no text, because Helvetica is not
     * embedded. */
    const void *profile;
    size_t profile_size;
    int profile_channels;     /* 3 RGB, 4 CMYK */
    const char *profile_name; /* printable ASCII */
} lf_pdf_page;

/* Starts the file: LF_E_IO, LF_E_NOMEM. LF_E_ARG: the page is too large or too small. */
LF_NODISCARD lf_status lf_pdf_open(lf_outfile *file, const lf_pdf_page *page, lf_pdf **out,
                                   lf_error *err);
/* Finishes the file and releases the object, also after a failure. Reports the first error of all
 * calls without one of their own. LF_E_IO, LF_E_NOMEM; LF_E_ARG: more than LF_PDF_MAX_BYTES. */
LF_NODISCARD lf_status lf_pdf_close(lf_pdf *pdf, lf_error *err);
/* Releases it without finishing the file; accepts NULL. */
void lf_pdf_abandon(lf_pdf *pdf);
/* True if the page's profile is a printer's, so that the file states PDF/X-4. */
bool lf_pdf_page_is_x(const lf_pdf_page *page);

/* -------------------------------------------------------------------------- text, rectangles -- */

/* One line of text whose baseline starts at x, y. UTF-8; what Latin-1 lacks becomes '?'. size: of
 * the font, in points. grey: 0 black to 1 white. Errors are kept for close. */
void lf_pdf_text(lf_pdf *pdf, double x, double y, double size, bool bold, double grey,
                 const char *text);
/* Width of such a line, in points. */
double lf_pdf_text_width(double size, bool bold, const char *text);
/* A filled rectangle; its lower left corner is x, y. */
void lf_pdf_rect(lf_pdf *pdf, double x, double y, double width, double height, double grey);

/* ------------------------------------------------------------------------------------- image -- */

/* One image, lossless (Flate with a predictor per row). It has the colours of the page's profile,
 * or DeviceGray, DeviceRGB or DeviceCMYK without one. Interpolation is off. */
typedef struct lf_pdf_image {
    int width, height;
    int channels; /* 1, 3 or 4 */
    int bits;     /* 8 or 16 */
    double x, y;  /* lower left corner */
    double width_pt, height_pt;
} lf_pdf_image;

/* Some rows of the image, compressed. Zeroed is valid; finish releases it. */
typedef struct lf_pdf_strip {
    unsigned char *data; /* what is written */
    size_t size, room;
    size_t raw; /* bytes before compression */
    uint32_t check;
    struct z_stream_s *deflate;
    unsigned char *rows; /* scratch: the filtered rows */
    size_t rows_room;
} lf_pdf_strip;

/* Compresses rows of pixels, [rows][width][channels], native byte order, without gaps. Strips are
 * independent: any thread may pack any of them, in any order, each into a struct of its own. last:
 * the strip ends the image. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_pdf_strip_pack(const lf_pdf_image *image, const void *pixels, int rows,
                                         bool last, lf_pdf_strip *strip);
void lf_pdf_strip_finish(lf_pdf_strip *strip);

/* Starts the page's only image; its strips follow, in order from the top, and then its end. */
LF_NODISCARD lf_status lf_pdf_image_begin(lf_pdf *pdf, const lf_pdf_image *image, lf_error *err);
LF_NODISCARD lf_status lf_pdf_image_strip(lf_pdf *pdf, const lf_pdf_strip *strip, lf_error *err);
LF_NODISCARD lf_status lf_pdf_image_end(lf_pdf *pdf, lf_error *err);

#endif
