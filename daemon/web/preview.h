/* preview: one image of quiltd on its way to a browser: asked for by `frame.get` with a memory
 * file, and sent as one binary message (docs/reference/protocol.md, Gateway). Thread: event. */
#ifndef LF_DAEMON_WEB_PREVIEW_H
#define LF_DAEMON_WEB_PREVIEW_H

#include <jansson.h>
#include <stdint.h>

#include "base/status.h"

#define LF_PREVIEW_HEADER 16
/* Largest JPEG that is passed on. */
#define LF_PREVIEW_MAX_BYTES ((size_t)8 << 20)
/* Largest side of a quilt: what phones and small computers take as a texture. */
#define LF_PREVIEW_MAX_SIDE 4096

/* What frame.get says of the image that it wrote. */
typedef struct lf_preview {
    uint32_t generation;
    int level; /* 0 none, 1 coarse, 2 complete, 3 converged */
    int columns, rows, views;
    int width_px, height_px; /* of one view */
    size_t bytes;
} lf_preview;

/* Reads a result of frame.get and compares it with the size of the memory file fd. LF_E_FORMAT. */
LF_NODISCARD lf_status lf_preview_read(const json_t *result, int fd, lf_preview *out,
                                       lf_error *err);
/* The number of a level by its name; 0 for an unknown name or NULL. */
int lf_preview_level(const char *name);

/* Width at which to ask for the next image at a level, given the image as rendered; 0: as rendered.
 * Half until the image is complete, and never a quilt of more than LF_PREVIEW_MAX_SIDE. Widths
 * other than the rendered one are multiples of 16, so that no block of a JPEG belongs to two views.
 */
int lf_preview_width(const lf_preview *rendered, int level);

/* Writes the header of the message. */
void lf_preview_header(const lf_preview *preview, uint8_t out[LF_PREVIEW_HEADER]);
/* The whole message: *out_data[*out_n], header and JPEG; the caller frees. LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_preview_message(const lf_preview *preview, int fd, uint8_t **out_data,
                                          size_t *out_n, lf_error *err);

/* A new memory file; the caller closes it. LF_E_IO. */
LF_NODISCARD lf_status lf_preview_file(int *out_fd, lf_error *err);

#endif
