/* Private to quilt/print: the dots to print so that an eye sees a given light, the inverse of
 * crosstalk.h within the gamut. Used by one thread.
 *
 * Values have LF_UNMIX_LANES independent lanes: the channels of a row, or parts of a line. */
#ifndef LF_QUILT_UNMIX_H
#define LF_QUILT_UNMIX_H

#include <stdbool.h>

#include "quilt/print/crosstalk.h"

#define LF_UNMIX_LANES 4

typedef struct lf_unmix {
    bool shares; /* factor, column and norm are another's */
    const lf_crosstalk *crosstalk;
    double *factor; /* [n_dots][width]: L and 1 / D of L D L^T */
    double *column; /* [n_dots][height] the dot's shares, from the first place that may see it */
    int height;
    double *norm; /* [n_dots] squared length of a dot's column */
    /* [n_places][LF_UNMIX_LANES]: what an eye sees less what it should see, and the same for the
     * print as it was */
    double *error, *plain;
    double *step, *dots;    /* [n_dots][LF_UNMIX_LANES] scratch */
    unsigned char *clamped; /* [n_dots] bit of a lane: the exact solution is outside the gamut */
    unsigned char *near;    /* [n_dots] 1: near such a dot */
} lf_unmix;

/* Borrows the matrix. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_unmix_init(lf_unmix *unmix, const lf_crosstalk *crosstalk);
/* The same for another thread; borrows `whole`. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_unmix_share(lf_unmix *unmix, const lf_unmix *whole);
/* Lets one of another thread solve for another matrix of the same size. */
void lf_unmix_turn(lf_unmix *share, const lf_unmix *whole);
void lf_unmix_finish(lf_unmix *unmix);

/* Dots begin..end-1, and the places that see no other dots. */
typedef struct lf_unmix_part {
    int begin, end, first_place, end_place;
} lf_unmix_part;
lf_unmix_part lf_unmix_part_of(const lf_unmix *unmix, int begin, int end);
/* wanted[n_places][LF_UNMIX_LANES]: what an eye should see. print[n_dots][LF_UNMIX_LANES], 0..1:
 * in, a print that is nearly right; out, the nearest print with which an eye sees what it should.
 * Exact where the gamut allows it, otherwise near to the least squares within the gamut, and in no
 * lane worse than the print that came in. Reads and sets only values of the part, in these arrays
 * and in error, plain and clamped. */
void lf_unmix_light(lf_unmix *unmix, const lf_unmix_part *part, const double *wanted,
                    double *print);

#endif
