/* Private to quilt/print: which dots of a print an eye sees, and what to print so that it sees a
 * given light (docs/developer/print-compensation.md).
 *
 * Dots are the pixels of the raster along the axis across the lenses, or stripes. The eye looks at
 * places along the same axis, usually the middles of the stripes. What it sees at place t is the
 * sum over d < width of share[t][d] * light of dot first[t] + d.
 *
 * Values have LF_LANES independent lanes: the channels of a row, or parts of a line. */
#ifndef LF_QUILT_CROSSTALK_H
#define LF_QUILT_CROSSTALK_H

#include <stdbool.h>

#include "base/status.h"

#define LF_LANES 4
/* The most dots that an eye may see at one place. */
#define LF_CROSSTALK_WIDTH 64

typedef struct lf_crosstalk {
    int n_places, n_dots, width;
    int *first;     /* [n_places] rising; the whole row is within 0..n_dots-1 */
    double *share;  /* [n_places][width], sum 1; all 0 for a place outside the raster */
    int *from, *to; /* [n_dots] the places that may see a dot: from..to-1 */
} lf_crosstalk;

/* A spot that looks at pixels: a box of width px, made soft by ink with a standard deviation, both
 * in pixels. */
typedef struct lf_print_spot {
    double box_px, ink_px;
} lf_print_spot;

/* Spots around the places middle[n_places] (rising) of a raster with n_dots pixels; pixel j covers
 * [j, j + 1]. With n_extra > 0 a spot is the sum of 2 n_extra + 1 spots, extra_px apart, with the
 * weights extra. LF_E_NOMEM. LF_E_ARG: a spot is wider than LF_CROSSTALK_WIDTH or the raster. */
typedef struct lf_crosstalk_look {
    const double *middle;
    int n_places, n_dots;
    lf_print_spot spot;
    const double *extra;
    int n_extra;
    double extra_px;
} lf_crosstalk_look;
LF_NODISCARD lf_status lf_crosstalk_of_look(const lf_crosstalk_look *look, lf_crosstalk *out);
/* Dots that such a spot covers at most. */
double lf_crosstalk_width(const lf_crosstalk_look *look);

/* n places that see n dots: place t sees dot t + d with kernel[reach + d], without what is beyond
 * the ends. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_crosstalk_of_kernel(const double *kernel, int n, int reach,
                                              lf_crosstalk *out);
void lf_crosstalk_finish(lf_crosstalk *crosstalk);

/* The inverse within the gamut. Used by one thread. */
typedef struct lf_unmix {
    const lf_crosstalk *crosstalk;
    double *factor; /* [n_dots][width]: L and 1 / D of L D L^T */
    double *norm;   /* [n_dots] squared length of a dot's column */
    /* [n_places][LF_LANES]: what an eye sees less what it should see, and the same for the print as
     * it was */
    double *error, *plain;
    double *step, *dots;    /* [n_dots][LF_LANES] scratch */
    unsigned char *clamped; /* [n_dots] bit of a lane: the exact solution is outside the gamut */
    unsigned char *near;    /* [n_dots] 1: near such a dot */
} lf_unmix;

/* Borrows the matrix. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_unmix_init(lf_unmix *unmix, const lf_crosstalk *crosstalk);
void lf_unmix_finish(lf_unmix *unmix);
/* wanted[n_places][LF_LANES]: what an eye should see. print[n_dots][LF_LANES], 0..1: in, a print
 * that is nearly right; out, the nearest print with which an eye sees what it should. Exact where
 * the gamut allows it, otherwise near to the least squares within the gamut, and in no lane worse
 * than the print that came in. Sets error, plain and clamped. */
void lf_unmix_light(lf_unmix *unmix, const double *wanted, double *print);

#endif
