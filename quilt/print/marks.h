/* Private to quilt/print: register and alignment marks around a print (lenticular.md section 1.6).
 *
 * They stand in a margin of LF_MARKS_MM on every side, outside of the picture and its bleed; the
 * margin is a whole number of pixels, so that the middle of the print stays the middle of the file.
 * From the edge of the bleed, in mm, at the two sides that the lenses run to:
 *   1 to 5      alignment strip: one dark line a lens, a quarter of a pitch wide, centred under the
 *               lens, at the pitch and phase of the picture, from trim edge to trim edge less 1;
 *   5.5 to 7.5  tick on the axis of lens 0;
 * at the other two, a register mark: a cross 5 wide with a ring of radius 1.5 about it, 4 outside
 * the bleed, in the middle of the side; at every corner, 1 to 6 outside, lines on the trim edges.
 * Lines are 0.2 wide. */
#ifndef LF_QUILT_MARKS_H
#define LF_QUILT_MARKS_H

#include "quilt/quilt.h"

#define LF_MARKS_MM 8.0

typedef struct lf_marks {
    int width, height, margin_px, margin_down_px; /* of the file */
    bool horizontal;
    double right, down;               /* mm of a pixel */
    double pitch, phase;              /* mm */
    double trim_across, trim_along;   /* from the middle to the trim edge, mm */
    double bleed_across, bleed_along; /* from the middle to the edge of the bleed */
} lf_marks;

lf_marks lf_marks_of(const lf_print *print, const lf_print_shape *shape);
/* Row y of the file, [width][3] linear light; what lies within the picture is left alone. */
void lf_marks_row(const lf_marks *marks, int y, float *row);

#endif
