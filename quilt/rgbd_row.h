/* Private to quilt/: draws a row of a view from a row of the surface of a picture with depth. */
#ifndef LF_QUILT_RGBD_ROW_H
#define LF_QUILT_RGBD_ROW_H

#include "quilt/rgbd_surface.h"

/* The pixels of a row: pixel j is column[j] of the surface. The picture is [first, end); beyond it
 * pixels mirror those of the picture. */
typedef struct lf_rgbd_columns {
    int n;
    int *column; /* [n] */
    int first, end;
} lf_rgbd_columns;

/* A row of pixels, and memory of one worker. */
typedef struct lf_rgbd_row {
    lf_rgbd_columns columns; /* borrowed */
    uint16_t *light;         /* [n][3] */
    uint8_t *colour;         /* [n][3] */
    float *code;             /* [n]; below 0: the pixel is not there */
    float *left, *right; /* [n] codes at the edges: shared with the neighbour, except at a step */
    int *from, *to;      /* [n] samples of the view that a pixel covers */
    int *shown; /* [samples] the pixel at a sample; -1: none; -2 - j: the gap of a cut, between
                 * pixels j and j + 1 */
} lf_rgbd_row;
LF_NODISCARD lf_status lf_rgbd_row_init(lf_rgbd_row *row, const lf_rgbd_columns *columns,
                                        int n_samples);
void lf_rgbd_row_finish(lf_rgbd_row *row);
/* Takes row y of the surface. Beyond the picture's sides what is nearer than its edge is left out:
 * the background goes on, but no object appears twice. */
void lf_rgbd_row_take(lf_rgbd_row *row, const lf_rgbd_surface *surface, int y);

/* Pixel j lies at column j + offset + gain * code of the view. */
typedef struct lf_rgbd_move {
    double offset, gain;
} lf_rgbd_move;
/* Draws n_out pixels of a view. */
void lf_rgbd_row_draw(lf_rgbd_row *row, const lf_rgbd_light *light, const lf_rgbd_move *move,
                      int n_out, uint8_t *out);

#endif
