/* Private to quilt/print: which dots of a print an eye sees (docs/developer/print-compensation.md).
 *
 * Dots are the pixels of the raster along the axis across the lenses, or stripes. The eye looks at
 * places along the same axis, usually the middles of the stripes. What it sees at place t is the
 * sum over d < width of share[t][d] * light of dot first[t] + d.
 */
#ifndef LF_QUILT_CROSSTALK_H
#define LF_QUILT_CROSSTALK_H

#include <stddef.h>

#include "base/status.h"

/* The most dots that an eye may see at one place. */
#define LF_CROSSTALK_WIDTH 64

typedef struct lf_crosstalk {
    int n_places, n_dots, width;
    int *first;               /* [n_places] rising; the whole row is within 0..n_dots-1 */
    double *share;            /* [n_places][width], sum 1; all 0 for a place outside the raster */
    int first_seen, end_seen; /* the places whose rows are not 0 */
    int *from, *to;           /* [n_dots] the places that may see a dot: from..to-1 */
} lf_crosstalk;

static inline double *lf_crosstalk_row(const lf_crosstalk *crosstalk, int place)
{
    return crosstalk->share + (size_t)place * (size_t)crosstalk->width;
}

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

#endif
