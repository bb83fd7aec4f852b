/* Private to quilt/print: register and alignment marks around a print.
 *
 * They are in a margin of LF_MARKS_MM on every side, outside the picture and its bleed. The margin
 * is a whole number of pixels, so that the middle of the print stays the middle of the file.
 * Distances in mm from the edge of the bleed.
 *
 * - At the two sides where lenses end, 1 to 5: alignment strip. One dark line per lens, a quarter
 *   of a pitch wide, centred under the lens, with the pitch and phase of the picture. It reaches
 *   from trim edge to trim edge, less 1 at each.
 * - At the same sides, 5.5 to 7.5: a tick on the axis of lens 0.
 * - At the other two sides: a register mark in the middle of the side, 4 outside the bleed. It is a
 *   cross 5 wide with a ring of radius 1.5.
 * - At every corner, 1 to 6: lines on the trim edges.
 *
 * Slanted lenses: strips and ticks follow the lenses, with the phase that the map gives them.
 *
 * Lines are 0.2 wide. */
#ifndef LF_QUILT_MARKS_H
#define LF_QUILT_MARKS_H

#include "quilt/lens.h"

#define LF_MARKS_MM 8.0

typedef struct lf_marks {
    int width, height, margin_px, margin_down_px; /* size and margin of the file */
    bool horizontal;
    double right, down;  /* size of a pixel in mm */
    double pitch, phase; /* mm, along the edge */
    bool is_straight;    /* all lenses are alike along the print */
    lf_lens lens;
    double trim_across, trim_along;   /* from the middle to the trim edge, mm */
    double bleed_across, bleed_along; /* from the middle to the edge of the bleed */
} lf_marks;

lf_marks lf_marks_of(const lf_print *print, const lf_print_shape *shape);
/* Draws row y of the file, [width][3] linear light; leaves the picture's pixels unchanged. */
void lf_marks_row(const lf_marks *marks, int y, float *row);

#endif
