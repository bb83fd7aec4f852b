/* The tags at the corners of a chart, by the table of libapriltag. */
#include <apriltag/tag36h11.h>
#include <math.h>

#include "quilt/chart/chart.h"

#define MARGIN_MM 1.5

static void take_bits(const apriltag_family_t *family, int number, uint8_t *out)
{
    const uint64_t code = family->codes[number];
    const int n = LF_CHART_TAG_CELLS;
    for (int i = 0; i < n * n; i++) {
        const int x = i % n, y = i / n;
        out[i] = x > 0 && y > 0 && x < n - 1 && y < n - 1;
    }
    for (uint32_t i = 0; i < family->nbits; i++)
        if (code >> (family->nbits - 1 - i) & 1)
            out[(family->bit_y[i] + 1) * (uint32_t)n + family->bit_x[i] + 1] = 0;
}

lf_status lf_chart_draw_tags(lf_chart *chart, lf_error *err)
{
    if (!chart->is_marked)
        return LF_OK;
    apriltag_family_t *family = tag36h11_create();
    if (!family)
        return lf_error_set(err, LF_E_NOMEM, "chart", "out of memory");
    for (int i = 0; i < LF_CHART_TAGS; i++)
        take_bits(family, chart->first_tag + i, chart->tags[i]);
    tag36h11_destroy(family);
    return LF_OK;
}

bool lf_chart_tag_place(const lf_chart *chart, int i, double *out_x, double *out_y)
{
    const int column = i % 3;
    if (!chart->is_marked || (column == 1 && !chart->has_middle_tags))
        return false;
    const double edge = 0.5 * chart->width - MARGIN_MM;
    *out_x = column == 0 ? -edge : column == 1 ? -0.5 * chart->strip : edge - chart->strip;
    *out_y = i < 3 ? chart->top - chart->strip : chart->top + chart->n_bands * chart->band_height;
    return true;
}

double lf_chart_tag_ink(const lf_chart *chart, const lf_chart_box *box)
{
    const double x = 0.5 * (box->x0 + box->x1), y = 0.5 * (box->y0 + box->y1);
    for (int i = 0; i < LF_CHART_TAGS; i++) {
        double left, top;
        if (!lf_chart_tag_place(chart, i, &left, &top))
            continue;
        const double column = floor((x - left) / chart->cell), row = floor((y - top) / chart->cell);
        if (column >= 0 && row >= 0 && column < LF_CHART_TAG_CELLS && row < LF_CHART_TAG_CELLS)
            return chart->tags[i][(int)row * LF_CHART_TAG_CELLS + (int)column];
    }
    return 0.0;
}
