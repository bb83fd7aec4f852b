#include "quilt/print/chart.h"

#include <math.h>
#include <stdio.h>

#include "quilt/print/label.h"
#include "quilt/print/print.h"

#define HEADER_MM 5.0
#define FOOTER_MM 8.0
#define TEXT_MM 2.5
#define MARGIN_MM 1.5
#define LEAST_BAND_MM 2.0
#define LEAST_GRATING_MM 10.0
#define TICK_MM 0.2
#define GAP 0.1 /* fraction of a band */

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
    chart.top = HEADER_MM;
    chart.band_height = (chart.height - HEADER_MM - FOOTER_MM) / (2.0 * steps + 1.0);
    if (chart.band_height < LEAST_BAND_MM)
        return lf_error_set(err, LF_E_ARG, "chart",
                            "%g bands do not fit into %g mm (%g mm each, plus %g mm); use a larger "
                            "print or step, or a smaller range",
                            2.0 * steps + 1.0, chart.height, LEAST_BAND_MM, HEADER_MM + FOOTER_MM);
    chart.n_bands = 2 * (int)steps + 1;
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

/* --------------------------------------------------------------------------------------- ink -- */

/* The ink to the left of x on a grating with a line around 0, half a pitch wide. */
static double ink_before(double x, double pitch)
{
    const double t = x / pitch + 0.25, line = floor(t);
    return pitch * (0.5 * line + fmin(t - line, 0.5));
}

static bool header_ink(const lf_chart *chart, double x, double y)
{
    char text[64];
    if (fabs(y - MARGIN_MM - 0.5 * TEXT_MM) > 0.5 * TEXT_MM)
        return false;
    snprintf(text, sizeof text, "%s dpi 100%%", chart->dpi);
    return lf_label_ink(text, TEXT_MM, x + 0.5 * lf_label_width(text, TEXT_MM), y - MARGIN_MM);
}

/* The ruler: a tick every 10 mm, longer ones at the ends, and its total length. */
static double footer_ink(const lf_chart *chart, double x0, double x1, double y)
{
    const double tick =
        10.0 * round((0.5 * (x0 + x1) - chart->half_ruler) / 10.0) + chart->half_ruler;
    const bool outer = fabs(tick) > chart->half_ruler - 5.0;
    const double covered = fmin(x1, tick + 0.5 * TICK_MM) - fmax(x0, tick - 0.5 * TICK_MM);
    char text[32];
    if (y < (outer ? 2.0 * TEXT_MM : TEXT_MM) && fabs(tick) < chart->half_ruler + 1.0)
        return fmax(covered, 0.0) / (x1 - x0);
    if (fabs(y - 1.5 * TEXT_MM - 1.0) > 0.5 * TEXT_MM)
        return 0.0;
    snprintf(text, sizeof text, "%.0f mm", 2.0 * chart->half_ruler);
    return lf_label_ink(text, TEXT_MM, 0.5 * (x0 + x1) + 0.5 * lf_label_width(text, TEXT_MM),
                        y - TEXT_MM - 1.0);
}

double lf_chart_ink(const lf_chart *chart, double x0, double x1, double y)
{
    const double place = (y - chart->top) / chart->band_height;
    const double bands_end = chart->top + chart->n_bands * chart->band_height;
    char text[32];
    if (place < 0.0)
        return header_ink(chart, 0.5 * (x0 + x1), y);
    if (place >= chart->n_bands)
        return footer_ink(chart, x0, x1, y - bands_end - 1.0);
    const int band = (int)place;
    if (fmax(fabs(x0), fabs(x1)) <= chart->half_width) {
        const double pitch = 25.4 / lf_chart_lpi(chart, band);
        return place - band > 1.0 - GAP
                   ? 0.0
                   : (ink_before(x1, pitch) - ink_before(x0, pitch)) / (x1 - x0);
    }
    const double x = x0 < 0.0 ? 0.5 * (x0 + x1) + 0.5 * chart->width - MARGIN_MM
                              : 0.5 * (x0 + x1) - chart->half_width - MARGIN_MM;
    const double down = (place - band - 0.5 * (1.0 - GAP)) * chart->band_height;
    if (fabs(down) > 0.5 * chart->label_height)
        return 0.0;
    label_of(chart, band, text, sizeof text);
    return lf_label_ink(text, chart->label_height, x, down + 0.5 * chart->label_height);
}

/* -------------------------------------------------------------------------------------- file -- */

typedef struct drawing {
    lf_chart chart;
    int width, height;
    double right, down; /* size of a pixel in mm */
    bool turned; /* horizontal lenses: rotated by 90 degrees, the chart's right is the print's lower
                  * end */
} drawing;

static void draw_row(void *context, int y, float *row)
{
    const drawing *d = context;
    const double pixel = d->turned ? d->down : d->right;
    for (int x = 0; x < d->width; x++) {
        const double left = (d->turned ? y - 0.5 * d->height : x - 0.5 * d->width) * pixel;
        const double down = (d->turned ? (0.5 * d->width - x - 0.5) * d->right
                                       : (y + 0.5 - 0.5 * d->height) * d->down) +
                            0.5 * d->chart.height;
        const float light = (float)(1.0 - lf_chart_ink(&d->chart, left, left + pixel, down));
        for (int c = 0; c < 3; c++)
            row[3 * x + c] = light;
    }
}

static json_t *chart_part(const lf_chart *chart)
{
    json_t *bands = json_array();
    for (int band = 0; bands && band < chart->n_bands; band++)
        json_array_append_new(bands,
                              json_pack("{s:f, s:f, s:f}", "lpi", lf_chart_lpi(chart, band),
                                        "from_mm", chart->top + band * chart->band_height, "to_mm",
                                        chart->top + (band + 1 - GAP) * chart->band_height));
    return json_pack("{s:o, s:f, s:f}", "bands", bands, "grating_mm", 2.0 * chart->half_width,
                     "ruler_mm", 2.0 * chart->half_ruler);
}

lf_status lf_chart_write(const lf_print *print, const lf_print_run *run, lf_outfile *tiff,
                         lf_outfile *manifest, lf_error *err)
{
    drawing d = {.right = 25.4 / print->dpi,
                 .down = 25.4 / lf_print_dpi_down(print),
                 .turned = print->horizontal};
    lf_print_shape shape;
    lf_print_colour *colour = NULL;
    char description[160];
    lf_status status = lf_chart_layout(print, &d.chart, err);
    if (status == LF_OK)
        status = lf_print_colour_create(print, &colour, err);
    if (status != LF_OK)
        return status;
    lf_print_shape_of(print, &shape);
    d.width = shape.raster_width;
    d.height = shape.raster_height;
    snprintf(description, sizeof description,
             "pitch test chart of %.10g to %.10g lenses per inch at %s dpi: print at 100 %%",
             lf_chart_lpi(&d.chart, 0), lf_chart_lpi(&d.chart, d.chart.n_bands - 1), d.chart.dpi);
    const lf_print_page page = {.print = print,
                                .width = d.width,
                                .height = d.height,
                                .description = description,
                                .draw = draw_row,
                                .context = &d};
    status = lf_print_page_write(&page, colour, run, 0, tiff, err);
    if (status == LF_OK) {
        const lf_print_facts facts = {.print = print,
                                      .shape = &shape,
                                      .colour = colour,
                                      .run = run,
                                      .chart = chart_part(&d.chart)};
        status = lf_print_manifest_write(&facts, tiff, manifest, err);
    }
    lf_print_colour_destroy(colour);
    return status;
}
