/* What an eye sees of a print through its lens sheet, from the print's file.
 *
 * eye -> lens (Snell's law) -> spot on the print -> mean linear light of the spot. The eye is at
 * (x, y) in front of the sheet, at a distance; x to the right, y down, millimetres from the middle
 * of the print (of one copy, on a page of several). Paper beyond the trim size is cut off. The
 * sheet is the real one, by its mechanical pitch: a print for another pitch, order or phase shows
 * what it would show. Functions are thread safe on different files. */
#ifndef LF_QUILT_SIMULATE_H
#define LF_QUILT_SIMULATE_H

#include "base/image.h"
#include "base/image_metadata.h"
#include "base/thread.h"
#include "quilt/prints.h"
#include "quilt/proof/print_file.h"

/* Distance of an eye, and viewing angle of a sheet in degrees, where nothing is known. */
#define LF_PROOF_DISTANCE 400.0
#define LF_PROOF_ANGLE 50.0
#define LF_PROOF_MAX_SIDE 8192

typedef struct lf_eye {
    double x_mm, y_mm, distance_mm;
} lf_eye;

/* Several spots of a lens, by a measured crosstalk. n 0: one, where the optics say. */
typedef struct lf_proof_spots {
    int n;
    double right_mm[2 * LF_PRINT_CROSSTALK + 1]; /* across the lenses, from there */
    double share[2 * LF_PRINT_CROSSTALK + 1];    /* sum 1 */
} lf_proof_spots;

/* A sheet and how the print lies under it. */
typedef struct lf_proof_sheet {
    double pitch_mm; /* mechanical, from lens to lens */
    /* unit vector across the lenses, in the print's x and y; for grids, of the rows */
    double right, down;
    bool horizontal;
    lf_lens_grid grid;
    double offset, offset_down; /* of lens 0 from the middle, in lenses (in rows) */
    double thickness_mm, index;
    double distance_mm; /* that the print is made for */
    double spot_mm;     /* width of the spot across the lenses (a box) … */
    double ink_mm;      /* … that a Gaussian of this standard deviation blurs */
    double dot_gain;    /* lf_print_blur's, before all blur */
    lf_proof_spots spots;
    double width_mm, height_mm; /* what is seen: the trim size, around its middle … */
    /* … which lies here, from the middle of the raster seen from the front. Eye and lenses count
     * from there. */
    double middle_right_mm, middle_down_mm;
    bool mirror;        /* the print is on the back of the sheet: its raster is mirrored */
    double pixel_mm[2]; /* of the raster, if the file does not say it */
    int n_views;        /* across the lenses */
} lf_proof_sheet;

/* The sheet of a print: that whose visual pitch at the print's distance is print->lpi. lpi, dpi,
 * width_mm and height_mm must be set. notes (may be NULL) get a line for each number that is
 * assumed: thickness, distance. */
void lf_proof_sheet_of(const lf_print *print, lf_proof_sheet *out, lf_image_notes *notes);
/* Pitch of the sheet's lines on the print for an eye at this distance. */
double lf_proof_visual_mm(const lf_proof_sheet *sheet, double distance_mm);
/* Where an eye at this distance must be, across the lenses from the middle, so that the middle lens
 * shows it this share of its cell: -1/2 and 1/2 are where the views jump. By Snell's law. */
double lf_proof_eye_at(const lf_proof_sheet *sheet, double distance_mm, double share);
/* From the middle of one view to that of the next, in the middle of the range of eye positions at
 * this distance; views at its ends are wider. And all of the range, until views repeat. */
double lf_proof_view_step(const lf_proof_sheet *sheet, double distance_mm);
double lf_proof_view_range(const lf_proof_sheet *sheet, double distance_mm);

/* Moves the sheet to the first copy of a page, if a print's manifest (NULL: none) tells of a page.
 * The lenses of the page's one sheet count from the page's middle. *out_columns, *out_rows: columns
 * and rows of copies, 1 without a page. LF_E_FORMAT: no place that a copy can have. */
struct json_t;
LF_NODISCARD lf_status lf_proof_take_copy(const struct json_t *manifest, const char *where,
                                          lf_proof_sheet *sheet, int *out_columns, int *out_rows,
                                          lf_error *err);

/* Fills the members of a print that its manifest has (lf_print_file_manifest; NULL: none), and
 * otherwise raster and size from the file's tags. Texts are borrowed from the manifest.
 * LF_E_FORMAT: the manifest is of another file or a chart, or damaged. */
LF_NODISCARD lf_status lf_proof_print_of(const lf_print_file *file, const struct json_t *manifest,
                                         const char *where, lf_print *out, lf_error *err);

/* The light of every lens, as one eye sees it. */
typedef struct lf_proof_light {
    int first, n; /* lenses across: numbers first … first + n - 1 */
    /* Linear sheets: parts along the lenses, of along_mm each, from along0_mm from the middle.
     * Grids: rows of lenses, from number first_row. */
    int n_along, first_row;
    double along0_mm, along_mm;
    float *light; /* [n_along][n][3], linear; owned by this struct */
} lf_proof_light;

/* Reads those rows of the file that the eye sees. n_along: wanted parts along the lenses of the
 * seen rectangle. LF_E_CANCELLED (cancel may be NULL); LF_E_NOMEM; errors of lf_print_file_raw;
 * LF_E_ARG: an eye that is too close, or too many parts. */
LF_NODISCARD lf_status lf_proof_see(lf_print_file *file, const lf_proof_sheet *sheet,
                                    const lf_eye *eye, int n_along, const lf_cancel *cancel,
                                    lf_proof_light *out, lf_error *err);
void lf_proof_light_finish(lf_proof_light *light); /* accepts zeroed ones */

/* The size of a picture of the seen rectangle with square pixels; width 0: one pixel per lens, of
 * horizontal lenses in its height, at most LF_PROOF_MAX_SIDE. LF_E_ARG: too many pixels. */
LF_NODISCARD lf_status lf_proof_size(const lf_proof_sheet *sheet, int width, int *out_width,
                                     int *out_height, lf_error *err);
/* The picture that an eye sees, linear, of such a size; errors of lf_proof_see. Release *out by
 * lf_image32_finish. */
LF_NODISCARD lf_status lf_proof_picture(lf_print_file *file, const lf_proof_sheet *sheet,
                                        const lf_eye *eye, int width, int height,
                                        const lf_cancel *cancel, lf_image32 *out, lf_error *err);

#endif
