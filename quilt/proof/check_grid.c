/* The stripes of the picture itself. Where a lens has more pixels than views, pixels share stripes,
 * and the file holds more values than unknowns: all pixels must be mixtures of the stripes that the
 * manifest promises. How far the stripes must be moved to fit best is their error of position. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/proof/check_internal.h"

#define N_LINES 16
#define MAX_LINES 256
#define MAX_BLOCKS 24
#define MOST_BYTES ((size_t)48 << 20) /* of the lines; fewer are measured on long prints */
#define LEAST_LENSES 16               /* of a block */
/* A stripe must be wider than this, in pixels, to leave values beyond the unknowns. */
#define LEAST_STRIPE 1.03
#define N_SCAN 32
/* The step of the parabola through the minimum, in pixels. */
#define STEP 0.04
/* Of a mean square misfit that should be 1. */
#define MISFIT 1.6
#define LEAST_FREEDOM 60.0
/* A measurement with a larger error says nothing. */
#define WORST_ERROR_UM 10.0

typedef struct lines {
    lf_check_stripes stripes;
    int n_lines, channels;
    double along_mm[MAX_LINES];    /* place of each line along the lenses */
    double light[256], slope[256]; /* of 8-bit values */
    double *value, *sigma;         /* [n_lines][n][channels] */
    double *scratch;
    int n_blocks;
    lf_check_block block[MAX_BLOCKS];
} lines;

static void finish(lines *l)
{
    lf_free(l->value);
    lf_free(l->sigma);
    lf_free(l->scratch);
}

static lf_status begin(const lf_check *check, lines *l)
{
    const lf_print *print = &check->print;
    const bool horizontal = print->horizontal;
    memset(l, 0, sizeof *l);
    l->stripes = lf_check_stripes_of(
        print, check->dpi, horizontal ? check->shape.raster_height : check->shape.raster_width);
    const int along = horizontal ? check->shape.raster_width : check->shape.raster_height;
    const int wanted = check->options->n_rows > 0 ? check->options->n_rows : N_LINES;
    const int n = l->stripes.n;
    const double lenses = n * l->stripes.pixel_mm / l->stripes.pitch_mm;
    l->n_lines = (int)fmin(fmin(wanted, along), MAX_LINES);
    l->channels = check->tags->samples;
    if (!l->stripes.nearest)
        l->channels = 3;
    l->n_blocks = (int)fmin(fmax(floor(lenses / LEAST_LENSES), 1.0), MAX_BLOCKS);
    for (int b = 0; b < l->n_blocks; b++) {
        const int first = (int)((int64_t)n * b / l->n_blocks),
                  end = (int)((int64_t)n * (b + 1) / l->n_blocks);
        l->block[b] =
            (lf_check_block){first, end, (0.5 * (first + end) - 0.5 * n) * l->stripes.pixel_mm};
    }
    for (int code = 0; code < 256; code++)
        l->light[code] = lf_check_light(code, 8, &l->slope[code]);
    const size_t values = (size_t)n * (size_t)l->channels;
    const size_t most = MOST_BYTES / (values * 2 * sizeof *l->value);
    if ((size_t)l->n_lines > most)
        l->n_lines = most > 0 ? (int)most : 1;
    l->value = lf_calloc((size_t)l->n_lines, values * sizeof *l->value);
    l->sigma = lf_calloc((size_t)l->n_lines, values * sizeof *l->sigma);
    l->scratch = lf_calloc((size_t)n + 4, 6 * sizeof *l->scratch);
    return l->value && l->sigma && l->scratch ? LF_OK : LF_E_NOMEM;
}

/* ------------------------------------------------------------------------------------ values -- */

static double code_of(const void *raw, int bits, size_t i)
{
    return bits == 16 ? ((const uint16_t *)raw)[i] : ((const uint8_t *)raw)[i];
}

/* Puts one stored pixel at place j of a line. */
static void put_pixel(const lf_check *check, lines *l, int line, int j, const void *raw,
                      size_t pixel)
{
    const int samples = check->tags->samples, bits = check->tags->bits;
    const size_t at = ((size_t)line * (size_t)l->stripes.n + (size_t)j) * (size_t)l->channels;
    const double code_sigma = sqrt(1.0 / 12.0);
    float light[3];
    if (!l->stripes.nearest && !check->grid.exact)
        lf_print_file_light(check->file,
                            (const unsigned char *)raw + pixel * (size_t)samples * (size_t)bits / 8,
                            1, light);
    for (int c = 0; c < l->channels; c++) {
        const double code = code_of(raw, bits, pixel * (size_t)samples + (size_t)c);
        double slope = 1.0;
        if (l->stripes.nearest) {
            l->value[at + (size_t)c] = code;
        } else if (check->grid.exact) {
            const int known = (int)code;
            if (bits == 8)
                slope = l->slope[known];
            l->value[at + (size_t)c] =
                bits == 8 ? l->light[known] : lf_check_light(code, bits, &slope);
            l->sigma[at + (size_t)c] = slope * code_sigma;
        } else {
            l->value[at + (size_t)c] = (double)light[c];
            l->sigma[at + (size_t)c] = 0.002;
        }
    }
}

/* The middle of part i of n equal parts of `length` pixels. */
static int middle_of(int i, int n, int length)
{
    return (int)((2 * (int64_t)i + 1) * length / (2 * (int64_t)n));
}

/* Vertical lenses: a line is a row. */
static lf_status read_rows(lf_check *check, lines *l, void *raw, lf_error *err)
{
    const lf_print_shape *shape = &check->shape;
    for (int line = 0; line < l->n_lines; line++) {
        const int y = middle_of(line, l->n_lines, shape->raster_height);
        const lf_status status =
            lf_print_file_raw(check->file, shape->margin_down_px + y, raw, err);
        l->along_mm[line] = (y + 0.5 - 0.5 * shape->raster_height) * l->stripes.along_pixel_mm;
        if (status != LF_OK)
            return status;
        for (int j = 0; j < l->stripes.n; j++) {
            const int x = check->print.mirror ? l->stripes.n - 1 - j : j;
            put_pixel(check, l, line, j, raw, (size_t)(shape->margin_px + x));
        }
    }
    return LF_OK;
}

/* Horizontal lenses: a line is a column, so that every row is read. */
static lf_status read_columns(lf_check *check, lines *l, void *raw, lf_error *err)
{
    const lf_print_shape *shape = &check->shape;
    for (int line = 0; line < l->n_lines; line++) {
        const double x =
            middle_of(line, l->n_lines, shape->raster_width) + 0.5 - 0.5 * shape->raster_width;
        l->along_mm[line] = (check->print.mirror ? -x : x) * l->stripes.along_pixel_mm;
    }
    for (int j = 0; j < l->stripes.n; j++) {
        const lf_status status =
            lf_print_file_raw(check->file, shape->margin_down_px + j, raw, err);
        if (status != LF_OK)
            return status;
        for (int line = 0; line < l->n_lines; line++)
            put_pixel(
                check, l, line, j, raw,
                (size_t)(shape->margin_px + middle_of(line, l->n_lines, shape->raster_width)));
    }
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- fitting -- */

static double misfit_of(const lines *l, int block, double moved_mm, double *out_freedom)
{
    double sum = 0.0, freedom = 0.0;
    for (int line = 0; line < l->n_lines; line++) {
        const size_t at = (size_t)line * (size_t)l->stripes.n * (size_t)l->channels;
        const lf_check_line values = {l->value + at, l->sigma + at, l->channels};
        double free_values = 0.0;
        lf_check_stripes stripes = l->stripes;
        stripes.along_mm = l->along_mm[line];
        sum += lf_check_misfit(&stripes, &values, &l->block[block], moved_mm, l->scratch,
                               &free_values);
        freedom += free_values;
    }
    *out_freedom = freedom;
    return sum;
}

/* Where the stripes of a block fit best. */
typedef struct best_fit {
    double moved_um, error_um;        /* one standard deviation; INFINITY: not measurable */
    double misfit, at_best, contrast; /* mean squares: as promised, moved, half a stripe away */
} best_fit;

/* The lowest point of the parabola through three equally spaced values, in steps from the middle
 * one; its curvature is *out_bend. */
static double lowest(double before, double at, double after, double *out_bend)
{
    *out_bend = before + after - 2.0 * at;
    return *out_bend > 0.0 ? 0.5 * (before - after) / *out_bend : 0.0;
}

/* Looks for the best place of the stripes anywhere within a stripe. */
static double scan(const lines *l, int block, double stripe_mm, double *out_least)
{
    double least = INFINITY, at = 0.0, freedom;
    for (int k = -N_SCAN / 2; k < N_SCAN / 2; k++) {
        const double moved = k * stripe_mm / N_SCAN, misfit = misfit_of(l, block, moved, &freedom);
        if (misfit < least || (misfit == least && fabs(moved) < fabs(at))) {
            least = misfit;
            at = moved;
        }
    }
    *out_least = least;
    return at;
}

/* Fractional stripes: the misfit rises as a parabola around the best place. */
static best_fit fit_fractional(const lines *l, int block, bool exact)
{
    const double stripe = l->stripes.pitch_mm / l->stripes.n_views;
    const double step = STEP * l->stripes.pixel_mm;
    double freedom, bend, center = 0.0;
    double at = misfit_of(l, block, 0.0, &freedom);
    const double far = misfit_of(l, block, 0.5 * stripe, &freedom);
    best_fit fit = {.misfit = at / fmax(freedom, 1.0), .contrast = far / fmax(freedom, 1.0)};
    double least = at;
    if (freedom < LEAST_FREEDOM) {
        fit.error_um = INFINITY;
        fit.misfit = fit.at_best = 0.0;
        return fit;
    }
    if (!exact || fit.misfit > MISFIT)
        center = scan(l, block, stripe, &least);
    if (least < 0.8 * at)
        at = least;
    else
        center = 0.0;
    const double moved = lowest(misfit_of(l, block, center - step, &freedom), at,
                                misfit_of(l, block, center + step, &freedom), &bend);
    fit.at_best = at / freedom;
    fit.moved_um = 1e3 * (center + fmax(fmin(moved, 1.0), -1.0) * step);
    /* lines and channels of a smooth picture repeat each other, with their roundings */
    const double repeated = l->n_lines * l->channels;
    fit.error_um = bend > 0.0 ? 1e3 * step * sqrt(2.0 * repeated * fmax(1.0, fit.at_best) / bend)
                              : (double)INFINITY;
    return fit;
}

/* Nearest stripes: the misfit is exactly 0 wherever no pixel's middle leaves its stripe. */
static best_fit fit_nearest(const lines *l, int block)
{
    const double stripe = l->stripes.pitch_mm / l->stripes.n_views;
    double freedom, least = 0.0, center = 0.0, away = 0.5 * stripe, ignored;
    const double at = misfit_of(l, block, 0.0, &freedom);
    best_fit fit = {.misfit = at / fmax(freedom, 1.0), .error_um = INFINITY};
    fit.contrast = misfit_of(l, block, 0.5 * stripe, &ignored) / fmax(freedom, 1.0);
    if (freedom < LEAST_FREEDOM)
        return (best_fit){.error_um = INFINITY};
    if (at > 0.0)
        center = scan(l, block, stripe, &least);
    fit.at_best = least / freedom;
    fit.moved_um = 1e3 * center;
    for (; away > 1e-3 * stripe; away *= 0.5) /* the smallest move that would show */
        if (!(misfit_of(l, block, center - away, &ignored) > least &&
              misfit_of(l, block, center + away, &ignored) > least))
            break;
    if (away < 0.5 * stripe && least < 0.05 * fmax(fit.contrast, fit.misfit) * freedom)
        fit.error_um = 1e3 * 2.0 * away / 3.0;
    return fit;
}

/* Neighbouring blocks differ by less than half a stripe. */
static double unwrapped(double moved, double before, double stripe_um)
{
    return moved + stripe_um * round((before - moved) / stripe_um);
}

static void measure(lf_check *check, const lines *l)
{
    const double stripe_um = 1e3 * l->stripes.pitch_mm / l->stripes.n_views;
    double x[MAX_BLOCKS], moved[MAX_BLOCKS], error[MAX_BLOCKS];
    lf_check_meter meter = {.what = "picture"};
    lf_check_grid *grid = &check->grid;
    int n = 0;
    for (int b = 0; b < l->n_blocks; b++) {
        const best_fit fit =
            l->stripes.nearest ? fit_nearest(l, b) : fit_fractional(l, b, grid->exact);
        grid->misfit = fmax(grid->misfit, fit.misfit);
        grid->at_best = fmax(grid->at_best, fit.at_best);
        grid->contrast = fmax(grid->contrast, fit.contrast);
        if (!isfinite(fit.error_um) || fit.error_um > stripe_um / 6.0)
            continue;
        x[n] = l->block[b].middle_mm;
        moved[n] = n > 0 ? unwrapped(fit.moved_um, moved[n - 1], stripe_um) : fit.moved_um;
        error[n++] = fmax(fit.error_um, 1e-3);
    }
    if (lf_check_fit(x, moved, error, n, l->stripes.n * l->stripes.pixel_mm,
                     l->stripes.nearest ? stripe_um : WORST_ERROR_UM, &meter))
        lf_check_add_meter(check, &meter);
}

lf_status lf_check_picture(lf_check *check, lf_error *err)
{
    lines l;
    lf_check_grid *grid = &check->grid;
    if (!check->fits || check->is_chart || !check->linear || check->print.compensation.on)
        return LF_OK;
    grid->exact = !check->print.icc_path && check->same_profile && check->tags->samples == 3;
    lf_status status = begin(check, &l);
    void *raw = status == LF_OK ? lf_calloc(1, lf_print_file_raw_bytes(check->file)) : NULL;
    if (!raw)
        status = lf_error_set(err, LF_E_NOMEM, check->path, "out of memory");
    grid->can = status == LF_OK &&
                (l.stripes.nearest ? lf_check_stripe_px(&l.stripes) >= LEAST_STRIPE
                                   : LEAST_STRIPE * lf_check_stripe_reach(&l.stripes) <= 1.0);
    if (grid->can) {
        lf_error trouble = {0};
        status = check->print.horizontal ? read_columns(check, &l, raw, &trouble)
                                         : read_rows(check, &l, raw, &trouble);
        if (status == LF_OK) {
            measure(check, &l);
        } else {
            snprintf(check->trouble, sizeof check->trouble, "%s", trouble.what);
            check->fits = grid->can = false;
            status = LF_OK;
        }
    }
    lf_free(raw);
    finish(&l);
    return status;
}
