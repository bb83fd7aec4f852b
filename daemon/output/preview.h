/* preview: a quilt of 8-bit views for clients that show it elsewhere (`frame.get`), smaller than
 * the views if they ask for it. Thread: any. */
#ifndef LF_DAEMON_PREVIEW_H
#define LF_DAEMON_PREVIEW_H

#include "base/thread.h"
#include "quilt/quilt.h"

typedef enum lf_preview_format {
    LF_PREVIEW_JPEG,
    LF_PREVIEW_RAW, /* the quilt's RGB bytes, rows from the top */
} lf_preview_format;

/* "jpeg", "raw". NULL after the last. */
const char *lf_preview_format_name(int format);

typedef struct lf_preview_options {
    int width; /* of a view in pixels; 0: as it is */
    lf_preview_format format;
    int quality; /* of JPEG, 1..100 */
} lf_preview_options;

/* Writes the views rgb [view][row][column][3] of this layout as a quilt, view 0 bottom left. A
 * smaller width is filtered by area in linear light, and the height follows it, rounded. The
 * caller commits the file, or abandons it on failure. *out_layout: the layout of the written
 * views. cancel is looked at between views. LF_E_ARG: the views are narrower than width, or the
 * quilt is too large for a JPEG; LF_E_IO, LF_E_NOMEM, LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_preview_write(const lf_preview_options *options, const uint8_t *rgb,
                                        const lf_layout *layout, const lf_cancel *cancel,
                                        lf_outfile *file, lf_layout *out_layout, lf_error *err);

#endif
