/* Private to quilt/proof: the bytes of a strip, decoded as a stream. Memory is a fixed buffer
 * whatever the file says: no strip is held whole. */
#ifndef LF_QUILT_PRINT_STRIP_H
#define LF_QUILT_PRINT_STRIP_H

#include "quilt/proof/print_tags.h"

typedef struct lf_strip lf_strip;

/* For the compressions none, LZW and deflate. Borrows tiff. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_strip_create(const lf_tiff *tiff, lf_strip **out);
void lf_strip_destroy(lf_strip *strip); /* accepts NULL */
/* Goes to the beginning of a strip. False: its place is not in the file. */
bool lf_strip_begin(lf_strip *strip, int number);
/* The next n decoded bytes. False: damaged, or the strip ends before. */
bool lf_strip_read(lf_strip *strip, void *out, size_t n);
/* Leaves out the next n bytes of a strip without compression. False: it ends before. */
bool lf_strip_skip(lf_strip *strip, uint64_t n);

#endif
