/* Private to quilt/: one row of a picture with depth, from its pixels to the rows of all views.
 *
 * A working row has one pixel per column of the view, and continues to both sides by a margin for
 * what moves into the view. Pixel j is a piece of surface over the columns [j, j + 1), with one
 * colour, and a code at each of its two edges. Neighbours share the code of an edge, except at a
 * step. */
#ifndef LF_QUILT_RGBD_ROW_H
#define LF_QUILT_RGBD_ROW_H

#include "quilt/axis.h"
#include "quilt/rgbd.h"

/* Codes of light: 16 bits, linear. */
typedef struct lf_rgbd_light {
    float of_code[256];
    uint8_t code_of[65536]; /* the nearest code by its sRGB value */
} lf_rgbd_light;
void lf_rgbd_light_init(lf_rgbd_light *light);

/* The rows of both halves that make one row of the view: n of each, with weights. */
typedef struct lf_rgbd_source {
    const uint8_t *colour, *depth; /* the first row, at the first column of its half */
    size_t stride;
    int n;
    const float *weight; /* [n], sum 1 */
    int width;           /* of a half */
} lf_rgbd_source;

/* Memory for rows of n working pixels from a half of `width` columns. */
typedef struct lf_rgbd_row {
    int n;
    /* per column of the half, reduced over its rows */
    float *light;                       /* [width][3], 0..65535 */
    float *least, *mean, *most, *chief; /* codes; chief: of the row with the greatest weight */
    /* per working pixel */
    uint16_t *light16; /* [n][3] */
    uint8_t *colour;   /* [n][3] */
    float *code, *spare;
    float *left, *right; /* codes at its edges; equal to the neighbour's except at a step */
    int *from, *to;      /* samples of the view that it covers */
    int *shown;          /* [samples] the working pixel at a sample; -1: none */
} lf_rgbd_row;
LF_NODISCARD lf_status lf_rgbd_row_init(lf_rgbd_row *row, int n, int width, int n_samples);
void lf_rgbd_row_finish(lf_rgbd_row *row);

/* How the working pixels lie on the columns of the half: pixel j is sample column[j] of the filter;
 * enlarged: a footprint of less than a pixel both ways. */
typedef struct lf_rgbd_columns {
    const lf_axis_filter *filter;
    const int *column; /* [row->n] */
    bool enlarged;
} lf_rgbd_columns;
/* Fills the working row: colours by area in linear light; codes sharpened at steps. */
void lf_rgbd_row_take(lf_rgbd_row *row, const lf_rgbd *rgbd, const lf_rgbd_light *light,
                      const lf_rgbd_source *source, const lf_rgbd_columns *columns);

/* Draws n_out pixels of a view. Working pixel j lies at column j + offset + gain * code. */
typedef struct lf_rgbd_move {
    double offset, gain;
} lf_rgbd_move;
void lf_rgbd_row_draw(lf_rgbd_row *row, const lf_rgbd_light *light, const lf_rgbd_move *move,
                      int n_out, uint8_t *out);

#endif
