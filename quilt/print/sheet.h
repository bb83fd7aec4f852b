/* Private to quilt/print: the page of a print. It holds rows of copies, each of them a whole print
 * with its bleed, and labels below them. Marks (marks.h) are around and between them.
 *
 * ONE lens sheet lies over all copies. Its lenses are one mechanical pitch apart, and lens 0 is on
 * the middle of the page, plus the phase. Copies are cut apart before anyone looks at them, and
 * each is then seen from its own middle. Therefore every copy is interlaced at the visual pitch
 * around its own middle, and that middle is a whole number of mechanical pitches from the middle of
 * the page. Steps from copy to copy are whole lenses, rounded up. Along straight lenses they are
 * whole pixels, rounded up. On a micro lens sheet they are whole lenses both ways. Slanted lenses
 * shift each row by less than a lens.
 *
 * The middle of the page is the middle of the rows of copies, to half a lens. Millimetres from it:
 * right and down, before mirroring. */
#ifndef LF_QUILT_SHEET_H
#define LF_QUILT_SHEET_H

#include "quilt/prints.h"

typedef struct lf_copy {
    int left, top;            /* first pixel of the picture with bleed on the page */
    double right_mm, down_mm; /* the copy's middle */
    int lens;                 /* the lens there, counted across the lenses */
    /* the copy's middle from the middle of its pixels; within half a pixel */
    double shift_right_mm, shift_down_mm;
} lf_copy;

typedef struct lf_sheet {
    int width, height; /* of the page, pixels */
    int n_columns, n_rows;
    double step_right_mm, step_down_mm;
    double mechanical_mm;          /* pitch of the lens sheet … */
    bool mechanical_known;         /* … or the visual one, if its optics are unknown */
    double half_right, half_down;  /* middle of the page to the last bleed or label, mm */
    double label_mm;               /* height of a capital letter of the label; 0: no label */
    char label[LF_LABEL_MOST + 1]; /* in the characters of the font */
    lf_copy *copies;               /* [n_rows][n_columns] */
} lf_sheet;

/* Free space between a copy's bleed and its label; and the label's left end, from the trim edge. */
#define LF_LABEL_GAP 1.0
#define LF_LABEL_INDENT 1.0

/* Lays out the page of a print whose ranges were checked. LF_E_ARG: it does not fit on its paper,
 * is too large, or has no room for its label. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_sheet_init(lf_sheet *sheet, const lf_print *print,
                                     const lf_print_shape *shape, lf_error *err);
void lf_sheet_finish(lf_sheet *sheet);

/* Height of a label with the space above it; 0 without one. */
double lf_sheet_band(const lf_sheet *sheet);
/* True if the point, from the top left corner of the label, mm, is ink. */
bool lf_sheet_label_ink(const lf_sheet *sheet, double x, double y);

#endif
