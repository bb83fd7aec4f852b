/* What an eye sees through a lenticular sheet, from optics alone (lenticular.md section 3):
 * refraction at each lens, a spot on the print behind it, and the light that the print's pixels put
 * into that spot. Knows nothing of views, stripes or how the print was made, and shares no code
 * with it. Millimetres; x to the right from the middle of the print. */
#ifndef LF_TESTS_QUILT_OPTICAL_ORACLE_H
#define LF_TESTS_QUILT_OPTICAL_ORACLE_H

#include <stdbool.h>

/* A sheet and where it lies. */
typedef struct lf_sheet {
    double pitch_mm;     /* mechanical: from lens to lens */
    double thickness_mm; /* from the lens to the print */
    double index;        /* of refraction */
    double x0_mm;        /* middle of lens 0 */
} lf_sheet;

/* The sheet whose focal lines, for an eye at distance_mm, lie visual_lpi to the inch and one of
 * them at middle_mm for an eye straight in front. */
lf_sheet lf_sheet_for(double visual_lpi, double distance_mm, double thickness_mm, double index,
                      double middle_mm);

/* One row of the print: n pixels, side by side, the row's middle at x = 0. */
typedef struct lf_row_light {
    int n;
    double pixel_mm;
    double *sum; /* [n + 1] light of the pixels before */
} lf_row_light;

/* light[n]: linear. Release by lf_row_light_finish. */
lf_row_light lf_row_light_of(const double *light, int n, double pixel_mm);
void lf_row_light_finish(lf_row_light *row);

/* Where the eye at (eye_mm, distance_mm) looks through lens k: by Snell's law, or to first order.
 */
double lf_focal_point(const lf_sheet *sheet, int k, double eye_mm, double distance_mm, bool exact);

/* Mean light of the spot of width spot_mm about that point; what lies outside the print counts as
 * its edge. */
double lf_seen_through(const lf_sheet *sheet, const lf_row_light *row, int k, double eye_mm,
                       double distance_mm, double spot_mm, bool exact);

/* The first and last lens whose spots, for any eye within reach, lie inside the print; the
 * outermost two are left out. */
void lf_lenses_inside(const lf_sheet *sheet, const lf_row_light *row, int *out_first,
                      int *out_last);

#endif
