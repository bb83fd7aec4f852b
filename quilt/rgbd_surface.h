/* Private to quilt/: the surface that a picture with depth is, on the pixels of a view.
 *
 * It has one pixel per column of the view, and more at the sides, for what moves into the view.
 * Pixel j of a row is a piece of surface over the columns [j, j + 1), with one colour and one code.
 * Steps between neighbours are sharp, and the rim of what is in front belongs to it. */
#ifndef LF_QUILT_RGBD_SURFACE_H
#define LF_QUILT_RGBD_SURFACE_H

#include "quilt/axis.h"
#include "quilt/rgbd.h"

/* Light in 16 bits, linear. */
typedef struct lf_rgbd_light {
    float of_code[256];
    uint8_t code_of[65536]; /* the nearest code */
} lf_rgbd_light;
void lf_rgbd_light_init(lf_rgbd_light *light);

typedef struct lf_rgbd_surface {
    int n, height;
    int plateau;     /* pixels of 5 x 5 with one code that are a surface and no part of a slope */
    uint16_t *light; /* [height][n][3] */
    uint8_t *colour; /* the same, display encoded */
    float *code;     /* [height][n] */
    float *spare;    /* for the next step of code */
} lf_rgbd_surface;
LF_NODISCARD lf_status lf_rgbd_surface_init(lf_rgbd_surface *surface, int n, int height);
void lf_rgbd_surface_finish(lf_rgbd_surface *surface);

/* The rows of both halves that make one row of the surface. */
typedef struct lf_rgbd_source {
    const uint8_t *colour, *depth; /* the first row, at the first column of its half */
    size_t stride;
    int n;
    const float *weight; /* [n], sum 1 */
    int width;           /* of a half */
    bool enlarged;       /* a pixel covers less than one of the picture, both ways */
} lf_rgbd_source;

/* One row of the picture's halves, per column of a half; memory of one worker. */
typedef struct lf_rgbd_strip {
    float *light;                       /* [width][3], 0..65535 */
    float *least, *mean, *most, *chief; /* codes; chief: of the row with the greatest weight */
} lf_rgbd_strip;
LF_NODISCARD lf_status lf_rgbd_strip_init(lf_rgbd_strip *strip, int width);
void lf_rgbd_strip_finish(lf_rgbd_strip *strip);

/* Fills row y of the surface: colours by area in linear light. Sample j of the filter is pixel j.
 */
void lf_rgbd_surface_take(lf_rgbd_surface *surface, int y, const lf_rgbd *rgbd,
                          const lf_rgbd_light *light, const lf_rgbd_source *source,
                          const lf_axis_filter *filter, lf_rgbd_strip *strip);
/* Writes row y of `spare` from the codes about it: makes steps of slopes that are too steep to be a
 * surface. To be done LF_RGBD_SHARPEN times, and each time the caller swaps code and spare. */
enum { LF_RGBD_SHARPEN = 3 };
void lf_rgbd_surface_sharpen(const lf_rgbd_surface *surface, int y);
/* The same, once, for what is between two steps: a mixture, which joins the nearer side. */
void lf_rgbd_surface_join(const lf_rgbd_surface *surface, int y);
/* The same for the last steps: what is in front of a step grows by one pixel. */
void lf_rgbd_surface_widen(const lf_rgbd_surface *surface, int y);

#endif
