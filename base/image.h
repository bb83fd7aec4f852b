/* Plain image structs shared by the modules. Row 0 is the top row everywhere. */
#ifndef LF_BASE_IMAGE_H
#define LF_BASE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Interleaved picture; owner of data unless stated otherwise. */
typedef struct lf_image8 {
    int width, height, channels; /* channels 1..4 */
    size_t stride;               /* bytes from row to row, >= width * channels */
    uint8_t *data;               /* [height][stride], display encoded (sRGB unless stated) */
} lf_image8;

typedef struct lf_image32 {
    int width, height, channels; /* channels 1..4 */
    float *data;                 /* [height][width][channels], linear Rec. 709 */
} lf_image32;

/* Zeroed picture. Limits: width and height 1..65536, at most 2^31 samples. LF_E_ARG, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_image8_init(lf_image8 *image, int width, int height, int channels);
LF_NODISCARD lf_status lf_image32_init(lf_image32 *image, int width, int height, int channels);
/* Accept zeroed structs; leave them zeroed. */
void lf_image8_finish(lf_image8 *image);
void lf_image32_finish(lf_image32 *image);

/* Copies a picture into the upright position for an EXIF orientation (1..8). 3 is half a turn, 6 a
 * quarter turn clockwise, 8 a quarter turn anticlockwise. width and height are those of `in`, whose
 * rows are in_stride bytes apart. out is packed, [width][height] pixels if lf_orientation_swaps.
 * Values outside 2..8 copy only. */
void lf_orient(int orientation, const void *in, size_t in_stride, int width, int height,
               size_t pixel_bytes, void *out);
/* True if width and height are swapped. */
static inline bool lf_orientation_swaps(int orientation)
{
    return orientation >= 5 && orientation <= 8;
}

/* Linear light of 8-bit codes, by sRGB (IEC 61966-2-1). */
void lf_srgb_light(float out[256]);

/* The views of one light field, 8-bit display-encoded RGB, 3 bytes per pixel. The strides describe
 * either a stack of views or the film's order [row][view][column]. Borrowed, not owned. View 0 is
 * the leftmost camera. */
typedef struct lf_views8 {
    int n_views, width, height;     /* width and height of a view in pixels */
    size_t view_stride, row_stride; /* bytes from view to view, and from row to row of one view */
    const uint8_t *data;
} lf_views8;

/* Channels in addition to the colours of float views, n per pixel. */
typedef struct lf_layers32 {
    int n;
    const char *const *names;       /* [n] names in EXR files */
    size_t view_stride, row_stride; /* in floats */
    const float *data;
} lf_layers32;

/* Like lf_views8, with linear float RGB (12 bytes per pixel); strides in floats. For file writers
 * only (lf_print_write, lf_quilt_write_exr, lf_view_write_exr), 8-bit codes may replace the floats:
 * data is NULL, light[code] is the linear value, and strides count codes. */
typedef struct lf_views32 {
    int n_views, width, height;
    size_t view_stride, row_stride;
    const float *data;
    const lf_layers32 *layers; /* NULL: none */
    const uint8_t *codes;
    const float *light; /* [256] */
} lf_views32;

static inline const uint8_t *lf_views8_row(const lf_views8 *v, int view, int row)
{
    return v->data + (size_t)view * v->view_stride + (size_t)row * v->row_stride;
}

static inline const float *lf_views32_row(const lf_views32 *v, int view, int row)
{
    return v->data + (size_t)view * v->view_stride + (size_t)row * v->row_stride;
}

static inline const uint8_t *lf_views32_codes(const lf_views32 *v, int view, int row)
{
    return v->codes + (size_t)view * v->view_stride + (size_t)row * v->row_stride;
}

static inline const float *lf_layers32_row(const lf_layers32 *l, int view, int row)
{
    return l->data + (size_t)view * l->view_stride + (size_t)row * l->row_stride;
}

/* Half-open rectangle in pixels: [x, x + width) x [y, y + height), y downwards. */
typedef struct lf_rect {
    int x, y, width, height;
} lf_rect;

#endif
