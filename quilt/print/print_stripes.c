#include <math.h>

#include "quilt/print/print.h"

/* A border this close to a pixel's edge or centre, in stripes, counts as on it. Rounding of doubles
 * stays below 1e-10 at 10^5 stripes, and 1e-9 stripe is less than a picometre. */
#define SNAP 1e-9

static double snapped(double s)
{
    const double whole = round(s);
    return fabs(s - whole) < SNAP ? whole : s;
}

/* The stripe coordinate of a position in pixels from the raster's left edge. Whole numbers are
 * borders; stripe 0 is the leftmost of lens 0's cell. */
static double stripe_coordinate(const lf_print *print, const lf_print_shape *shape, double pixel)
{
    const int raster_across = print->horizontal ? shape->raster_height : shape->raster_width;
    const double shift_mm = print->horizontal ? shape->shift_down_mm : shape->shift_right_mm;
    const double dpi = lf_print_dpi_across(print);
    const double pixels_per_lens = dpi / print->lpi;
    const double phase_px = (print->phase_mm + shift_mm) * dpi / 25.4;
    const double x = pixel - 0.5 * raster_across - phase_px;
    return snapped(print->n_views * (x / pixels_per_lens + 0.5));
}

static void put_stripe(const lf_print *print, const lf_print_shape *shape, double stripe,
                       double weight, int slot, lf_stripe_mix *out)
{
    const double cell = floor(stripe / print->n_views);
    const int m = (int)(stripe - cell * print->n_views);
    const int lens = (int)cell - shape->first_lens;
    /* A snapped edge can select the cell next to the raster, with weight 0. */
    out->lens[slot] = lens < 0 ? 0 : lens >= shape->n_lenses ? shape->n_lenses - 1 : lens;
    out->view[slot] = print->reverse ? m : print->n_views - 1 - m;
    out->weight[slot] = (float)weight;
}

void lf_stripe_mix_at(const lf_print *print, const lf_print_shape *shape, int pixel,
                      lf_stripe_mix *out)
{
    if (print->stripes == LF_STRIPES_NEAREST) {
        const double stripe = floor(stripe_coordinate(print, shape, pixel + 0.5));
        for (int slot = 0; slot < 3; slot++)
            put_stripe(print, shape, stripe, slot == 0 ? 1.0 : 0.0, slot, out);
        return;
    }
    const double left = stripe_coordinate(print, shape, pixel);
    const double right = stripe_coordinate(print, shape, pixel + 1.0);
    const double first = floor(left);

    for (int slot = 0; slot < 3; slot++) {
        const double stripe = first + slot;
        const double covered = fmin(right, stripe + 1.0) - fmax(left, stripe);
        put_stripe(print, shape, covered > 0.0 ? stripe : first,
                   fmax(covered, 0.0) / (right - left), slot, out);
    }
}
