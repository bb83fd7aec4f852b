#include "quilt/print/compensate.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/looked.h"

/* Horizontal lenses: rows that are solved together, and rows around them that they depend on. */
#define PART_ROWS 64
#define AROUND_ROWS 16

/* Sums over what was printed. */
typedef struct tally {
    double sum, plain_sum, worst, plain_worst;
    double between, plain_between;
    int64_t n_seen, n_between, n_dots, n_clamped;
} tally;

struct lf_compensate {
    const lf_print *print;
    const lf_print_shape *shape;
    const lf_looked *looked;
    tally *tallies;  /* [raster_height]; rows of the print belong to one thread each */
    lf_looked whole; /* of the whole */
    /* of a share: */
    const lf_print_source *source;
    const lf_looked_band *band; /* in use, also by unmix */
    lf_unmix unmix;
    double *wanted, *pixels; /* [places], [pixels][LF_UNMIX_LANES] */
    /* horizontal: rows part_begin..part_end-1 are done, with their tallies. lines: of the stripes
     * from first_stripe on, [most_stripes][n_along][3]; rows: of the pixels from first_row on,
     * [most_rows][n_along][3] */
    int part_begin, part_end, first_row, first_stripe, most_rows, most_stripes;
    tally part_tallies[PART_ROWS];
    float *lines, *rows;
};

/* ----------------------------------------------------------------------------- what is asked -- */

static lf_status check_kernel(const lf_print_blur *blur, lf_error *err)
{
    double sum = 0.0;
    bool sound = blur->n_crosstalk >= 0 && blur->n_crosstalk <= LF_PRINT_CROSSTALK;
    if (blur->n_crosstalk == 0)
        return LF_OK;
    for (int i = 0; sound && i <= 2 * blur->n_crosstalk; i++) {
        sound = blur->crosstalk[i] >= 0.0 && blur->crosstalk[i] <= 1.0;
        sum += blur->crosstalk[i];
    }
    if (!sound || fabs(sum - 1.0) > 0.01)
        return lf_error_set(err, LF_E_ARG, "print",
                            "the measured crosstalk is no set of shares with the sum 1; measure "
                            "it again");
    return LF_OK;
}

lf_status lf_compensate_check(const lf_print *print, lf_error *err)
{
    const lf_print_blur *blur = &print->blur;
    if (!print->compensation.on)
        return LF_OK;
    if (!(blur->n_crosstalk > 0 || blur->spot_mm > 0.0 || blur->ink_mm > 0.0 ||
          blur->dot_gain > 0.0))
        return lf_error_set(err, LF_E_ARG, "print",
                            "nothing is known that could be compensated; give --spot, "
                            "--ink-spread, --dot-gain or profiles with them");
    if (print->frame_ppi > 0.0)
        return lf_error_set(err, LF_E_ARG, "print",
                            "a frame set is not interlaced; leave --compensate out");
    if (print->sheet.columns > 1 || print->sheet.rows > 1)
        return lf_error_set(err, LF_E_ARG, "print",
                            "compensation takes one print; leave --copies or --compensate out");
    if (print->optics.slant != 0.0 || print->optics.grid != LF_LENS_LINEAR)
        return lf_error_set(err, LF_E_ARG, "print",
                            "compensation needs straight linear lenses; leave --compensate out");
    const lf_status status = check_kernel(blur, err);
    const double side_mm = print->horizontal ? print->height_mm : print->width_mm;
    const lf_blur known = lf_blur_known(print);
    const double width = lf_blur_width(&known);
    if (status == LF_OK && !(width <= LF_CROSSTALK_WIDTH &&
                             width <= floor(side_mm * lf_print_dpi_across(print) / 25.4)))
        return lf_error_set(err, LF_E_ARG, "print",
                            "a blur of %.0f pixels cannot be compensated; expected at most %d, and "
                            "less than the print",
                            width, LF_CROSSTALK_WIDTH);
    return status;
}

/* ------------------------------------------------------------------------------------ object -- */

/* Takes the band of a row (column). */
static void turn_to(lf_compensate *c, int along)
{
    const lf_looked_band *band = &c->looked->bands[c->looked->band_at[along]];
    if (band == c->band)
        return;
    c->band = band;
    lf_unmix_turn(&c->unmix, &band->unmix);
}

static int width_of(const lf_compensate *c)
{
    return c->looked->bands[0].matrix.width;
}

static lf_status alloc_rows(lf_compensate *c)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    const lf_looked *k = c->looked;
    c->most_rows = PART_ROWS + 2 * (AROUND_ROWS + 2 * width_of(c));
    c->most_stripes = (int)ceil((c->most_rows + k->apart_px) / k->least_px) + 6;
    c->lines = lf_calloc((size_t)c->most_stripes * line, sizeof *c->lines);
    c->rows = lf_calloc((size_t)c->most_rows * line, sizeof *c->rows);
    return c->lines && c->rows ? LF_OK : LF_E_NOMEM;
}

lf_status lf_compensate_create(const lf_print *print, const lf_print_shape *shape,
                               lf_compensate **out)
{
    lf_compensate *c = NULL;
    if (print->compensation.on) {
        c = lf_calloc(1, sizeof *c);
        if (!c)
            return LF_E_NOMEM;
        *c = (lf_compensate){.print = print, .shape = shape};
        c->looked = &c->whole;
        c->tallies = lf_calloc((size_t)shape->raster_height, sizeof *c->tallies);
        if (!c->tallies || lf_looked_init(&c->whole, print, shape) != LF_OK) {
            lf_compensate_destroy(c);
            return LF_E_NOMEM;
        }
    }
    *out = c;
    return LF_OK;
}

lf_status lf_compensate_share(lf_compensate *whole, const lf_print_source *source,
                              lf_compensate **out)
{
    lf_compensate *c = lf_calloc(1, sizeof *c);
    if (!c)
        return LF_E_NOMEM;
    *c = (lf_compensate){.print = whole->print,
                         .shape = whole->shape,
                         .looked = whole->looked,
                         .tallies = whole->tallies,
                         .source = source,
                         .band = &whole->looked->bands[0]};
    c->wanted = lf_calloc((size_t)c->looked->n_stripes * 2 * LF_UNMIX_LANES, sizeof *c->wanted);
    c->pixels = lf_calloc((size_t)c->looked->n_pixels * LF_UNMIX_LANES, sizeof *c->pixels);
    lf_status status =
        c->wanted && c->pixels ? lf_unmix_share(&c->unmix, &c->band->unmix) : LF_E_NOMEM;
    if (status == LF_OK && c->print->horizontal)
        status = alloc_rows(c);
    if (status != LF_OK) {
        lf_compensate_destroy(c);
        return status;
    }
    *out = c;
    return LF_OK;
}

void lf_compensate_destroy(lf_compensate *c)
{
    if (!c)
        return;
    if (!c->source)
        lf_free(c->tallies);
    lf_unmix_finish(&c->unmix);
    lf_looked_finish(&c->whole);
    lf_free(c->wanted);
    lf_free(c->pixels);
    lf_free(c->lines);
    lf_free(c->rows);
    lf_free(c);
}

/* ------------------------------------------------------------------------------------- light -- */

double lf_dot_gain_undone(double light, double gain)
{
    const double dark = 1.0 - light, slope = 1.0 + 4.0 * gain;
    const double root = sqrt(fmax(slope * slope - 16.0 * gain * dark, 0.0));
    return 1.0 - 2.0 * dark / (slope + root);
}

static double within(double v)
{
    return v > 0.0 ? v < 1.0 ? v : 1.0 : 0.0;
}

/* Presses light together, so that the gamut has room at both ends. */
static double pressed(const lf_compensate *c, float light)
{
    const double room = c->print->compensation.headroom;
    return room + (1.0 - 2.0 * room) * within((double)light);
}

static float printed(const lf_compensate *c, double light)
{
    const double gain = c->print->blur.dot_gain;
    return (float)(gain > 0.0 ? lf_dot_gain_undone(within(light), gain) : light);
}

/* The light that eyes between views should see. */
static void want_between(lf_compensate *c, int begin, int end)
{
    for (int t = begin; t < end; t++) {
        const double *above = c->wanted + (size_t)(2 * t + 1) * LF_UNMIX_LANES,
                     *below = t > 0 ? above - 2 * LF_UNMIX_LANES : above;
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
            c->wanted[(size_t)(2 * t) * LF_UNMIX_LANES + (size_t)lane] =
                sqrt(LF_LOOKED_BETWEEN) * 0.5 * (above[lane] + below[lane]);
    }
}

/* Adds up what eyes see at places first..end-1, in n_lanes lanes. */
static void count_seen(const lf_compensate *c, int first, int end, int n_lanes, tally *sums)
{
    for (int p = first; p < end; p++) {
        const int dot = c->band->matrix.first[p];
        if (dot == 0 || dot + c->band->matrix.width == c->looked->n_pixels)
            continue; /* part of the spot may be off the print */
        for (int lane = 0; lane < n_lanes; lane++) {
            const double left = fabs(c->unmix.error[(size_t)p * LF_UNMIX_LANES + (size_t)lane]),
                         plain = fabs(c->unmix.plain[(size_t)p * LF_UNMIX_LANES + (size_t)lane]);
            if (p % 2 == 0) {
                sums->between += left;
                sums->plain_between += plain;
                continue;
            }
            sums->sum += left;
            sums->plain_sum += plain;
            sums->worst = fmax(sums->worst, left);
            sums->plain_worst = fmax(sums->plain_worst, plain);
        }
        *(p % 2 == 0 ? &sums->n_between : &sums->n_seen) += n_lanes;
    }
}

static void count_clamped(const lf_compensate *c, int dot, int n_lanes, tally *sums)
{
    for (int lane = 0; lane < n_lanes; lane++)
        sums->n_clamped += c->unmix.clamped[dot] >> lane & 1;
    sums->n_dots += n_lanes;
}

lf_print_left lf_compensate_left(const lf_compensate *c)
{
    tally all = {0};
    for (int y = 0; y < c->shape->raster_height; y++) {
        const tally *row = &c->tallies[y];
        all.sum += row->sum;
        all.plain_sum += row->plain_sum;
        all.worst = fmax(all.worst, row->worst);
        all.plain_worst = fmax(all.plain_worst, row->plain_worst);
        all.between += row->between;
        all.plain_between += row->plain_between;
        all.n_seen += row->n_seen;
        all.n_between += row->n_between;
        all.n_dots += row->n_dots;
        all.n_clamped += row->n_clamped;
    }
    const double n_seen = all.n_seen > 0 ? (double)all.n_seen : 1.0,
                 n_dots = all.n_dots > 0 ? (double)all.n_dots : 1.0,
                 n_between =
                     sqrt(LF_LOOKED_BETWEEN) * (all.n_between > 0 ? (double)all.n_between : 1.0);
    return (lf_print_left){.compensated = true,
                           .own_share = c->looked->own,
                           .own_share_worst = c->looked->own_worst,
                           .ghost_before = all.plain_sum / n_seen,
                           .ghost = all.sum / n_seen,
                           .worst_before = all.plain_worst,
                           .worst = all.worst,
                           .between_before = all.plain_between / n_between,
                           .between = all.between / n_between,
                           .clamped = (double)all.n_clamped / n_dots};
}

/* --------------------------------------------------------------------------- vertical lenses -- */

void lf_compensate_across(lf_compensate *c, int y, const float *samples, float *row)
{
    const int n_pixels = c->looked->n_pixels;
    turn_to(c, y);
    const lf_unmix_part all = lf_unmix_part_of(&c->unmix, 0, n_pixels);
    for (int t = 0; t < c->looked->n_stripes; t++) {
        const float *in =
            samples + 3 * ((size_t)lf_looked_view(c->looked, t) * (size_t)c->shape->n_lenses +
                           (size_t)lf_looked_lens(c->looked, t));
        for (int i = 0; i < 3; i++)
            c->wanted[(size_t)(2 * t + 1) * LF_UNMIX_LANES + (size_t)i] = pressed(c, in[i]);
    }
    want_between(c, 0, c->looked->n_stripes);
    for (int x = 0; x < n_pixels; x++)
        for (int i = 0; i < 3; i++)
            c->pixels[(size_t)x * LF_UNMIX_LANES + (size_t)i] = pressed(c, row[3 * x + i]);
    lf_unmix_light(&c->unmix, &all, c->wanted, c->pixels);
    tally sums = {0};
    count_seen(c, all.first_place, all.end_place, 3, &sums);
    for (int x = 0; x < n_pixels; x++)
        count_clamped(c, x, 3, &sums);
    c->tallies[y] = sums;
    for (int x = 0; x < n_pixels; x++)
        for (int i = 0; i < 3; i++)
            row[3 * x + i] = printed(c, c->pixels[(size_t)x * LF_UNMIX_LANES + (size_t)i]);
}

/* ------------------------------------------------------------------------- horizontal lenses -- */

/* Widens *first..*last to the stripes that the rows begin..end-1 need. */
static void stripes_of_rows(const lf_looked *k, int begin, int end, int *first, int *last)
{
    for (int b = 0; b < k->n_bands; b++) {
        const lf_unmix_part part = lf_unmix_part_of(&k->bands[b].unmix, begin, end);
        const int above = part.first_place / 2 - 1, below = (part.end_place - 1) / 2;
        *first = (int)fmin(*first, above);
        *last = (int)fmax(*last, below);
        for (int y = begin; y < end; y++) {
            const lf_stripe_mix *mix = &k->bands[b].mix[y];
            for (int slot = 0; slot < 3; slot++) {
                const int t = lf_looked_stripe(k, mix->lens[slot], mix->view[slot]);
                *first = (int)fmin(*first, t);
                *last = (int)fmax(*last, t);
            }
        }
    }
    *first = (int)fmax(*first, 0);
}

/* Makes a row from the stripes. */
static void mix_row(const lf_compensate *c, int y, float *out)
{
    const lf_looked *k = c->looked;
    const size_t line = 3 * (size_t)c->shape->n_along;
    for (int begin = 0, end; begin < c->shape->n_along; begin = end) {
        const lf_stripe_mix *mix = &k->bands[k->band_at[begin]].mix[y];
        const float *in[3];
        for (end = begin + 1; end < c->shape->n_along && k->band_at[end] == k->band_at[begin];)
            end++;
        for (int slot = 0; slot < 3; slot++) {
            const int t = lf_looked_stripe(k, mix->lens[slot], mix->view[slot]);
            in[slot] = c->lines + (size_t)(t - c->first_stripe) * line;
        }
        for (int i = 3 * begin; i < 3 * end; i++)
            out[i] =
                mix->weight[0] * in[0][i] + mix->weight[1] * in[1][i] + mix->weight[2] * in[2][i];
    }
}

/* Fetches the stripes that the rows begin..end-1 need, and makes these rows from them. */
static void fetch_rows(lf_compensate *c, int begin, int end)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    int first = c->looked->n_stripes, last = 0;
    stripes_of_rows(c->looked, begin, end, &first, &last);
    c->first_row = begin;
    c->first_stripe = first;
    for (int t = first; t <= last; t++)
        lf_print_source_along(c->source, lf_looked_view(c->looked, t), lf_looked_lens(c->looked, t),
                              c->lines + (size_t)(t - first) * line);
    for (int y = begin; y < end; y++)
        mix_row(c, y, c->rows + (size_t)(y - begin) * line);
}

/* The first place, from one on, whose spot begins in row y or below. */
static int place_in_row(const lf_compensate *c, const lf_unmix_part *part, int y, int from)
{
    while (from < part->end_place && c->band->matrix.first[from] < y)
        from++;
    return from;
}

/* Solves n_lanes neighbouring values of the rows row_begin..row_end-1. */
static void solve_columns(lf_compensate *c, int row_begin, int row_end, size_t at, int n_lanes)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    turn_to(c, (int)(at / 3));
    const lf_unmix_part rows = lf_unmix_part_of(&c->unmix, row_begin, row_end), *part = &rows;
    const int begin = part->first_place / 2, end = (part->end_place + 1) / 2;
    for (int t = begin > 0 ? begin - 1 : 0; t < end; t++) {
        const float *in = c->lines + (size_t)(t - c->first_stripe) * line + at;
        for (int lane = 0; lane < n_lanes; lane++)
            c->wanted[(size_t)(2 * t + 1) * LF_UNMIX_LANES + (size_t)lane] = pressed(c, in[lane]);
    }
    want_between(c, begin, end);
    for (int y = part->begin; y < part->end; y++) {
        const float *in = c->rows + (size_t)(y - part->begin) * line + at;
        for (int lane = 0; lane < n_lanes; lane++)
            c->pixels[(size_t)y * LF_UNMIX_LANES + (size_t)lane] = pressed(c, in[lane]);
    }
    lf_unmix_light(&c->unmix, part, c->wanted, c->pixels);
    int place = part->first_place;
    for (int y = c->part_begin; y < c->part_end; y++) {
        tally *sums = &c->part_tallies[y - c->part_begin];
        const int begin_place = place_in_row(c, part, y, place);
        place = place_in_row(c, part, y + 1, begin_place);
        count_seen(c, begin_place, place, n_lanes, sums);
        count_clamped(c, y, n_lanes, sums);
        float *out = c->rows + (size_t)(y - part->begin) * line + at;
        for (int lane = 0; lane < n_lanes; lane++)
            out[lane] = printed(c, c->pixels[(size_t)y * LF_UNMIX_LANES + (size_t)lane]);
    }
}

static void make_part(lf_compensate *c, int y)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    const int around = AROUND_ROWS + 2 * width_of(c);
    c->part_begin = y - y % PART_ROWS;
    c->part_end = c->part_begin + PART_ROWS < c->looked->n_pixels ? c->part_begin + PART_ROWS
                                                                  : c->looked->n_pixels;
    const int begin = c->part_begin > around ? c->part_begin - around : 0,
              end = c->part_end + around < c->looked->n_pixels ? c->part_end + around
                                                               : c->looked->n_pixels;
    fetch_rows(c, begin, end);
    memset(c->part_tallies, 0, sizeof c->part_tallies);
    for (size_t at = 0; at < line; at += LF_UNMIX_LANES)
        solve_columns(c, begin, end, at,
                      line - at < LF_UNMIX_LANES ? (int)(line - at) : LF_UNMIX_LANES);
}

void lf_compensate_down(lf_compensate *c, int y, float *row)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    if (y < c->part_begin || y >= c->part_end)
        make_part(c, y);
    c->tallies[y] = c->part_tallies[y - c->part_begin];
    memcpy(row, c->rows + (size_t)(y - c->first_row) * line, line * sizeof *row);
}
