/* The marks around a print, measured: the alignment strips carry pitch and phase, the tick and the
 * crop marks say where the middle and the trim edges are. Their places are those of
 * quilt/print/marks.h, by arithmetic of its own. */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/proof/check_internal.h"

/* Distances from the edge of the bleed, in mm. */
static const double strip_from = 1.0, strip_to = 5.0;
static const double looks[] = {2.0, 3.0, 4.0, 5.25, 6.5}; /* three on the strip, crop marks, tick */
enum { N_STRIP = 3, CROP = 3, TICK = 4, N_LOOKS = 5 };

#define BLOCK_LENSES 20
#define MAX_BLOCKS 32
#define BLOCK_ERROR_UM 0.1 /* of one block */
#define LEAST_SWING 0.08   /* of the strip's grating; whole ink has 0.22 */
#define MARK_PX 0.25       /* how exact marks must lie */

/* What is read of one end of the lenses. */
typedef struct end_strip {
    float *ink[N_LOOKS]; /* [n] ink 0..1 across the lenses */
    double *profile;     /* [margin] mean ink, from the bleed outwards */
} end_strip;

typedef struct ends {
    int n, margin;              /* pixels across the lenses; of the margin beyond their ends */
    double across_mm, along_mm; /* size of a pixel */
    double edge_mm;             /* from the edge of the bleed to that of its last pixel */
    end_strip side[2];
} ends;

static void finish(ends *e)
{
    for (int side = 0; side < 2; side++) {
        for (int look = 0; look < N_LOOKS; look++)
            lf_free(e->side[side].ink[look]);
        lf_free(e->side[side].profile);
    }
}

static lf_status begin(const lf_check *check, ends *e)
{
    const bool horizontal = check->print.horizontal;
    bool made = true;
    memset(e, 0, sizeof *e);
    e->n = horizontal ? check->shape.raster_height : check->shape.raster_width;
    e->margin = horizontal ? check->shape.margin_px : check->shape.margin_down_px;
    e->across_mm = 25.4 / check->dpi[horizontal ? 1 : 0];
    e->along_mm = 25.4 / check->dpi[horizontal ? 0 : 1];
    const double along = horizontal ? check->print.width_mm : check->print.height_mm;
    const int n_along = horizontal ? check->shape.raster_width : check->shape.raster_height;
    e->edge_mm = 0.5 * n_along * e->along_mm - (0.5 * along + check->print.bleed_mm);
    for (int side = 0; side < 2; side++) {
        for (int look = 0; look < N_LOOKS; look++) {
            e->side[side].ink[look] = lf_calloc((size_t)e->n, sizeof(float));
            made = made && e->side[side].ink[look];
        }
        e->side[side].profile = lf_calloc((size_t)e->margin, sizeof(double));
        made = made && e->side[side].profile;
    }
    return made ? LF_OK : LF_E_NOMEM;
}

static double middle_mm(const ends *e, int j)
{
    return (j + 0.5 - 0.5 * e->n) * e->across_mm;
}

static void see(ends *e, int side, int out, int j, const float light[3])
{
    const float ink = 1.0F - (light[0] + light[1] + light[2]) / 3.0F;
    for (int look = 0; look < N_LOOKS; look++)
        if (out == (int)(looks[look] / e->along_mm))
            e->side[side].ink[look][j] = ink;
    e->side[side].profile[out] += (double)ink / e->n;
}

/* Vertical lenses end above and below. */
static lf_status read_rows(lf_check *check, ends *e, float *row, lf_error *err)
{
    for (int side = 0; side < 2; side++) {
        for (int out = 0; out < e->margin; out++) {
            const int y = side == 0 ? e->margin - 1 - out : check->height - e->margin + out;
            const lf_status status = lf_print_file_row(check->file, y, row, err);
            if (status != LF_OK)
                return status;
            for (int j = 0; j < e->n; j++) {
                const int x = check->print.mirror ? e->n - 1 - j : j;
                see(e, side, out, j, row + 3 * (size_t)(check->shape.margin_px + x));
            }
        }
    }
    return LF_OK;
}

/* Horizontal lenses end left and right. */
static lf_status read_columns(lf_check *check, ends *e, float *row, lf_error *err)
{
    for (int j = 0; j < e->n; j++) {
        const int y = check->shape.margin_down_px + j;
        const lf_status status = lf_print_file_row(check->file, y, row, err);
        if (status != LF_OK)
            return status;
        for (int out = 0; out < e->margin; out++) {
            see(e, 0, out, j, row + 3 * (size_t)(e->margin - 1 - out));
            see(e, 1, out, j, row + 3 * (size_t)(check->width - e->margin + out));
        }
    }
    return LF_OK;
}

/* ------------------------------------------------------------------------------ measurements -- */

/* The place of one dark line per lens, within a block, against the manifest's; *out_swing is how
 * strong the grating is. A Hann window keeps the block's ends from leaking into it. */
static double locked_um(const lf_check *check, const ends *e, const float *ink, int first, int end,
                        double *out_swing)
{
    const double pitch = 25.4 / check->print.lpi, pi = acos(-1.0);
    double complex sum = 0.0;
    double weights = 0.0;
    for (int j = first; j < end; j++) {
        const double x = middle_mm(e, j) - check->print.phase_mm;
        const double window = 1.0 - cos(2.0 * pi * (j + 0.5 - first) / (end - first));
        sum += window * (double)ink[j] * cexp(CMPLX(0.0, -2.0 * pi * x / pitch));
        weights += window;
    }
    *out_swing = cabs(sum) / weights;
    return -1e3 * carg(sum) * pitch / (2.0 * pi);
}

/* The share of a pixel that the strip's lines cover, a quarter of a pitch each. */
static double covered(const lf_check *check, const ends *e, int j, double moved_mm)
{
    const double pitch = 25.4 / check->print.lpi, half = 0.5 * e->across_mm;
    const double x = middle_mm(e, j) - check->print.phase_mm - moved_mm;
    double sum = 0.0;
    for (double lens = round(x / pitch) - 1.0; lens <= round(x / pitch) + 1.0; lens += 1.0)
        sum += fmax(fmin(x + half, (lens + 0.125) * pitch) - fmax(x - half, (lens - 0.125) * pitch),
                    0.0);
    return sum / e->across_mm;
}

/* What remains of a block's ink beyond any multiple of the lines, and any grey, so moved. */
static double remainder_of(const lf_check *check, const ends *e, const float *ink, int first,
                           int end, double moved_mm)
{
    double s = end - first, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (int j = first; j < end; j++) {
        const double x = covered(check, e, j, moved_mm), y = (double)ink[j];
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        syy += y * y;
    }
    const double xx = sxx - sx * sx / s, xy = sxy - sx * sy / s, yy = syy - sy * sy / s;
    return xx > 0.0 ? yy - xy * xy / xx : yy;
}

/* Aliases of the lines' harmonics pull the lock-in's answer by a micrometre; the best fit of the
 * lines themselves, from there on, is exact. */
static double fitted_um(const lf_check *check, const ends *e, const float *ink, int first, int end,
                        double locked)
{
    double at = 1e-3 * locked, step = 0.05 * e->across_mm;
    for (int round_no = 0; round_no < 4; round_no++) {
        const double before = remainder_of(check, e, ink, first, end, at - step),
                     here = remainder_of(check, e, ink, first, end, at),
                     after = remainder_of(check, e, ink, first, end, at + step);
        const double bend = before + after - 2.0 * here;
        if (!(bend > 0.0))
            break;
        at += step * fmax(fmin(0.5 * (before - after) / bend, 1.0), -1.0);
        step *= 0.5;
    }
    return 1e3 * at;
}

/* False: there is no strip. */
static bool measure_strip(lf_check *check, const ends *e, int side)
{
    static const char *const names[2][2] = {{"strip above", "strip below"},
                                            {"strip on the left", "strip on the right"}};
    const double pitch = 25.4 / check->print.lpi;
    const double trim = check->print.horizontal ? check->print.height_mm : check->print.width_mm;
    const int first = (int)ceil((1.5 - 0.5 * trim) / e->across_mm + 0.5 * e->n),
              end = (int)floor((0.5 * trim - 1.5) / e->across_mm + 0.5 * e->n);
    const int n = (int)fmin((end - first) * e->across_mm / (BLOCK_LENSES * pitch), MAX_BLOCKS);
    double x[MAX_BLOCKS * N_STRIP], moved[MAX_BLOCKS * N_STRIP], error[MAX_BLOCKS * N_STRIP];
    double least = INFINITY, before = 0.0;
    int count = 0;
    for (int b = 0; b < n; b++) {
        const int from = first + (int)((int64_t)(end - first) * b / n),
                  to = first + (int)((int64_t)(end - first) * (b + 1) / n);
        for (int look = 0; look < N_STRIP; look++) {
            double swing;
            const float *ink = e->side[side].ink[look];
            const double at =
                fitted_um(check, e, ink, from, to, locked_um(check, e, ink, from, to, &swing));
            least = fmin(least, swing);
            moved[count] = at + 1e3 * pitch * round((before - at) / (1e3 * pitch));
            before = moved[count];
            x[count] = 0.5 * (middle_mm(e, from) + middle_mm(e, to - 1));
            error[count++] = BLOCK_ERROR_UM;
        }
    }
    lf_check_meter meter = {.what = names[check->print.horizontal][side]};
    if (least < LEAST_SWING)
        return false;
    if (lf_check_fit(x, moved, error, count, trim, INFINITY, &meter))
        lf_check_add_meter(check, &meter);
    return true;
}

/* Pixels by which the middle of the ink around a place is off; INFINITY: no ink. */
static double off_px(const ends *e, const float *ink, double place_mm)
{
    const double at = place_mm / e->across_mm + 0.5 * e->n - 0.5;
    const int reach = (int)ceil(0.6 / e->across_mm);
    double sum = 0.0, moment = 0.0;
    for (int j = (int)lround(at) - reach; j <= (int)lround(at) + reach; j++) {
        if (j < 0 || j >= e->n)
            continue;
        sum += (double)ink[j];
        moment += (double)ink[j] * (j - at);
    }
    return sum > 0.5 ? moment / sum : (double)INFINITY;
}

/* Rows by which the strip's ends along the lenses are off. */
static int off_rows(const ends *e, int side)
{
    const double *profile = e->side[side].profile;
    const int from = (int)ceil((strip_from - e->edge_mm) / e->along_mm - 0.5 - 1e-9),
              end = (int)ceil((strip_to - e->edge_mm) / e->along_mm - 0.5 - 1e-9);
    const double half = 0.5 * profile[(from + end) / 2];
    int first = 0, last = end < e->margin ? end : e->margin - 1;
    while (first < e->margin - 1 && profile[first] < half)
        first++;
    while (last > 0 && profile[last] < half)
        last--;
    const int off_first = first - from, off_last = last + 1 - end;
    return abs(off_first) > abs(off_last) ? off_first : off_last;
}

static void judge(lf_check *check, const ends *e)
{
    const double trim = check->print.horizontal ? check->print.height_mm : check->print.width_mm;
    const char *limit = "alignment strips, tick and crop marks within 0.25 pixels";
    static const char remedy[] =
        "Write the print again; let no other program crop, move or redraw it.";
    double worst = 0.0;
    int rows = 0;
    for (int side = 0; side < 2; side++) {
        const end_strip *at = &e->side[side];
        if (!measure_strip(check, e, side)) {
            lf_check_say(check, CHECK_EDGES, LF_CHECK_FAIL, limit, remedy,
                         "there is no alignment strip at the %s end of the lenses",
                         side == 0 ? "first" : "other");
            return;
        }
        if (fabs(check->print.phase_mm) < 0.5 * trim)
            worst = fmax(worst, fabs(off_px(e, at->ink[TICK], check->print.phase_mm)));
        if (check->print.bleed_mm > 0.7) { /* the whole width of the crop marks is in the line */
            worst = fmax(worst, fabs(off_px(e, at->ink[CROP], -0.5 * trim)));
            worst = fmax(worst, fabs(off_px(e, at->ink[CROP], 0.5 * trim)));
        }
        rows = abs(off_rows(e, side)) > abs(rows) ? off_rows(e, side) : rows;
    }
    if (worst <= MARK_PX && rows == 0)
        lf_check_say(check, CHECK_EDGES, LF_CHECK_PASS, limit, NULL,
                     "marks are off by at most %.3f pixels", worst);
    else
        lf_check_say(check, CHECK_EDGES, LF_CHECK_FAIL, limit, remedy,
                     "marks are off by %.2f pixels across the lenses and %d along them", worst,
                     rows);
}

lf_status lf_check_marks(lf_check *check, lf_error *err)
{
    ends e;
    if (!check->fits || check->is_chart || !check->print.marks || !check->plain)
        return LF_OK;
    lf_status status = begin(check, &e);
    float *row = status == LF_OK ? lf_calloc((size_t)check->width, 3 * sizeof *row) : NULL;
    if (!row) {
        finish(&e);
        return lf_error_set(err, LF_E_NOMEM, check->path, "out of memory");
    }
    lf_error trouble = {0};
    status = check->print.horizontal ? read_columns(check, &e, row, &trouble)
                                     : read_rows(check, &e, row, &trouble);
    if (status == LF_OK) {
        judge(check, &e);
    } else {
        snprintf(check->trouble, sizeof check->trouble, "%s", trouble.what);
        check->fits = false;
    }
    lf_free(row);
    finish(&e);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- bleed -- */

static bool is_paper(const float *light)
{
    return fminf(light[0], fminf(light[1], light[2])) > 0.99F;
}

/* Counts paper white in the bleed of a row, left and right, and in as wide a band inside the trim
 * edges. */
static void count_row(const lf_check *check, const float *row, int bleed, int counts[2])
{
    const int width = check->shape.raster_width, margin = check->shape.margin_px;
    for (int x = 0; x < 2 * bleed && x < width; x++) {
        counts[x >= bleed] += is_paper(row + 3 * (size_t)(margin + x));
        counts[x >= bleed] += is_paper(row + 3 * (size_t)(margin + width - 1 - x));
    }
}

lf_status lf_check_bleed(lf_check *check, lf_error *err)
{
    static const char limit[] = "the picture goes on into the bleed";
    const int bleed = (int)(check->print.bleed_mm * check->dpi[0] / 25.4);
    int counts[2] = {0, 0};
    if (!check->fits || check->is_chart || check->laid || bleed < 1 ||
        4 * bleed > check->shape.raster_width)
        return LF_OK;
    float *row = lf_calloc((size_t)check->width, 3 * sizeof *row);
    const int n = 16;
    lf_status status = row ? LF_OK : lf_error_set(err, LF_E_NOMEM, check->path, "out of memory");
    for (int i = 0; i < n && status == LF_OK; i++) {
        lf_error trouble = {0};
        const int y = check->shape.margin_down_px +
                      (int)((2 * (int64_t)i + 1) * check->shape.raster_height / (2 * n));
        if (lf_print_file_row(check->file, y, row, &trouble) != LF_OK) {
            snprintf(check->trouble, sizeof check->trouble, "%s", trouble.what);
            check->fits = false;
            break;
        }
        count_row(check, row, bleed, counts);
    }
    lf_free(row);
    if (status != LF_OK || !check->fits)
        return status;
    const bool blank = counts[0] == 2 * n * bleed && counts[1] < counts[0] / 2;
    if (blank || check->report->points[CHECK_EDGES].result == LF_CHECK_NONE)
        lf_check_say(check, CHECK_EDGES, blank ? LF_CHECK_FAIL : LF_CHECK_PASS, limit,
                     "Write the print again with its bleed; do not add a white border.",
                     blank ? "the bleed of %g mm is blank" : "the bleed of %g mm is filled",
                     check->print.bleed_mm);
    return LF_OK;
}
