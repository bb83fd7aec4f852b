/* Private to quilt/print: the page of a print. It holds rows of copies, each of them a whole print
 * with its bleed, and what is around them: marks, labels and white paper.
 *
 * ONE lens sheet lies over all copies. Its lenses are one mechanical pitch apart, and lens 0 is on
 * the middle of the page, plus the phase. Copies are cut apart before anyone looks at them, and
 * each is then seen from its own middle. Therefore every copy is interlaced at the visual pitch
 * around its own middle, and that middle is a whole number of mechanical pitches from the middle of
 * the page. Steps from copy to copy are whole lenses, rounded up. Along the lenses they are whole
 * pixels, rounded up.
 *
 * The middle of the page is the middle of the rows of copies, to half a step of one lens (one
 * pixel). Millimetres from it: right and down, before mirroring. */
#ifndef LF_QUILT_SHEET_H
#define LF_QUILT_SHEET_H

#include "quilt/prints.h"

typedef struct lf_copy {
    int left, top;          /* first pixel of the picture with bleed on the page */
    double right_mm, down_mm; /* the copy's middle */
    int lens;               /* number of the lens at its middle */
    /* the copy's middle from the middle of its pixels, across the lenses; within half a pixel */
    double shift_mm;
} lf_copy;

typedef struct lf_sheet {
    int width, height; /* of the page, pixels */
    int n_columns, n_rows;
    int step_lenses;               /* from copy to copy, across the lenses */
    double step_right, step_down;  /* the same, mm */
    double mechanical_mm;          /* pitch of the lens sheet … */
    bool mechanical_known;         /* … or the visual one, if its optics are unknown */
    double half_width, half_height; /* middle of the page to the edge of bleeds and labels, mm */
    double label_mm;               /* height of a capital letter of the label; 0: no label */
    char label[LF_LABEL_MOST + 1]; /* in the characters of the font */
    lf_copy *copies;               /* [n_rows][n_columns] */
} lf_sheet;

/* Free space above a label, mm. */
#define LF_LABEL_GAP 1.0

/* Lays out the page of a print whose ranges were checked. LF_E_ARG: it does not fit on its paper,
 * is too large, or has no room for its label. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_sheet_init(lf_sheet *sheet, const lf_print *print,
                                     const lf_print_shape *shape, lf_error *err);
void lf_sheet_finish(lf_sheet *sheet);

/* True if the point, from the top left corner of the label, mm, is ink. */
bool lf_sheet_label_ink(const lf_sheet *sheet, double x, double y);

#endif
