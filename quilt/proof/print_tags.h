/* Private to quilt/proof: the first directory of a TIFF, or the page of a PDF that quiltrender
 * wrote, read without a library. Every length and position is checked against the file. A PDF's
 * image is one strip. */
#ifndef LF_QUILT_PRINT_TAGS_H
#define LF_QUILT_PRINT_TAGS_H

#include "quilt/proof/print_file.h"

/* A filter per row, as in PNG files. */
#define LF_PREDICTOR_PNG 15
/* By which numbers of quiltrender's PDFs may be off, in points. */
#define LF_PDF_ROUNDING 1e-6

/* An array of whole numbers in the file; of a PDF, `at` is its only number itself. */
typedef struct lf_tiff_list {
    uint64_t at, count;
    int bytes; /* of an element: 1, 2, 4 or 8 */
} lf_tiff_list;

typedef struct lf_tiff {
    int fd;
    uint64_t size;
    const char *where;
    lf_print_tags tags;
    lf_tiff_list offsets, byte_counts; /* of the strips */
    uint64_t icc_at;
    lf_print_boxes boxes; /* of a PDF */
    bool is_pdf;
} lf_tiff;

/* Fills the rest from fd, size and where. LF_E_FORMAT, LF_E_IO. */
LF_NODISCARD lf_status lf_tiff_read(lf_tiff *tiff, lf_error *err);
/* Whether it begins as a PDF. */
bool lf_pdf_is(const lf_tiff *tiff);
/* The same for a PDF that quiltrender wrote. LF_E_FORMAT: another one, or it is damaged. */
LF_NODISCARD lf_status lf_pdf_tags_read(lf_tiff *tiff, lf_error *err);
/* Element i of a list. False: the file cannot be read there. */
bool lf_tiff_element(const lf_tiff *tiff, const lf_tiff_list *list, uint64_t i, uint64_t *out);
/* Reads n bytes at a position. False: not all of them are there. */
bool lf_tiff_bytes(const lf_tiff *tiff, uint64_t at, void *out, size_t n);

#endif
