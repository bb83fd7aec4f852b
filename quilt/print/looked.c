#include "quilt/print/looked.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/lens.h"

/* Bands differ by so many pixels, unless there would be more than the most. */
#define APART_PX 0.02
#define MOST_BANDS 40
/* A border this close to a pixel's edge or centre, in stripes, counts as on it (print_stripes.c).
 */
#define SNAP 1e-9

/* ------------------------------------------------------------------------------------ places -- */

static double across_mm(const lf_looked *k, double pixel)
{
    const lf_print *print = k->print;
    const double shift = print->horizontal ? k->shape->shift_down_mm : k->shape->shift_right_mm;
    return (pixel - 0.5 * k->n_pixels) * 25.4 / lf_print_dpi_across(print) - shift;
}

static double along_mm(const lf_looked *k, double pixel)
{
    const lf_print *print = k->print;
    const double shift = print->horizontal ? k->shape->shift_right_mm : k->shape->shift_down_mm;
    return (pixel - 0.5 * k->shape->n_along) * 25.4 / lf_print_dpi_along(print) - shift;
}

static double snapped(double stripe)
{
    const double whole = round(stripe);
    return fabs(stripe - whole) < SNAP ? whole : stripe;
}

/* edges[n_pixels + 1]: stripes at the edges of pixels. */
static void find_edges(const lf_looked *k, double along, double *edges)
{
    const lf_print *print = k->print;
    const lf_lens lens = lf_lens_of_print(print);
    for (int j = 0; j <= k->n_pixels; j++) {
        const double across = across_mm(k, j);
        const double phase = print->horizontal ? lf_lens_phase(&lens, along, across, 0)
                                               : lf_lens_phase(&lens, across, along, 0);
        edges[j] = snapped(print->n_views * (phase + 0.5 - k->shape->first_lens));
    }
}

/* middle[2 n_stripes]: where an eye looks at each place, in pixels. Beyond the ends, pixels have
 * the width of the last one. */
static void find_places(const lf_looked *k, const double *edges, double beside_px, double *middle)
{
    int j = 0;
    for (int p = 0; p < 2 * k->n_stripes; p++) {
        const double stripe = 0.5 * p;
        while (j + 2 <= k->n_pixels && edges[j + 1] <= stripe)
            j++;
        middle[p] = j + (stripe - edges[j]) / (edges[j + 1] - edges[j]) + beside_px;
    }
}

/* A snapped edge can select the cell next to the raster, with weight 0. */
static void put_stripe(const lf_looked *k, double stripe, double weight, int slot,
                       lf_stripe_mix *out)
{
    const int t = (int)fmin(fmax(stripe, 0.0), k->n_stripes - 1.0);
    out->lens[slot] = lf_looked_lens(k, t);
    out->view[slot] = lf_looked_view(k, t);
    out->weight[slot] = (float)weight;
}

static void mix_pixel(const lf_looked *k, double left, double right, lf_stripe_mix *out)
{
    const bool nearest = k->print->stripes == LF_STRIPES_NEAREST;
    const double first = floor(nearest ? snapped(0.5 * (left + right)) : left);
    for (int slot = 0; slot < 3; slot++) {
        const double stripe = first + slot,
                     covered = fmax(fmin(right, stripe + 1.0) - fmax(left, stripe), 0.0);
        const double weight = nearest ? slot == 0 : covered / (right - left);
        put_stripe(k, weight > 0.0 ? stripe : first, weight, slot, out);
    }
}

/* ------------------------------------------------------------------------------------- bands -- */

/* How far a place at the side of the print moves from the middle to the end, in pixels. */
static double moved_px(const lf_looked *k, double across, double along)
{
    const lf_lens lens = lf_lens_of_print(k->print);
    const double r = sqrt(across * across + along * along);
    return across * fabs(lf_lens_factor(&lens, r) / lf_lens_factor(&lens, across) - 1.0) *
           lf_print_dpi_across(k->print) / 25.4;
}

/* Places move with the square of the distance along the lenses. Returns that of the end. */
static double count_bands(lf_looked *k)
{
    const lf_optics *o = &k->print->optics;
    const double across = fmax(fabs(across_mm(k, 0.0)), fabs(across_mm(k, k->n_pixels))),
                 along = fmax(fabs(along_mm(k, 0.0)), fabs(along_mm(k, k->shape->n_along)));
    const double nominal_px = lf_print_dpi_across(k->print) / k->print->lpi / k->print->n_views;
    k->n_bands = 1;
    k->least_px = nominal_px;
    if (lf_print_is_exact(k->print)) {
        k->apart_px = moved_px(k, across, along);
        k->n_bands = (int)fmin(fmax(ceil(k->apart_px / APART_PX), 1.0), MOST_BANDS);
        k->least_px /= lf_lens_enlargement(o->thickness_mm, lf_optics_index(o), o->distance_mm);
    }
    return along;
}

static lf_status init_band(lf_looked *k, const lf_blur *blur, double along, double *scratch,
                           lf_looked_band *out)
{
    double *edges = scratch, *middle = scratch + k->n_pixels + 1;
    out->mix = lf_calloc((size_t)k->n_pixels, sizeof *out->mix);
    if (!out->mix)
        return LF_E_NOMEM;
    find_edges(k, along, edges);
    find_places(k, edges, blur->beside_px, middle);
    for (int j = 0; j < k->n_pixels; j++)
        mix_pixel(k, edges[j], edges[j + 1], &out->mix[j]);
    const lf_crosstalk_look look = {.middle = middle,
                                    .n_places = 2 * k->n_stripes,
                                    .n_dots = k->n_pixels,
                                    .spot = blur->spot,
                                    .extra = blur->extra,
                                    .n_extra = blur->n_extra,
                                    .extra_px = blur->extra_px};
    return lf_crosstalk_of_look(&look, &out->matrix);
}

/* The mean and the least part of an eye's light that its own stripe gives. */
static void find_own(lf_looked *k)
{
    const lf_looked_band *band = &k->bands[0];
    double all = 0.0;
    int n = 0;
    k->own_worst = 1.0;
    for (int t = 0; t < k->n_stripes; t++) {
        const double *share = lf_crosstalk_row(&band->matrix, 2 * t + 1);
        double own = 0.0, sum = 0.0;
        for (int d = 0; d < band->matrix.width; d++) {
            const lf_stripe_mix *mix = &band->mix[band->matrix.first[2 * t + 1] + d];
            for (int slot = 0; slot < 3; slot++)
                if (lf_looked_stripe(k, mix->lens[slot], mix->view[slot]) == t)
                    own += share[d] * (double)mix->weight[slot];
            sum += share[d];
        }
        n += sum > 0.0;
        all += own;
        k->own_worst = sum > 0.0 && own < k->own_worst ? own : k->own_worst;
    }
    k->own = n > 0 ? all / n : 0.0;
}

/* Eyes between views count less. */
static void weigh(const lf_looked *k, const lf_looked_band *band)
{
    for (int p = 0; p < 2 * k->n_stripes; p += 2)
        for (int d = 0; d < band->matrix.width; d++)
            lf_crosstalk_row(&band->matrix, p)[d] *= sqrt(LF_LOOKED_BETWEEN);
}

static lf_status init_bands(lf_looked *k, double end_mm, double *scratch)
{
    lf_blur blur;
    lf_status status = lf_blur_of_print(k->print, &blur);
    for (int b = 0; b < k->n_bands && status == LF_OK; b++)
        status = init_band(k, &blur, end_mm * sqrt((b + 0.5) / k->n_bands), scratch, &k->bands[b]);
    if (status == LF_OK)
        find_own(k);
    for (int b = 0; b < k->n_bands && status == LF_OK; b++) {
        weigh(k, &k->bands[b]);
        status = lf_unmix_init(&k->bands[b].unmix, &k->bands[b].matrix);
    }
    for (int i = 0; i < k->shape->n_along; i++) {
        const double part = along_mm(k, i + 0.5) / end_mm;
        k->band_at[i] = (int)fmin(k->n_bands * part * part, k->n_bands - 1.0);
    }
    return status;
}

lf_status lf_looked_init(lf_looked *k, const lf_print *print, const lf_print_shape *shape)
{
    *k = (lf_looked){.print = print,
                     .shape = shape,
                     .n_stripes = shape->n_lenses * print->n_views,
                     .n_pixels = print->horizontal ? shape->raster_height : shape->raster_width};
    const double end_mm = count_bands(k);
    double *scratch =
        lf_calloc((size_t)k->n_pixels + 1 + 2 * (size_t)k->n_stripes, sizeof *scratch);
    k->bands = lf_calloc((size_t)k->n_bands, sizeof *k->bands);
    k->band_at = lf_calloc((size_t)shape->n_along, sizeof *k->band_at);
    const lf_status status =
        scratch && k->bands && k->band_at ? init_bands(k, end_mm, scratch) : LF_E_NOMEM;
    lf_free(scratch);
    if (status != LF_OK)
        lf_looked_finish(k);
    return status == LF_OK ? LF_OK : LF_E_NOMEM;
}

void lf_looked_finish(lf_looked *k)
{
    for (int b = 0; k->bands && b < k->n_bands; b++) {
        lf_unmix_finish(&k->bands[b].unmix);
        lf_crosstalk_finish(&k->bands[b].matrix);
        lf_free(k->bands[b].mix);
    }
    lf_free(k->bands);
    lf_free(k->band_at);
    memset(k, 0, sizeof *k);
}
