/* What a print will do to its viewers, in numbers: own view, drift of the views over the print,
 * parallax, and what the edge of the print cuts. Thread safe on different files. */
#ifndef LF_QUILT_PROOF_STUDY_H
#define LF_QUILT_PROOF_STUDY_H

#include "quilt/proof/simulate.h"

/* Side of a block, in lenses; the largest shift that is searched, in lenses. */
#define LF_PROOF_BLOCK 16
#define LF_PROOF_CELL 4 /* side of the parts of a block that are marked */
#define LF_PROOF_SEARCH 10

/* Shares of the light that an eye in the middle of a view gets through a lens, over all ways in
 * which stripes fall on pixels. Ideal lenses; by the sheet's spot and ink. */
typedef struct lf_own_view {
    double mean, worst; /* of its own view */
    double beside;      /* mean, of the two views beside it together */
} lf_own_view;
/* print: lpi, dpi, n_views, stripes and orientation of what was printed. */
lf_own_view lf_proof_own_view(const lf_print *print, const lf_proof_sheet *sheet);

/* By how many times all views the print runs off the sheet, from edge to edge, seen from this
 * distance: 0 if the pitch is right. */
double lf_proof_drift(const lf_print *print, const lf_proof_sheet *sheet, double distance_mm);

/* The shift of what is seen from view to view, by matching blocks of simulated views around the
 * middle. */
typedef struct lf_proof_depth {
    int width, height; /* of the views, in pixels of one lens */
    int columns, rows; /* of blocks */
    float *shift;      /* [rows][columns] lenses, along with the eye: > 0 behind the print, < 0 in
                        * front of it; NAN: nothing to match. Owned by this struct */
    /* [rows * 4][columns * 4] parts of blocks that shift by more than 1 lens, and are seen to: they
     * would differ without the shift. Owned by this struct */
    uint8_t *doubled;
    double measured; /* share of the blocks with structure that could be matched */
    double most;     /* largest |shift| */
    double over;     /* share of the matched blocks that shift by more than 1 lens */
    bool cut[4];     /* something in front of the print touches left, right, top, bottom */
} lf_proof_depth;
/* Under this share of matched blocks, the views are of different images: a flip. */
#define LF_PROOF_FLIP 0.5

/* Errors of lf_proof_picture. Release by lf_proof_depth_finish. */
LF_NODISCARD lf_status lf_proof_depth_of(lf_print_file *file, const lf_proof_sheet *sheet,
                                         double distance_mm, const lf_cancel *cancel,
                                         lf_proof_depth *out, lf_error *err);
void lf_proof_depth_finish(lf_proof_depth *depth); /* accepts zeroed ones */
/* Marks a picture of the seen rectangle: red hatching where parallax is over 1 lens, a blue edge
 * where the print cuts what is in front of it. */
void lf_proof_depth_mark(const lf_proof_depth *depth, lf_image32 *image);

#endif
