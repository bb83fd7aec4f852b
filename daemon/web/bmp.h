/* bmp: an uncompressed Windows bitmap of 24 or 32 bits, as it comes, to rows of RGB from the top in
 * a memory file. Only one row is kept. Thread: any; a bitmap has one at a time. */
#ifndef LF_DAEMON_WEB_BMP_H
#define LF_DAEMON_WEB_BMP_H

#include <stdint.h>

#include "base/status.h"

#define LF_BMP_MAX_SIDE 16384 /* pixels: what quilt.show takes */

typedef struct lf_bmp lf_bmp;

/* fd: an empty file, open for writing, which stays the caller's. limit: bytes of its RGB.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_bmp_create(int fd, uint64_t limit, lf_bmp **out);
/* Accepts NULL. */
void lf_bmp_destroy(lf_bmp *bmp);

/* Takes the next data[n] of the bitmap. What follows the last row is skipped. LF_E_FORMAT: another
 * kind of bitmap, or larger than a limit; LF_E_IO; LF_E_NOMEM. Then no further call may follow. */
LF_NODISCARD lf_status lf_bmp_take(lf_bmp *bmp, const uint8_t *data, size_t n, lf_error *err);
/* The bitmap has ended. LF_E_FORMAT: it ended too early. */
LF_NODISCARD lf_status lf_bmp_finish(const lf_bmp *bmp, int *out_width, int *out_height,
                                     lf_error *err);

#endif
