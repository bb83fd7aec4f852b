/* image: one image of quiltd on its way to a browser: asked for by `frame.get` with a memory
 * file, and sent as one binary message (docs/reference/protocol.md, Gateway). Thread: event. */
#ifndef LF_DAEMON_WEB_IMAGE_H
#define LF_DAEMON_WEB_IMAGE_H

#include <jansson.h>
#include <stdint.h>

#include "base/status.h"

#define LF_WEB_IMAGE_HEADER 16
/* Largest JPEG that is passed on. */
#define LF_WEB_IMAGE_MAX_BYTES ((size_t)8 << 20)
/* Largest side of a quilt: what phones and small computers take as a texture. */
#define LF_WEB_IMAGE_MAX_SIDE 4096

/* What frame.get says of the image that it wrote. */
typedef struct lf_web_image {
    uint32_t generation;
    int level; /* 0 none, 1 coarse, 2 complete, 3 converged */
    int columns, rows, views;
    int width_px, height_px; /* of one view */
    size_t bytes;
} lf_web_image;

/* Reads a result of frame.get and compares it with the size of the memory file fd. LF_E_FORMAT. */
LF_NODISCARD lf_status lf_web_image_read(const json_t *result, int fd, lf_web_image *out,
                                         lf_error *err);
/* The number of a level by its name; 0 for an unknown name or NULL. */
int lf_web_image_level(const char *name);

/* Width at which to ask for the next image at a level, given the image as rendered; 0: as rendered.
 * Half until the image is complete, and never a quilt of more than LF_WEB_IMAGE_MAX_SIDE. Other
 * widths than the rendered one are multiples of 16. They may be up to a quarter smaller, so that
 * the height is a multiple of 8: no block of a JPEG then belongs to two views. */
int lf_web_image_width(const lf_web_image *rendered, int level);

/* True: the image may be a smaller copy of `rendered`. False: its scene has other views. */
bool lf_web_image_is_like(const lf_web_image *image, const lf_web_image *rendered);

/* Writes the header of the message. */
void lf_web_image_header(const lf_web_image *preview, uint8_t out[LF_WEB_IMAGE_HEADER]);
/* The whole message: *out_data[*out_n], header and JPEG; the caller frees. LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_web_image_message(const lf_web_image *preview, int fd, uint8_t **out_data,
                                            size_t *out_n, lf_error *err);

#endif
