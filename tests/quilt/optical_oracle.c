#include "tests/quilt/optical_oracle.h"

#include <math.h>
#include <stdlib.h>

#define MM_PER_INCH 25.4

lf_sheet lf_sheet_for(double visual_lpi, double distance_mm, double thickness_mm, double index,
                      double middle_mm)
{
    /* To first order the focal lines are the lenses seen from the eye, enlarged by this about the
     * foot of the eye. */
    const double enlarged = 1.0 + thickness_mm / (index * distance_mm);
    return (lf_sheet){MM_PER_INCH / visual_lpi / enlarged, thickness_mm, index,
                      middle_mm / enlarged};
}

lf_row_light lf_row_light_of(const double *light, int n, double pixel_mm)
{
    lf_row_light row = {n, pixel_mm, malloc(((size_t)n + 1) * sizeof *row.sum)};
    if (!row.sum)
        abort();
    row.sum[0] = 0.0;
    for (int j = 0; j < n; j++)
        row.sum[j + 1] = row.sum[j] + light[j];
    return row;
}

void lf_row_light_finish(lf_row_light *row)
{
    free(row->sum);
    row->sum = NULL;
}

/* Light between the row's left edge and a point `at` pixels to the right of it. */
static double light_before(const lf_row_light *row, double at)
{
    if (at <= 0.0)
        return at * row->sum[1];
    if (at >= row->n)
        return row->sum[row->n] + (at - row->n) * (row->sum[row->n] - row->sum[row->n - 1]);
    const int j = (int)at;
    return row->sum[j] + (at - j) * (row->sum[j + 1] - row->sum[j]);
}

double lf_focal_point(const lf_sheet *sheet, int k, double eye_mm, double distance_mm, bool exact)
{
    const double lens = sheet->x0_mm + k * sheet->pitch_mm;
    const double slope = (eye_mm - lens) / distance_mm;
    if (!exact)
        return lens - sheet->thickness_mm / sheet->index * slope;
    return lens - sheet->thickness_mm * tan(asin(sin(atan(slope)) / sheet->index));
}

double lf_seen_through(const lf_sheet *sheet, const lf_row_light *row, int k, double eye_mm,
                       double distance_mm, double spot_mm, bool exact)
{
    const double at =
        lf_focal_point(sheet, k, eye_mm, distance_mm, exact) / row->pixel_mm + 0.5 * row->n;
    const double half = 0.5 * spot_mm / row->pixel_mm;
    return (light_before(row, at + half) - light_before(row, at - half)) / (2.0 * half);
}

void lf_lenses_inside(const lf_sheet *sheet, const lf_row_light *row, int *out_first, int *out_last)
{
    const double half = 0.5 * row->n * row->pixel_mm;
    *out_first = (int)ceil((-half - sheet->x0_mm) / sheet->pitch_mm) + 2;
    *out_last = (int)floor((half - sheet->x0_mm) / sheet->pitch_mm) - 2;
}
