/* The blur of a print as a spot, and crosstalk that was measured with another number of views. */
#include <math.h>
#include <string.h>

#include "quilt/print/blur.h"
#include "quilt/print/unmix.h"

#define SHARES (2 * LF_PRINT_CROSSTALK + 1)
/* The narrowest spot that a fit tries, and its last step, in stripes. */
#define NARROWEST 0.05
#define LAST_STEP 0.002

/* ------------------------------------------------------------------------------------ kernel -- */

/* The third integral of a step that ink has made soft. */
static double third_ramp(double x, double ink_px)
{
    if (ink_px <= 0.0)
        return x > 0.0 ? x * x * x / 6.0 : 0.0;
    const double z = x / ink_px, s2 = ink_px * ink_px;
    return (x * x * x + 3.0 * x * s2) / 6.0 * 0.5 * erfc(-z * 0.70710678118654752) +
           ink_px * (x * x + 2.0 * s2) / 6.0 * 0.39894228040143268 * exp(-0.5 * z * z);
}

/* The same after two pixels, each a box of width 1: one gathers light from the spot, the other was
 * mixed from stripes. */
static double ramp_of_pixels(double x, double ink_px)
{
    return third_ramp(x + 1.0, ink_px) - 2.0 * third_ramp(x, ink_px) + third_ramp(x - 1.0, ink_px);
}

/* The part of the light from the left of x, pixels from the middle of the spot. */
static double light_before(const lf_print_spot *spot, double x)
{
    const double half = 0.5 * spot->box_px;
    return (ramp_of_pixels(x + half, spot->ink_px) - ramp_of_pixels(x - half, spot->ink_px)) /
           spot->box_px;
}

void lf_blur_kernel(const lf_print_spot *spot, double beside_px, double stripe_px, int reach,
                    double *kernel)
{
    double before = light_before(spot, (-reach - 0.5) * stripe_px - beside_px);
    for (int k = -reach; k <= reach; k++) {
        const double after = light_before(spot, (k + 0.5) * stripe_px - beside_px);
        kernel[reach + k] = after - before;
        before = after;
    }
}

/* ----------------------------------------------------------------------------------- fitting -- */

static double pixels_per_lens(const lf_print *print)
{
    return lf_print_dpi_across(print) / print->lpi;
}

static double measured_stripe(const lf_print *print)
{
    const int measured = print->blur.crosstalk_views;
    return pixels_per_lens(print) / (measured > 0 ? measured : print->n_views);
}

lf_blur lf_blur_known(const lf_print *print)
{
    const lf_print_blur *blur = &print->blur;
    const double per_mm = lf_print_dpi_across(print) / 25.4;
    const bool measured = blur->n_crosstalk > 0; /* has all blur in itself */
    const double stripe =
        measured ? measured_stripe(print) : pixels_per_lens(print) / print->n_views;
    return (lf_blur){.spot = {.box_px = blur->spot_mm > 0.0 ? blur->spot_mm * per_mm : 0.5 * stripe,
                              .ink_px = measured ? 0.0 : blur->ink_mm * per_mm},
                     .n_extra = blur->n_crosstalk,
                     .extra_px = stripe};
}

double lf_blur_width(const lf_blur *blur)
{
    const lf_crosstalk_look look = {
        .spot = blur->spot, .n_extra = blur->n_extra, .extra_px = blur->extra_px};
    return lf_crosstalk_width(&look);
}

typedef struct fitting {
    double widest_px; /* of the whole blur */
    bool box;         /* the spot's width is unknown */
    double wanted[SHARES];
} fitting;

static double distance_of(const fitting *f, const lf_blur *blur)
{
    double kernel[SHARES] = {0.0}, sum = 0.0;
    const lf_print_spot *spot = &blur->spot;
    if (spot->ink_px < 0.0 || lf_blur_width(blur) > f->widest_px)
        return (double)INFINITY;
    lf_blur_kernel(spot, blur->beside_px, blur->extra_px, blur->n_extra, kernel);
    for (int i = 0; i <= 2 * blur->n_extra; i++)
        sum += (kernel[i] - f->wanted[i]) * (kernel[i] - f->wanted[i]);
    return sum;
}

/* Makes a spot softer. A spot of unknown width has as much blur from its box as from the ink. */
static void soften(const fitting *f, double ink_px, lf_blur *blur)
{
    blur->spot.ink_px = ink_px;
    if (f->box)
        blur->spot.box_px = fmax(sqrt(12.0) * ink_px, NARROWEST * blur->extra_px);
}

/* The spot that differs by one step and is nearest to the wanted kernel; directions 0 and 1 change
 * the width, 2 and 3 the place. False: none is nearer. */
static bool improve(const fitting *f, int n_directions, double step, double *best, lf_blur *blur)
{
    const lf_blur from = *blur;
    bool moved = false;
    for (int direction = 0; direction < n_directions; direction++) {
        const double by = direction % 2 ? step : -step;
        lf_blur next = from;
        if (direction < 2)
            soften(f, from.spot.ink_px + by, &next);
        else
            next.beside_px += by;
        const double distance = distance_of(f, &next);
        if (distance < *best) {
            *best = distance;
            *blur = next;
            moved = true;
        }
    }
    return moved;
}

/* Width and place whose kernel is nearest to the wanted one, the width first: a place aside leaks,
 * too. Steps of a quarter of a stripe are halved when none helps. */
static void fit_spot(const fitting *f, lf_blur *blur)
{
    soften(f, 0.0, blur);
    double best = distance_of(f, blur);
    for (int n_directions = 2; n_directions <= 4; n_directions += 2)
        for (double step = 0.25; step > LAST_STEP;)
            step *= improve(f, n_directions, step * blur->extra_px, &best, blur) ? 1.0 : 0.5;
}

/* The weights of spots, one stripe apart, whose sum has the wanted kernel if each has this one. */
static lf_status divide_kernels(const double *wanted, const double *kernel, int reach, double *out)
{
    enum { MOST = (4 * LF_PRINT_CROSSTALK + 1) * LF_UNMIX_LANES };
    const int size = 4 * reach + 1; /* rows at the ends are cut off */
    double light[MOST] = {0.0}, spots[MOST], turned[SHARES], sum = 0.0;
    lf_crosstalk k;
    lf_unmix unmix;
    for (int i = 0; i <= 2 * reach; i++) {
        turned[i] = kernel[2 * reach - i];
        light[(reach + i) * LF_UNMIX_LANES] = wanted[i];
    }
    lf_status status = lf_crosstalk_of_kernel(turned, size, reach, &k);
    if (status != LF_OK)
        return status;
    memcpy(spots, light, sizeof spots);
    status = lf_unmix_init(&unmix, &k);
    if (status == LF_OK) {
        const lf_unmix_part all = lf_unmix_part_of(&unmix, 0, size);
        lf_unmix_light(&unmix, &all, light, spots);
        lf_unmix_finish(&unmix);
    }
    for (int i = 0; i <= 2 * reach; i++)
        sum += out[i] = spots[(reach + i) * LF_UNMIX_LANES];
    for (int i = 0; i <= 2 * reach && sum > 0.0; i++)
        out[i] /= sum;
    lf_crosstalk_finish(&k);
    return status;
}

lf_status lf_blur_of_print(const lf_print *print, lf_blur *out)
{
    const int n = print->blur.n_crosstalk;
    const double side_mm = print->horizontal ? print->height_mm : print->width_mm;
    lf_blur blur = lf_blur_known(print);
    if (n == 0) {
        *out = blur;
        return LF_OK;
    }
    fitting f = {.widest_px =
                     fmin(LF_CROSSTALK_WIDTH, floor(side_mm * lf_print_dpi_across(print) / 25.4)),
                 .box = !(print->blur.spot_mm > 0.0)};
    double kernel[SHARES];
    for (int e = -n; e <= n; e++) /* from left to right on the print */
        f.wanted[n + e] = print->blur.crosstalk[print->reverse ? n + e : n - e];
    fit_spot(&f, &blur);
    lf_blur_kernel(&blur.spot, blur.beside_px, blur.extra_px, n, kernel);
    const lf_status status = divide_kernels(f.wanted, kernel, n, blur.extra);
    if (status == LF_OK)
        *out = blur;
    return status;
}

/* ---------------------------------------------------------------------------------- manifest -- */

json_t *lf_blur_crosstalk_json(const lf_print_blur *blur)
{
    json_t *shares = blur->n_crosstalk > 0 ? json_array() : NULL;
    for (int i = 0; shares && i <= 2 * blur->n_crosstalk; i++)
        json_array_append_new(shares, json_real(blur->crosstalk[i]));
    return shares ? json_pack("{s:i, s:o}", "views", blur->crosstalk_views, "shares", shares)
                  : NULL;
}

lf_status lf_print_take_crosstalk(const json_t *manifest, const char *where, lf_print_blur *out,
                                  lf_error *err)
{
    const json_t *part = json_object_get(manifest, "crosstalk"),
                 *shares = json_object_get(part, "shares");
    const json_int_t views = json_integer_value(json_object_get(part, "views"));
    const size_t n = json_array_size(shares);
    double taken[SHARES] = {0.0};
    if (!part)
        return LF_OK;
    bool sound = n % 2 == 1 && n <= SHARES && views >= 0 && views <= LF_PRINT_CROSSTALK_VIEWS;
    for (size_t i = 0; sound && i < n; i++) {
        const json_t *share = json_array_get(shares, i);
        taken[i] = json_number_value(share);
        sound = json_is_number(share) && taken[i] >= 0.0 && taken[i] <= 1.0;
    }
    if (!sound)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "its \"crosstalk\" is damaged; write the print again");
    out->n_crosstalk = (int)(n / 2);
    out->crosstalk_views = (int)views;
    memcpy(out->crosstalk, taken, sizeof taken);
    return LF_OK;
}
