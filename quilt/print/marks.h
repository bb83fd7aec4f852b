/* Private to quilt/print: register and alignment marks around prints, and their labels.
 *
 * Marks of the sheet are in a margin of LF_MARKS_MM on every side, outside all pictures, their
 * bleeds and labels: for the lens sheet, which lies over the whole page. The margin is a whole
 * number of pixels, so that the middle of the page stays the middle of the file. Distances in mm
 * from the edge of the outermost bleeds and labels.
 *
 * - At the two sides where lenses end, 1 to 5: alignment strip. One dark line per lens, a quarter
 *   of a pitch wide, centred under the lens as the eye in front of the middle of the page sees it.
 *   It reaches from the first trim edge to the last, less 1 at each.
 * - At the same sides, 5.5 to 7.5: a tick on the axis of lens 0.
 * - At the other two sides: a register mark in the middle of the side, 4 outside. It is a cross 5
 *   wide with a ring of radius 1.5.
 *
 * Marks of a copy: at every corner, 1 to 6 outside its bleed, lines on the trim edges. They are
 * never on a picture, and end 1 before the bleed of the next copy.
 *
 * Lines are 0.2 wide. A label is below the bleed of its copy, between its trim edges. */
#ifndef LF_QUILT_MARKS_H
#define LF_QUILT_MARKS_H

#include "quilt/lens.h"
#include "quilt/print/sheet.h"

#define LF_MARKS_MM 8.0

typedef struct lf_marks {
    const lf_print *print;
    const lf_sheet *sheet;
    bool horizontal;
    double right, down;             /* size of a pixel in mm */
    double pitch, phase;            /* mm */
    bool straight;                  /* alignment lines are parallel to the sides, at one pitch */
    lf_lens lens;                   /* otherwise */
    double trim_across;             /* from the middle to the last trim edge, mm */
    double half_across, half_along; /* from the middle to the edge of the last bleed or label */
    double *ink;                    /* of a row, [sheet->width] */
} lf_marks;

/* Borrows both. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_marks_init(lf_marks *marks, const lf_print *print, const lf_sheet *sheet);
void lf_marks_finish(lf_marks *marks);
/* Draws row y of the page, [width][3] linear light: white paper, marks and labels. The pictures are
 * drawn over it. */
void lf_marks_row(lf_marks *marks, int y, float *row);

#endif
