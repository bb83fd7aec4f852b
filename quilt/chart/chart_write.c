/* The chart's file and manifest. */
#include <math.h>
#include <stdio.h>

#include "quilt/chart/chart.h"
#include "quilt/print/print.h"

typedef struct drawing {
    lf_chart chart;
    int width, height;
    bool turned; /* horizontal lenses: rotated by 90 degrees, the chart's right is the print's lower
                  * end */
} drawing;

static void draw_row(void *context, int y, float *row)
{
    const drawing *d = context;
    const double along = d->chart.pixel_along, across = d->chart.pixel_across;
    for (int x = 0; x < d->width; x++) {
        const double left = (d->turned ? y - 0.5 * d->height : x - 0.5 * d->width) * along;
        const double top = (d->turned ? 0.5 * d->width - x - 1.0 : y - 0.5 * d->height) * across +
                           0.5 * d->chart.height;
        const lf_chart_box box = {left, left + along, top, top + across};
        const float light = (float)(1.0 - lf_chart_ink(&d->chart, &box));
        for (int c = 0; c < 3; c++)
            row[3 * x + c] = light;
    }
}

/* Tags as squares of ink, without their white border. */
static json_t *tag_part(const lf_chart *chart)
{
    json_t *tags = json_array();
    for (int i = 0; tags && i < LF_CHART_TAGS; i++) {
        double x, y;
        if (lf_chart_tag_place(chart, i, &x, &y))
            json_array_append_new(tags,
                                  json_pack("{s:i, s:[f,f], s:f}", "id", chart->first_tag + i,
                                            "left_top_mm", x + chart->cell, y + chart->cell,
                                            "side_mm", (LF_CHART_TAG_CELLS - 2) * chart->cell));
    }
    return tags;
}

static json_t *patch_part(const lf_chart *chart)
{
    static const char *const names[LF_CHART_GROUPS] = {"crosstalk", "pixels", "order", "phases"};
    json_t *patches = json_object();
    for (int g = 0; patches && g < LF_CHART_GROUPS; g++)
        if (chart->groups[g].present)
            json_object_set_new(patches, names[g],
                                json_pack("[f,f,f,f]", chart->groups[g].x, chart->groups[g].y,
                                          lf_chart_group_width((lf_chart_group)g),
                                          lf_chart_group_height(chart)));
    return patches;
}

static json_t *chart_part(const lf_chart *chart)
{
    json_t *bands = json_array();
    for (int band = 0; bands && band < chart->n_bands; band++)
        json_array_append_new(
            bands, json_pack("{s:f, s:f, s:f}", "lpi", lf_chart_lpi(chart, band), "from_mm",
                             chart->top + band * chart->band_height, "to_mm",
                             chart->top + (band + 1 - LF_CHART_GAP) * chart->band_height));
    return json_pack("{s:o, s:f, s:f, s:s, s:o, s:o}", "bands", bands, "grating_mm",
                     2.0 * chart->half_width, "ruler_mm", 2.0 * chart->half_ruler, "tag_family",
                     "tag36h11", "tags", tag_part(chart), "patches_mm", patch_part(chart));
}

lf_status lf_chart_write(const lf_print *print, const lf_print_run *run, lf_outfile *tiff,
                         lf_outfile *manifest, lf_error *err)
{
    drawing d = {.turned = print->horizontal};
    lf_print_shape shape;
    lf_print_colour *colour = NULL;
    lf_image_notes notes = run->notes ? *run->notes : (lf_image_notes){0};
    lf_print_run noted = *run;
    char description[160];
    lf_status status = lf_chart_layout(print, &d.chart, err);
    if (status == LF_OK)
        status = lf_chart_draw_tags(&d.chart, err);
    if (status == LF_OK)
        status = lf_print_colour_create(print, &colour, err);
    if (status != LF_OK)
        return status;
    lf_print_shape_of(print, &shape);
    lf_chart_note_left_out(&d.chart, &notes);
    noted.notes = &notes;
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
                                      .run = &noted,
                                      .chart = chart_part(&d.chart)};
        status = lf_print_manifest_write(&facts, tiff, manifest, err);
    }
    lf_print_colour_destroy(colour);
    return status;
}

void lf_chart_note(const lf_print *print, lf_image_notes *notes)
{
    lf_chart chart;
    if (lf_chart_layout(print, &chart, NULL) == LF_OK)
        lf_chart_note_left_out(&chart, notes);
}
