/* Private to quilt/proof: the first directory of a TIFF, read without a library. Every length and
 * position is checked against the file. */
#ifndef LF_QUILT_PRINT_TAGS_H
#define LF_QUILT_PRINT_TAGS_H

#include "quilt/proof/print_file.h"

/* An array of whole numbers in the file. */
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
} lf_tiff;

/* Fills the rest from fd, size and where. LF_E_FORMAT, LF_E_IO. */
LF_NODISCARD lf_status lf_tiff_read(lf_tiff *tiff, lf_error *err);
/* Element i of a list. False: the file cannot be read there. */
bool lf_tiff_element(const lf_tiff *tiff, const lf_tiff_list *list, uint64_t i, uint64_t *out);
/* Reads n bytes at a position. False: not all of them are there. */
bool lf_tiff_bytes(const lf_tiff *tiff, uint64_t at, void *out, size_t n);

#endif
