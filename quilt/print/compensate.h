/* Private to quilt/print: what sheet and printer do wrong, taken back before printing
 * (docs/developer/print-compensation.md).
 *
 * Crosstalk: the pixels of a row (column, for horizontal lenses) are chosen so that an eye at each
 * view sees this view alone. Dot gain: each pixel is made lighter, so that the printer makes it
 * what it should be. Lanes and rows are independent, and the result depends only on the print and
 * its views. An object
 * is used by one thread. */
#ifndef LF_QUILT_COMPENSATE_H
#define LF_QUILT_COMPENSATE_H

#include "quilt/print/print.h"

typedef struct lf_compensate lf_compensate;

/* For lf_print_check. LF_E_ARG: nothing is known of the blur, values out of range, lenses that
 * lean, micro sheets. */
LF_NODISCARD lf_status lf_compensate_check(const lf_print *print, lf_error *err);

/* What all rows share, of a print that has it on. References are borrowed. *out is NULL if
 * compensation is off. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_compensate_create(const lf_print *print, const lf_print_shape *shape,
                                            lf_compensate **out);
/* One for a thread that makes rows; it borrows `whole`. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_compensate_share(lf_compensate *whole, const lf_print_source *source,
                                           lf_compensate **out);
void lf_compensate_destroy(lf_compensate *compensate); /* accepts NULL */

/* Vertical lenses: replaces the interlaced row y [raster_width][3] of these samples
 * [n_views][n_lenses][3]. */
void lf_compensate_across(lf_compensate *c, int y, const float *samples, float *row);
/* Horizontal lenses: makes row y [raster_width][3]. Rising rows are fastest. */
void lf_compensate_down(lf_compensate *c, int y, float *row);

/* Light that a printer with this dot gain turns into the given light, both 0..1. */
double lf_dot_gain_undone(double light, double gain);

/* What is left after all rows, each made once. */
lf_print_left lf_compensate_left(const lf_compensate *c);

#endif
