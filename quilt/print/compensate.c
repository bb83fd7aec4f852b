#include "quilt/print/compensate.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/unmix.h"

/* The weight of an eye between two views, next to that of an eye at a view. */
#define BETWEEN 0.012
/* Horizontal lenses: rows that are solved together, and rows around them that they depend on. */
#define PART_ROWS 64
#define AROUND_ROWS 16

/* Sums over what was printed. */
typedef struct tally {
    double sum, plain_sum, worst, plain_worst;
    int64_t n_seen, n_dots, n_clamped;
} tally;

struct lf_compensate {
    const lf_print *print;
    const lf_print_shape *shape;
    const lf_stripe_mix *mix;
    int n_stripes, n_pixels; /* across the lenses */
    const lf_crosstalk *crosstalk;
    lf_unmix unmix;
    tally *tallies; /* [raster_height]; rows of the print belong to one thread each */
    /* of the whole: */
    lf_crosstalk matrix; /* places 2 t: the border below stripe t; 2 t + 1: its middle */
    double own, own_worst;
    /* of a share: */
    const lf_print_source *source;
    double *wanted, *pixels; /* [places], [pixels][LF_UNMIX_LANES] */
    /* horizontal: rows part_begin..part_end-1 are done, with their tallies. lines: of the stripes
     * from first_stripe on, [most_stripes][n_along][3]; rows: of the pixels from first_row on,
     * [most_rows][n_along][3] */
    int part_begin, part_end, first_row, first_stripe, most_rows, most_stripes;
    tally part_tallies[PART_ROWS];
    float *lines, *rows;
};

/* ---------------------------------------------------------------------------------- geometry -- */

static double pixels_per_stripe(const lf_print *print)
{
    return lf_print_dpi_across(print) / print->lpi / print->n_views;
}

/* The spot of a lens, softened by the ink. A measured crosstalk has all blur in itself. */
static lf_print_spot spot_of(const lf_print *print)
{
    const lf_print_blur *blur = &print->blur;
    const double per_mm = lf_print_dpi_across(print) / 25.4;
    return (lf_print_spot){.box_px = blur->spot_mm > 0.0 ? blur->spot_mm * per_mm
                                                         : 0.5 * pixels_per_stripe(print),
                           .ink_px = blur->n_crosstalk > 0 ? 0.0 : blur->ink_mm * per_mm};
}

static lf_crosstalk_look look_of(const lf_print *print)
{
    return (lf_crosstalk_look){.spot = spot_of(print),
                               .n_extra = print->blur.n_crosstalk,
                               .extra_px = pixels_per_stripe(print)};
}

/* Stripes are numbered across the lenses, from the first lens's. */
static int stripe_of(const lf_print *print, int lens, int view)
{
    return lens * print->n_views + (print->reverse ? view : print->n_views - 1 - view);
}

static int lens_of_stripe(const lf_print *print, int stripe)
{
    return stripe / print->n_views;
}

static int view_of_stripe(const lf_print *print, int stripe)
{
    const int m = stripe % print->n_views;
    return print->reverse ? m : print->n_views - 1 - m;
}

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
    if (print->optics.slant != 0.0 || print->optics.grid != LF_LENS_LINEAR ||
        lf_print_is_exact(print))
        return lf_error_set(err, LF_E_ARG, "print",
                            "compensation needs straight linear lenses and the uniform map; leave "
                            "--compensate out");
    const lf_status status = check_kernel(blur, err);
    const lf_crosstalk_look look = look_of(print);
    const double side_mm = print->horizontal ? print->height_mm : print->width_mm;
    const double width = lf_crosstalk_width(&look);
    if (status == LF_OK && !(width <= LF_CROSSTALK_WIDTH &&
                             width <= floor(side_mm * lf_print_dpi_across(print) / 25.4)))
        return lf_error_set(err, LF_E_ARG, "print",
                            "a blur of %.0f pixels cannot be compensated; expected at most %d, and "
                            "less than the print",
                            width, LF_CROSSTALK_WIDTH);
    return status;
}

/* ------------------------------------------------------------------------------------ kernel -- */

/* Mean share of stripe t + d in what an eye sees at stripe t, d = -reach..reach; and the least own
 * share of a stripe. */
static double mean_kernel(const lf_compensate *c, const lf_crosstalk *k, int reach, double *out)
{
    double least = 1.0;
    int n = 0;
    memset(out, 0, (size_t)(2 * reach + 1) * sizeof *out);
    for (int t = 0; t < c->n_stripes; t++) {
        const double *share = lf_crosstalk_row(k, 2 * t + 1);
        double own = 0.0, sum = 0.0;
        for (int d = 0; d < k->width; d++) {
            const lf_stripe_mix *mix = &c->mix[k->first[2 * t + 1] + d];
            for (int slot = 0; slot < 3; slot++) {
                const int at = stripe_of(c->print, mix->lens[slot], mix->view[slot]) - t;
                const double part = share[d] * (double)mix->weight[slot];
                sum += part;
                own += at == 0 ? part : 0.0;
                if (at >= -reach && at <= reach)
                    out[reach + at] += part;
            }
        }
        n += sum > 0.0;
        least = sum > 0.0 && own < least ? own : least;
    }
    for (int d = 0; d <= 2 * reach && n > 0; d++)
        out[d] /= n;
    return least;
}

/* A spot that lies beside the place at which an eye looks. */
typedef struct placed_spot {
    lf_print_spot spot;
    double beside_px;
} placed_spot;

/* Kernels of spots: the matrix of the whole print, to the spots' sum with the weights `extra`
 * (NULL: one spot). middle[2 n_stripes] is scratch. */
static lf_status make_matrix(const lf_compensate *c, const placed_spot *placed, const double *extra,
                             double *middle, lf_crosstalk *out)
{
    const lf_print *print = c->print;
    const double step = pixels_per_stripe(print);
    const double shift_mm = print->horizontal ? c->shape->shift_down_mm : c->shape->shift_right_mm;
    const double phase_px = (print->phase_mm + shift_mm) * lf_print_dpi_across(print) / 25.4;
    const double first = 0.5 * c->n_pixels + phase_px +
                         (c->shape->first_lens - 0.5) * print->n_views * step + placed->beside_px;
    for (int p = 0; p < 2 * c->n_stripes; p++)
        middle[p] = first + 0.5 * p * step;
    const lf_crosstalk_look look = {.middle = middle,
                                    .n_places = 2 * c->n_stripes,
                                    .n_dots = c->n_pixels,
                                    .spot = placed->spot,
                                    .extra = extra,
                                    .n_extra = extra ? print->blur.n_crosstalk : 0,
                                    .extra_px = step};
    return lf_crosstalk_of_look(&look, out);
}

/* Sets kernel[2 reach + 1] of a spot, and its distance from the wanted one; infinite without
 * memory or if the spot is too wide. */
static double distance_of(const lf_compensate *c, const placed_spot *placed, const double *wanted,
                          double *middle, double *kernel)
{
    const int reach = c->print->blur.n_crosstalk;
    double sum = 0.0;
    lf_crosstalk k;
    if (placed->spot.ink_px < 0.0 || make_matrix(c, placed, NULL, middle, &k) != LF_OK)
        return (double)INFINITY;
    mean_kernel(c, &k, reach, kernel);
    lf_crosstalk_finish(&k);
    for (int i = 0; i <= 2 * reach; i++)
        sum += (kernel[i] - wanted[i]) * (kernel[i] - wanted[i]);
    return sum;
}

/* The ink and the place of the spot whose mean kernel is nearest to the wanted one: a search with
 * steps of a quarter of a stripe, halved when no step helps. Sets its kernel. */
static void fit_spot(const lf_compensate *c, const double *wanted, double *middle,
                     placed_spot *spot, double *kernel)
{
    const double least = 0.002 * pixels_per_stripe(c->print);
    double best = distance_of(c, spot, wanted, middle, kernel);
    for (double step = 0.25 * pixels_per_stripe(c->print); step > least;) {
        placed_spot better = *spot;
        for (int direction = 0; direction < 4; direction++) {
            placed_spot next = *spot;
            *(direction < 2 ? &next.beside_px : &next.spot.ink_px) += direction % 2 ? step : -step;
            const double distance = distance_of(c, &next, wanted, middle, kernel);
            if (distance < best) {
                best = distance;
                better = next;
            }
        }
        if (better.beside_px == spot->beside_px && better.spot.ink_px == spot->spot.ink_px)
            step *= 0.5;
        *spot = better;
    }
    distance_of(c, spot, wanted, middle, kernel);
}

/* The weights of spots, one stripe apart, whose sum has the wanted kernel if each has this one. */
static lf_status divide_kernels(const double *wanted, const double *kernel, int reach, double *out)
{
    enum { MOST = (4 * LF_PRINT_CROSSTALK + 1) * LF_UNMIX_LANES };
    const int size = 4 * reach + 1; /* rows at the ends are cut off */
    double light[MOST] = {0.0}, spots[MOST], turned[2 * LF_PRINT_CROSSTALK + 1];
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
        out[i] = spots[(reach + i) * LF_UNMIX_LANES];
    lf_crosstalk_finish(&k);
    return status;
}

static lf_status make_crosstalk(lf_compensate *c, double *middle)
{
    const lf_print_blur *blur = &c->print->blur;
    const int n = blur->n_crosstalk;
    double wanted[2 * LF_PRINT_CROSSTALK + 1], kernel[2 * LF_PRINT_CROSSTALK + 1],
        extra[2 * LF_PRINT_CROSSTALK + 1];
    placed_spot spot = {spot_of(c->print), 0.0};
    if (n == 0)
        return make_matrix(c, &spot, NULL, middle, &c->matrix);
    for (int e = -n; e <= n; e++) /* from left to right on the print */
        wanted[n + e] = blur->crosstalk[c->print->reverse ? n + e : n - e];
    fit_spot(c, wanted, middle, &spot, kernel);
    const lf_status status = divide_kernels(wanted, kernel, n, extra);
    return status != LF_OK ? status : make_matrix(c, &spot, extra, middle, &c->matrix);
}

/* Eyes between views count less. */
static void weigh(lf_compensate *c)
{
    for (int p = 0; p < 2 * c->n_stripes; p += 2)
        for (int d = 0; d < c->crosstalk->width; d++)
            lf_crosstalk_row(&c->matrix, p)[d] *= sqrt(BETWEEN);
}

/* ------------------------------------------------------------------------------------ object -- */

static lf_status alloc_rows(lf_compensate *c)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    c->most_rows = PART_ROWS + 2 * (AROUND_ROWS + 2 * c->crosstalk->width);
    c->most_stripes = (int)ceil(c->most_rows / pixels_per_stripe(c->print)) + 6;
    c->lines = lf_calloc((size_t)c->most_stripes * line, sizeof *c->lines);
    c->rows = lf_calloc((size_t)c->most_rows * line, sizeof *c->rows);
    return c->lines && c->rows ? LF_OK : LF_E_NOMEM;
}

static lf_status init(lf_compensate *c)
{
    double kernel[1], *middle = lf_calloc((size_t)c->n_stripes, 2 * sizeof *middle);
    lf_status status = middle ? make_crosstalk(c, middle) : LF_E_NOMEM;
    lf_free(middle);
    c->crosstalk = &c->matrix;
    c->tallies = lf_calloc((size_t)c->shape->raster_height, sizeof *c->tallies);
    if (status != LF_OK || !c->tallies)
        return LF_E_NOMEM;
    c->own_worst = mean_kernel(c, &c->matrix, 0, kernel);
    c->own = kernel[0];
    weigh(c);
    return lf_unmix_init(&c->unmix, &c->matrix);
}

lf_status lf_compensate_create(const lf_print *print, const lf_print_shape *shape,
                               const lf_stripe_mix *mix, lf_compensate **out)
{
    lf_compensate *c = NULL;
    if (print->compensation.on) {
        c = lf_calloc(1, sizeof *c);
        if (!c)
            return LF_E_NOMEM;
        *c = (lf_compensate){.print = print,
                             .shape = shape,
                             .mix = mix,
                             .n_stripes = shape->n_lenses * print->n_views,
                             .n_pixels =
                                 print->horizontal ? shape->raster_height : shape->raster_width};
        const lf_status status = init(c);
        if (status != LF_OK) {
            lf_compensate_destroy(c);
            return status;
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
                         .mix = whole->mix,
                         .n_stripes = whole->n_stripes,
                         .n_pixels = whole->n_pixels,
                         .crosstalk = whole->crosstalk,
                         .tallies = whole->tallies,
                         .source = source};
    c->wanted = lf_calloc((size_t)c->n_stripes * 2 * LF_UNMIX_LANES, sizeof *c->wanted);
    c->pixels = lf_calloc((size_t)c->n_pixels * LF_UNMIX_LANES, sizeof *c->pixels);
    lf_status status =
        c->wanted && c->pixels ? lf_unmix_share(&c->unmix, &whole->unmix) : LF_E_NOMEM;
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
    lf_crosstalk_finish(&c->matrix);
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
                sqrt(BETWEEN) * 0.5 * (above[lane] + below[lane]);
    }
}

/* Adds up what the eyes at views see at places first..end-1, in n_lanes lanes. */
static void count_seen(const lf_compensate *c, int first, int end, int n_lanes, tally *sums)
{
    for (int p = first | 1; p < end; p += 2) {
        const int dot = c->crosstalk->first[p];
        if (dot == 0 || dot + c->crosstalk->width == c->n_pixels)
            continue; /* part of the spot may be off the print */
        for (int lane = 0; lane < n_lanes; lane++) {
            const double left = fabs(c->unmix.error[(size_t)p * LF_UNMIX_LANES + (size_t)lane]),
                         plain = fabs(c->unmix.plain[(size_t)p * LF_UNMIX_LANES + (size_t)lane]);
            sums->sum += left;
            sums->plain_sum += plain;
            sums->worst = fmax(sums->worst, left);
            sums->plain_worst = fmax(sums->plain_worst, plain);
        }
        sums->n_seen += n_lanes;
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
        all.n_seen += row->n_seen;
        all.n_dots += row->n_dots;
        all.n_clamped += row->n_clamped;
    }
    const double n_seen = all.n_seen > 0 ? (double)all.n_seen : 1.0,
                 n_dots = all.n_dots > 0 ? (double)all.n_dots : 1.0;
    return (lf_print_left){.compensated = true,
                           .own_share = c->own,
                           .own_share_worst = c->own_worst,
                           .ghost_before = all.plain_sum / n_seen,
                           .ghost = all.sum / n_seen,
                           .worst_before = all.plain_worst,
                           .worst = all.worst,
                           .clamped = (double)all.n_clamped / n_dots};
}

/* --------------------------------------------------------------------------- vertical lenses -- */

void lf_compensate_across(lf_compensate *c, int y, const float *samples, float *row)
{
    const lf_unmix_part all = lf_unmix_part_of(&c->unmix, 0, c->n_pixels);
    for (int t = 0; t < c->n_stripes; t++) {
        const float *in =
            samples + 3 * ((size_t)view_of_stripe(c->print, t) * (size_t)c->shape->n_lenses +
                           (size_t)lens_of_stripe(c->print, t));
        for (int i = 0; i < 3; i++)
            c->wanted[(size_t)(2 * t + 1) * LF_UNMIX_LANES + (size_t)i] = pressed(c, in[i]);
    }
    want_between(c, 0, c->n_stripes);
    for (int x = 0; x < c->n_pixels; x++)
        for (int i = 0; i < 3; i++)
            c->pixels[(size_t)x * LF_UNMIX_LANES + (size_t)i] = pressed(c, row[3 * x + i]);
    lf_unmix_light(&c->unmix, &all, c->wanted, c->pixels);
    tally sums = {0};
    count_seen(c, all.first_place, all.end_place, 3, &sums);
    for (int x = 0; x < c->n_pixels; x++)
        count_clamped(c, x, 3, &sums);
    c->tallies[y] = sums;
    for (int x = 0; x < c->n_pixels; x++)
        for (int i = 0; i < 3; i++)
            row[3 * x + i] = printed(c, c->pixels[(size_t)x * LF_UNMIX_LANES + (size_t)i]);
}

/* ------------------------------------------------------------------------- horizontal lenses -- */

/* Fetches the stripes that the rows begin..end-1 need, and makes these rows from them. */
static void fetch_rows(lf_compensate *c, const lf_unmix_part *part)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    int first = part->first_place / 2 - 1, last = (part->end_place - 1) / 2;
    first = first < 0 ? 0 : first;
    for (int y = part->begin; y < part->end; y++) {
        for (int slot = 0; slot < 3; slot++) {
            const int t = stripe_of(c->print, c->mix[y].lens[slot], c->mix[y].view[slot]);
            first = t < first ? t : first;
            last = t > last ? t : last;
        }
    }
    c->first_row = part->begin;
    c->first_stripe = first;
    for (int t = first; t <= last; t++)
        lf_print_source_along(c->source, view_of_stripe(c->print, t), lens_of_stripe(c->print, t),
                              c->lines + (size_t)(t - first) * line);
    for (int y = part->begin; y < part->end; y++) {
        const lf_stripe_mix *mix = &c->mix[y];
        const float *in[3];
        float *out = c->rows + (size_t)(y - part->begin) * line;
        for (int slot = 0; slot < 3; slot++)
            in[slot] =
                c->lines +
                (size_t)(stripe_of(c->print, mix->lens[slot], mix->view[slot]) - first) * line;
        for (size_t i = 0; i < line; i++)
            out[i] =
                mix->weight[0] * in[0][i] + mix->weight[1] * in[1][i] + mix->weight[2] * in[2][i];
    }
}

/* The first place, from one on, whose spot begins in row y or below. */
static int place_in_row(const lf_compensate *c, const lf_unmix_part *part, int y, int from)
{
    while (from < part->end_place && c->crosstalk->first[from] < y)
        from++;
    return from;
}

/* Solves n_lanes neighbouring values of all rows of a part. */
static void solve_columns(lf_compensate *c, const lf_unmix_part *part, size_t at, int n_lanes)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
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
    const int around = AROUND_ROWS + 2 * c->crosstalk->width;
    c->part_begin = y - y % PART_ROWS;
    c->part_end = c->part_begin + PART_ROWS < c->n_pixels ? c->part_begin + PART_ROWS : c->n_pixels;
    const int begin = c->part_begin > around ? c->part_begin - around : 0,
              end = c->part_end + around < c->n_pixels ? c->part_end + around : c->n_pixels;
    const lf_unmix_part part = lf_unmix_part_of(&c->unmix, begin, end);
    fetch_rows(c, &part);
    memset(c->part_tallies, 0, sizeof c->part_tallies);
    for (size_t at = 0; at < line; at += LF_UNMIX_LANES)
        solve_columns(c, &part, at, line - at < LF_UNMIX_LANES ? (int)(line - at) : LF_UNMIX_LANES);
}

void lf_compensate_down(lf_compensate *c, int y, float *row)
{
    const size_t line = 3 * (size_t)c->shape->n_along;
    if (y < c->part_begin || y >= c->part_end)
        make_part(c, y);
    c->tallies[y] = c->part_tallies[y - c->part_begin];
    memcpy(row, c->rows + (size_t)(y - c->first_row) * line, line * sizeof *row);
}
