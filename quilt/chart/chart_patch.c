/* The patches between the tags of a chart. */
#include <math.h>
#include <string.h>

#include "quilt/chart/chart.h"
#include "quilt/print/label.h"

#define CODE_MM 6.0
#define PIXEL_MM 5.0
#define DIGIT_MM 8.0
#define PHASE_MM 5.5
#define N_PIXEL_PARTS 8
#define N_PHASES 8
#define N_DIGITS 3

double lf_chart_group_width(lf_chart_group group)
{
    static const double widths[LF_CHART_GROUPS] = {LF_CHART_CODES * CODE_MM,
                                                   N_PIXEL_PARTS * PIXEL_MM, N_DIGITS * DIGIT_MM,
                                                   N_PHASES * PHASE_MM};
    return widths[group];
}

double lf_chart_group_height(const lf_chart *chart)
{
    return chart->strip - 2.0;
}

double lf_chart_code_at(int place, int *out_view, double *out_width)
{
    /* with any fringes, the views seen there less these leave the smallest gaps */
    static const int views[LF_CHART_CODES] = {0, 6, 4, 3, 1, 7, 5, 2};
    *out_view = views[place];
    *out_width = CODE_MM;
    return place * CODE_MM;
}

double lf_chart_pixel_patch_at(int part, double *out_width)
{
    *out_width = PIXEL_MM;
    return part * PIXEL_MM;
}

/* ----------------------------------------------------------------------------------- stripes -- */

/* Fraction of [x0, x1] in the stripe [from, to) of the cells of a pitch; a cell is centred on 0. */
static double covered(double x0, double x1, double pitch, double from, double to)
{
    const double shift = 0.5 * pitch;
    return (lf_chart_stripes_before(x1 + shift, pitch, from, to) -
            lf_chart_stripes_before(x0 + shift, pitch, from, to)) /
           (x1 - x0);
}

/* Stripe of a view: they run from the last view to view 0, left to right. */
static double view_share(const lf_chart_box *box, double pitch, int view, int n_views)
{
    const int stripe = n_views - 1 - view;
    return covered(box->x0, box->x1, pitch, (double)stripe / n_views, (stripe + 1.0) / n_views);
}

/* ------------------------------------------------------------------------------------ groups -- */

static double code_ink(const lf_chart *chart, const lf_chart_box *box, double x, double y)
{
    int view;
    double width;
    (void)y;
    lf_chart_code_at((int)(x / CODE_MM), &view, &width);
    return 1.0 - view_share(box, 25.4 / chart->lpi, view, LF_CHART_CODES);
}

/* Whether a pixel is on an odd place, whatever the parity of the raster's size. */
static bool is_odd(double edge, double pixel)
{
    return fmod(floor(edge / pixel + 0.25) + 65536.0, 2.0) >= 1.0;
}

static double pixel_ink(const lf_chart *chart, const lf_chart_box *box, double x, double y)
{
    const int part = (int)(x / PIXEL_MM);
    const double pitch = 25.4 / chart->lpi, middle = 0.5 * chart->height;
    (void)y;
    if (x - part * PIXEL_MM > 0.9 * PIXEL_MM)
        return 0.0;
    if (part < 2)
        return part == 0 ? is_odd(box->x0, chart->pixel_along)
                         : is_odd(box->y0 - middle, chart->pixel_across);
    if (part >= 6)
        return part - 6;
    const double shift = 0.25 * (part - 2) * pitch - middle;
    return covered(box->y0 + shift, box->y1 + shift, pitch, 0.25, 0.75);
}

/* Each number is drawn in the stripes of its third of the views. */
static double order_ink(const lf_chart *chart, const lf_chart_box *box, double x, double y)
{
    const int place = (int)(x / DIGIT_MM);
    const double height = fmin(7.0, lf_chart_group_height(chart) - 1.0);
    const char text[2] = {(char)('1' + place), '\0'};
    const double left = x - place * DIGIT_MM - 0.5 * (DIGIT_MM - lf_label_width(text, height));
    return lf_label_ink(text, height, left, y - 0.5)
               ? view_share(box, 25.4 / chart->lpi, place, N_DIGITS)
               : 0.0;
}

/* Rows: a step below the middle pitch, the middle, a step above. Columns: eighths of a pitch. */
static double phase_ink(const lf_chart *chart, const lf_chart_box *box, double x, double y)
{
    const int column = (int)(x / PHASE_MM), row = (int)(3.0 * y / lf_chart_group_height(chart));
    const double pitch = 25.4 / (chart->lpi + (row - 1) * chart->step);
    const double shift = pitch * column / N_PHASES;
    if (x - column * PHASE_MM > 0.9 * PHASE_MM ||
        3.0 * y / lf_chart_group_height(chart) - row > 0.9)
        return 0.0;
    return covered(box->x0 - shift, box->x1 - shift, pitch, 0.25, 0.75);
}

double lf_chart_patch_ink(const lf_chart *chart, const lf_chart_box *box)
{
    static double (*const ink[LF_CHART_GROUPS])(const lf_chart *, const lf_chart_box *, double,
                                                double) = {code_ink, pixel_ink, order_ink,
                                                           phase_ink};
    const double x = 0.5 * (box->x0 + box->x1), y = 0.5 * (box->y0 + box->y1);
    for (int g = 0; g < LF_CHART_GROUPS; g++) {
        const lf_chart_place *place = &chart->groups[g];
        if (place->present && x >= place->x && x < place->x + lf_chart_group_width(g) &&
            y >= place->y && y < place->y + lf_chart_group_height(chart))
            return ink[g](chart, box, x - place->x, y - place->y);
    }
    return 0.0;
}
