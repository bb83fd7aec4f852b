#include "quilt/chart/chart.h"

#include <math.h>
#include <stdio.h>

#include "quilt/print/label.h"
#include "quilt/print/print.h"

#define HEADER_MM 5.0
#define FOOTER_MM 8.0
#define TEXT_MM 2.5
#define MARGIN_MM 1.5
#define LEAST_BAND_MM 2.0
#define LEAST_MARKED_BAND_MM 3.0
#define LEAST_GRATING_MM 10.0
#define TICK_MM 0.2
#define SIDE_TICK_MM 0.8
/* A cell of a tag covers several lenses, each of which shows one column of it. */
#define CELL_MM 1.2
#define CELL_LENSES 3.0
#define BETWEEN_MM 1.0
#define N_CHARTS 97 /* different first tags, of which 6 each fit into the family's 587 */

/* ------------------------------------------------------------------------------------ layout -- */

static lf_status check(const lf_print *print, lf_error *err)
{
    const lf_status status = lf_param_check(lf_print_params, print, "chart", err);
    if (status != LF_OK)
        return status;
    if (print->chart_range == 0.0 || print->chart_step == 0.0)
        return lf_error_set(err, LF_E_ARG, "chart", "a chart needs range and step (lpi)");
    if (!(print->chart_step > 0.0 && print->chart_step <= print->chart_range))
        return lf_error_set(err, LF_E_ARG, "chart",
                            "step %g; expected above 0 and at most the range, %g",
                            print->chart_step, print->chart_range);
    if (print->lpi - print->chart_range < 5.0)
        return lf_error_set(err, LF_E_ARG, "chart",
                            "range %g is too large; expected pitches of at least 5 lpi",
                            print->chart_range);
    if (lf_print_dpi_across(print) < 2.0 * (print->lpi + print->chart_range))
        return lf_error_set(err, LF_E_ARG, "chart",
                            "%g lpi at %.10g dpi has too few pixels; expected at least 2 per line",
                            print->lpi + print->chart_range, lf_print_dpi_across(print));
    if (print->n_views > 0 || print->bleed_mm != 0.0 || print->phase_mm != 0.0 || print->reverse ||
        print->marks || print->stripes != LF_STRIPES_FRACTIONAL)
        return lf_error_set(
            err, LF_E_ARG, "chart",
            "a chart cannot be combined with views, bleed, phase, stripes, reverse or marks");
    if (print->optics.slant != 0.0)
        return lf_error_set(err, LF_E_ARG, "chart",
                            "is for straight lenses, but the sheet leans by %.6g degrees; "
                            "expected a slant of 0",
                            print->optics.slant);
    const lf_print_sheet *sheet = &print->sheet;
    if (sheet->columns > 1 || sheet->rows > 1 || sheet->paper_width_mm > 0.0 || sheet->label ||
        sheet->gutter_mm != 0.0 || sheet->guard > 0 || sheet->morph > 0)
        return lf_error_set(
            err, LF_E_ARG, "chart",
            "a chart cannot be combined with copies, gutter, paper, label, guard or morph");
    return LF_OK;
}

/* The number of decimals needed to write every pitch. */
static int decimals_of(const lf_print *print)
{
    int n = 0;
    for (double scale = 1.0; n < 5; n++, scale *= 10.0)
        if (fabs(remainder(print->lpi * scale, 1.0)) < 1e-6 &&
            fabs(remainder(print->chart_step * scale, 1.0)) < 1e-6)
            break;
    return n;
}

static void label_of(const lf_chart *chart, int band, char *buf, size_t size)
{
    snprintf(buf, size, "%.*f", chart->decimals, lf_chart_lpi(chart, band));
}

/* Different charts have different tags, so that a photo of another one is found out. */
static int first_tag(const lf_print *print)
{
    char text[160];
    uint32_t hash = 2166136261u;
    snprintf(text, sizeof text, "%.9g %.9g %.9g %.9g %.9g %d", print->lpi, print->chart_range,
             print->chart_step, print->width_mm, print->height_mm, print->horizontal);
    for (const char *c = text; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 16777619u;
    return LF_CHART_TAGS * (int)((hash >> 8) % N_CHARTS);
}

/* Puts every group of patches into the first gap between tags that has room for it. */
static void place_groups(lf_chart *chart)
{
    const double outer = 0.5 * chart->width - MARGIN_MM - chart->strip - BETWEEN_MM,
                 inner = chart->has_middle_tags ? 0.5 * chart->strip + BETWEEN_MM : 0.0;
    const double below = chart->top + chart->n_bands * chart->band_height;
    double from[4] = {-outer, inner, -outer, inner};
    const double to[4] = {-inner, outer, -inner, outer};
    for (int g = 0; g < LF_CHART_GROUPS; g++)
        for (int gap = 0; gap < 4 && !chart->groups[g].present; gap++) {
            const double width = lf_chart_group_width((lf_chart_group)g);
            if (to[gap] - from[gap] < width)
                continue;
            chart->groups[g] = (lf_chart_place){
                true, from[gap], (gap < 2 ? chart->top - chart->strip : below) + BETWEEN_MM};
            from[gap] += width + BETWEEN_MM;
        }
}

/* Strips with tags and patches, if the bands stay high enough. */
static void place_marks(lf_chart *chart, const lf_print *print)
{
    const double cell = fmax(CELL_MM, CELL_LENSES * 25.4 / chart->lpi),
                 strip = LF_CHART_TAG_CELLS * cell;
    const double band = chart->band_height - 2.0 * strip / chart->n_bands;
    if (band < LEAST_MARKED_BAND_MM || chart->width < 2.0 * (MARGIN_MM + strip) + strip)
        return;
    chart->is_marked = true;
    chart->cell = cell;
    chart->strip = strip;
    chart->band_height = band;
    chart->top += strip;
    chart->first_tag = first_tag(print);
    chart->has_middle_tags =
        chart->width >= 2.0 * MARGIN_MM + 3.0 * strip +
                            2.0 * (lf_chart_group_width(LF_CHART_CODE_PATCHES) + 2.0 * BETWEEN_MM);
    place_groups(chart);
}

lf_status lf_chart_layout(const lf_print *print, lf_chart *out, lf_error *err)
{
    const lf_status status = check(print, err);
    const double steps = floor(print->chart_range / print->chart_step + 1e-6);
    lf_chart chart = {.lpi = print->lpi, .step = print->chart_step};
    char widest[32];
    if (status != LF_OK)
        return status;
    lf_print_dpi_text(print, chart.dpi, sizeof chart.dpi);
    chart.width = print->horizontal ? print->height_mm : print->width_mm;
    chart.height = print->horizontal ? print->width_mm : print->height_mm;
    chart.pixel_along = 25.4 / lf_print_dpi_across(print);
    chart.pixel_across = 25.4 / lf_print_dpi_along(print);
    chart.top = HEADER_MM;
    chart.band_height = (chart.height - HEADER_MM - FOOTER_MM) / (2.0 * steps + 1.0);
    if (chart.band_height < LEAST_BAND_MM)
        return lf_error_set(err, LF_E_ARG, "chart",
                            "%g bands do not fit into %g mm (%g mm each, plus %g mm); use a larger "
                            "print or step, or a smaller range",
                            2.0 * steps + 1.0, chart.height, LEAST_BAND_MM, HEADER_MM + FOOTER_MM);
    chart.n_bands = 2 * (int)steps + 1;
    place_marks(&chart, print);
    chart.decimals = decimals_of(print);
    chart.label_height = fmin(TEXT_MM, 0.7 * chart.band_height);
    label_of(&chart, chart.n_bands - 1, widest, sizeof widest);
    chart.half_width =
        0.5 * chart.width - 2.0 * MARGIN_MM - lf_label_width(widest, chart.label_height);
    chart.half_ruler = 5.0 * floor(fmin(chart.width - 2.0 * MARGIN_MM, 100.0) / 10.0);
    if (2.0 * chart.half_width < LEAST_GRATING_MM)
        return lf_error_set(err, LF_E_ARG, "chart",
                            "the print has %g mm along the bands; expected at least %.3g mm",
                            chart.width, chart.width - 2.0 * chart.half_width + LEAST_GRATING_MM);
    *out = chart;
    return LF_OK;
}

lf_status lf_chart_check(const lf_print *print, lf_error *err)
{
    lf_chart chart;
    return lf_chart_layout(print, &chart, err);
}

double lf_chart_lpi(const lf_chart *chart, int band)
{
    const int from_middle = band - chart->n_bands / 2;
    return chart->lpi + from_middle * chart->step;
}

void lf_chart_note_left_out(const lf_chart *chart, lf_image_notes *notes)
{
    static const char *const names[LF_CHART_GROUPS] = {
        "patches for crosstalk", "patches of single pixels", "order numbers", "phase patches"};
    if (!chart->is_marked) {
        lf_image_note(notes, "the chart has no room for the marks that --read-chart needs; use a "
                             "larger print or fewer bands");
        return;
    }
    for (int g = 0; g < LF_CHART_GROUPS; g++)
        if (!chart->groups[g].present)
            lf_image_note(notes, "the chart has no room for its %s; use a wider print", names[g]);
}

/* --------------------------------------------------------------------------------------- ink -- */

double lf_chart_stripes_before(double x, double pitch, double from, double to)
{
    const double t = x / pitch, cell = floor(t);
    return pitch * (cell * (to - from) + fmin(fmax(t - cell - from, 0.0), to - from));
}

/* A grating with a line around 0, half a pitch wide. */
static double grating_ink(const lf_chart_box *box, double pitch)
{
    const double shift = 0.25 * pitch;
    return (lf_chart_stripes_before(box->x1 + shift, pitch, 0.0, 0.5) -
            lf_chart_stripes_before(box->x0 + shift, pitch, 0.0, 0.5)) /
           (box->x1 - box->x0);
}

static bool header_ink(const lf_chart *chart, double x, double y)
{
    char text[64];
    if (fabs(y - MARGIN_MM - 0.5 * TEXT_MM) > 0.5 * TEXT_MM)
        return false;
    snprintf(text, sizeof text, "%s dpi 100%%", chart->dpi);
    return lf_label_ink(text, TEXT_MM, x + 0.5 * lf_label_width(text, TEXT_MM), y - MARGIN_MM);
}

/* Coverage of [x0, x1] by the tick of a ruler that is nearest to it. */
static double tick_ink(double x0, double x1, double half_ruler, double *out_tick)
{
    const double tick = 10.0 * round((0.5 * (x0 + x1) - half_ruler) / 10.0) + half_ruler;
    const double covered = fmin(x1, tick + 0.5 * TICK_MM) - fmax(x0, tick - 0.5 * TICK_MM);
    *out_tick = tick;
    return fabs(tick) < half_ruler + 1.0 ? fmax(covered, 0.0) / (x1 - x0) : 0.0;
}

/* The ruler: a tick every 10 mm, longer ones at the ends, and its total length. */
static double footer_ink(const lf_chart *chart, double x0, double x1, double y)
{
    double tick;
    const double ink = tick_ink(x0, x1, chart->half_ruler, &tick);
    const bool outer = fabs(tick) > chart->half_ruler - 5.0;
    char text[32];
    if (y < (outer ? 2.0 * TEXT_MM : TEXT_MM) && fabs(tick) < chart->half_ruler + 1.0)
        return ink;
    if (fabs(y - 1.5 * TEXT_MM - 1.0) > 0.5 * TEXT_MM)
        return 0.0;
    snprintf(text, sizeof text, "%.0f mm", 2.0 * chart->half_ruler);
    return lf_label_ink(text, TEXT_MM, 0.5 * (x0 + x1) + 0.5 * lf_label_width(text, TEXT_MM),
                        y - TEXT_MM - 1.0);
}

/* The ruler down the left edge, as long as the other one if there is room, about the middle. */
static double side_ink(const lf_chart *chart, const lf_chart_box *box)
{
    double tick;
    const double half = fmin(chart->half_ruler, 5.0 * floor((chart->height - 4.0) / 10.0));
    const double middle = 0.5 * chart->height;
    return tick_ink(box->y0 - middle, box->y1 - middle, half, &tick);
}

static double band_ink(const lf_chart *chart, const lf_chart_box *box, double place)
{
    const double x0 = box->x0, x1 = box->x1;
    const int band = (int)place;
    char text[32];
    if (fmax(fabs(x0), fabs(x1)) <= chart->half_width)
        return place - band > 1.0 - LF_CHART_GAP
                   ? 0.0
                   : grating_ink(box, 25.4 / lf_chart_lpi(chart, band));
    const double x = x0 < 0.0 ? 0.5 * (x0 + x1) + 0.5 * chart->width - MARGIN_MM
                              : 0.5 * (x0 + x1) - chart->half_width - MARGIN_MM;
    const double down = (place - band - 0.5 * (1.0 - LF_CHART_GAP)) * chart->band_height;
    if (fabs(down) > 0.5 * chart->label_height)
        return 0.0;
    label_of(chart, band, text, sizeof text);
    return lf_label_ink(text, chart->label_height, x, down + 0.5 * chart->label_height);
}

double lf_chart_ink(const lf_chart *chart, const lf_chart_box *box)
{
    const double y = 0.5 * (box->y0 + box->y1);
    const double place = (y - chart->top) / chart->band_height;
    const double bands_end = chart->top + chart->n_bands * chart->band_height;
    if (chart->is_marked && box->x1 < SIDE_TICK_MM - 0.5 * chart->width)
        return side_ink(chart, box);
    if (place >= 0.0 && place < chart->n_bands)
        return band_ink(chart, box, place);
    if (chart->is_marked && y >= chart->top - chart->strip && y < bands_end + chart->strip)
        return fmax(lf_chart_tag_ink(chart, box), lf_chart_patch_ink(chart, box));
    return place < 0.0 ? header_ink(chart, 0.5 * (box->x0 + box->x1), y)
                       : footer_ink(chart, box->x0, box->x1, y - bands_end - chart->strip - 1.0);
}
