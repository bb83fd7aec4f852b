#include "quilt/proof/study.h"

#include <math.h>

#define MM_PER_INCH 25.4

/* ---------------------------------------------------------------------------------- own view -- */

enum { ALIGNMENTS = 128, POINTS = 128 };

/* Share of a pixel from `left` that holds the stripe [-half, half]. */
static double share_of_pixel(double left, double pixel, double middle, double half,
                             lf_stripes stripes)
{
    const double low = left - middle, high = low + pixel;
    if (stripes == LF_STRIPES_NEAREST)
        return 0.5 * (low + high) >= -half && 0.5 * (low + high) < half ? 1.0 : 0.0;
    return fmax(0.0, fmin(high, half) - fmax(low, -half)) / pixel;
}

/* Light of the stripe around `middle`, seen in the spot around 0, with a pixel edge at `edge`. */
static double seen_share(const lf_proof_sheet *sheet, double pixel, double edge, double middle,
                         double half, lf_stripes stripes)
{
    const double reach = 0.5 * sheet->spot_mm + 4.0 * sheet->ink_mm;
    double sum = 0.0, weights = 0.0;
    for (int i = 0; i < POINTS; i++) {
        const double x = reach * (2.0 * (i + 0.5) / POINTS - 1.0);
        const double w = sheet->ink_mm > 0.0
                             ? erf((x + 0.5 * sheet->spot_mm) / (sheet->ink_mm * sqrt(2.0))) -
                                   erf((x - 0.5 * sheet->spot_mm) / (sheet->ink_mm * sqrt(2.0)))
                             : 1.0;
        const double left = edge + pixel * floor((x - edge) / pixel);
        sum += w * share_of_pixel(left, pixel, middle, half, stripes);
        weights += w;
    }
    return sum / weights;
}

/* The same in all spots of a lens. */
static double seen_in_all(const lf_proof_sheet *sheet, double pixel, double edge, double middle,
                          double half, lf_stripes stripes)
{
    const lf_proof_spots *spots = &sheet->spots;
    double sum = spots->n > 0 ? 0.0 : seen_share(sheet, pixel, edge, middle, half, stripes);
    for (int k = 0; k < spots->n; k++)
        if (spots->share[k] > 0.0)
            sum += spots->share[k] * seen_share(sheet, pixel, edge - spots->right_mm[k],
                                                middle - spots->right_mm[k], half, stripes);
    return sum;
}

lf_own_view lf_proof_own_view(const lf_print *print, const lf_proof_sheet *sheet)
{
    const double dpi = print->horizontal && print->dpi_down > 0.0 ? print->dpi_down : print->dpi;
    const double pixel = MM_PER_INCH / dpi, stripe = MM_PER_INCH / print->lpi / sheet->n_views;
    lf_own_view own = {.worst = 1.0};
    for (int i = 0; i < ALIGNMENTS; i++) {
        const double edge = pixel * i / ALIGNMENTS;
        const double share = seen_in_all(sheet, pixel, edge, 0.0, 0.5 * stripe, print->stripes);
        own.mean += share / ALIGNMENTS;
        own.worst = fmin(own.worst, share);
        for (int side = -1; side <= 1; side += 2)
            own.beside +=
                seen_in_all(sheet, pixel, edge, side * stripe, 0.5 * stripe, print->stripes) /
                ALIGNMENTS;
    }
    return own;
}

double lf_proof_drift(const lf_print *print, const lf_proof_sheet *sheet, double distance_mm)
{
    const double seen = lf_proof_visual_mm(sheet, distance_mm);
    const double across = sheet->horizontal ? sheet->height_mm : sheet->width_mm;
    return across * fabs(1.0 / seen - print->lpi / MM_PER_INCH);
}
