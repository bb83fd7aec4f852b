#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/print.h"

/* ------------------------------------------------------------------------------- axis filter -- */

/* Taps of the interval [low, high] by area; outside the source its edge sample counts. */
static void area_taps(lf_axis_filter *filter, int n_in, int i, double low, double high)
{
    low = fmin(fmax(low, 0.0), n_in - 1e-6);
    high = fmin(fmax(high, low + 1e-6), (double)n_in);
    const int first = (int)low;
    const int last = (int)ceil(high) - 1;
    float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;

    filter->first[i] = first;
    filter->n_taps[i] = last - first + 1;
    for (int t = 0; t < filter->n_taps[i]; t++) {
        const double s = first + t;
        weight[t] = (float)((fmin(high, s + 1.0) - fmax(low, s)) / (high - low));
    }
}

static void linear_taps(lf_axis_filter *filter, int n_in, int i, double middle)
{
    const double s = fmin(fmax(middle - 0.5, 0.0), n_in - 1.0);
    const int first = (int)s;
    const double fraction = s - first;
    float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;
    filter->first[i] = first;
    filter->n_taps[i] = fraction > 0.0 ? 2 : 1;
    weight[0] = (float)(1.0 - fraction);
    weight[1] = (float)fraction;
}

lf_status lf_axis_filter_init(lf_axis_filter *filter, int n_in, int n_out, double start,
                              double step, double footprint)
{
    const int max_taps = footprint > 1.0 ? (int)fmin(ceil(footprint) + 1.0, n_in) : 2;
    memset(filter, 0, sizeof *filter);
    filter->n_out = n_out;
    filter->max_taps = max_taps;
    filter->first = lf_calloc((size_t)n_out, sizeof *filter->first);
    filter->n_taps = lf_calloc((size_t)n_out, sizeof *filter->n_taps);
    filter->weight = lf_calloc((size_t)n_out, (size_t)max_taps * sizeof *filter->weight);
    if (!filter->first || !filter->n_taps || !filter->weight) {
        lf_axis_filter_finish(filter);
        return LF_E_NOMEM;
    }
    for (int i = 0; i < n_out; i++) {
        const double middle = start + i * step;
        if (footprint > 1.0)
            area_taps(filter, n_in, i, middle - 0.5 * footprint, middle + 0.5 * footprint);
        else
            linear_taps(filter, n_in, i, middle);
    }
    return LF_OK;
}

void lf_axis_filter_finish(lf_axis_filter *filter)
{
    lf_free(filter->first);
    lf_free(filter->n_taps);
    lf_free(filter->weight);
    memset(filter, 0, sizeof *filter);
}

/* ------------------------------------------------------------------------------------ source -- */

/* Which way the samples of a view lie in memory. */
static void set_axes(lf_print_source *source, const lf_print *print)
{
    const lf_views32 *views = source->views;
    if (print->horizontal && !print->rolled) {
        source->across_step = views->row_stride;
        source->along_step = 3;
        source->n_across_in = views->height;
        source->n_along_in = views->width;
    } else {
        source->across_step = 3;
        source->along_step = views->row_stride;
        source->n_across_in = views->width;
        source->n_along_in = views->height;
    }
}

static lf_status identity_filters(lf_print_source *source, const lf_print_shape *shape,
                                  bool backwards)
{
    const double along_start = backwards ? shape->n_along - 0.5 : 0.5;
    lf_status status =
        lf_axis_filter_init(&source->across, shape->n_lenses, shape->n_lenses, 0.5, 1.0, 1.0);
    if (status == LF_OK)
        status = lf_axis_filter_init(&source->along, shape->n_along, shape->n_along, along_start,
                                     backwards ? -1.0 : 1.0, 1.0);
    return status;
}

/* The picture is laid over the raster: scaled to cover it with its aspect kept, or stretched over
 * it. */
static lf_status covering_filters(lf_print_source *source, const lf_print *print,
                                  const lf_print_shape *shape, bool backwards)
{
    const double pixel_mm = 25.4 / lf_print_dpi_along(print), pitch_mm = 25.4 / print->lpi;
    double picture_width = shape->raster_width * (25.4 / print->dpi),
           picture_height = shape->raster_height * (25.4 / lf_print_dpi_down(print));
    if (print->view_aspect > 0.0) {
        /* A rolled rig's picture lies on its side. */
        const double aspect = print->rolled ? 1.0 / print->view_aspect : print->view_aspect;
        picture_width = fmax(picture_width, picture_height * aspect);
        picture_height = picture_width / aspect;
    }
    const double across_mm = print->horizontal ? picture_height : picture_width;
    const double along_mm = print->horizontal ? picture_width : picture_height;
    const double across_scale = source->n_across_in / across_mm,
                 along_scale = source->n_along_in / along_mm;
    const double first_mm = print->phase_mm + shape->first_lens * pitch_mm;
    const double along_first_mm =
        (0.5 - 0.5 * shape->n_along) * pixel_mm * (backwards ? -1.0 : 1.0);
    lf_status status = lf_axis_filter_init(&source->across, source->n_across_in, shape->n_lenses,
                                           (first_mm + 0.5 * across_mm) * across_scale,
                                           pitch_mm * across_scale, pitch_mm * across_scale);

    if (status == LF_OK)
        status = lf_axis_filter_init(&source->along, source->n_along_in, shape->n_along,
                                     (along_first_mm + 0.5 * along_mm) * along_scale,
                                     pixel_mm * along_scale * (backwards ? -1.0 : 1.0),
                                     pixel_mm * along_scale);
    return status;
}

lf_status lf_print_source_init(lf_print_source *source, const lf_print *print,
                               const lf_print_shape *shape, const lf_views32 *views,
                               const lf_tone *tone)
{
    /* the rolled picture's rows run from right to left */
    const bool backwards = print->horizontal && print->rolled;
    memset(source, 0, sizeof *source);
    source->views = views;
    source->tone = tone;
    source->n_stripe_views = print->n_views;
    source->resampled = views->width != shape->view_width || views->height != shape->view_height;
    set_axes(source, print);
    const size_t longest = (size_t)(views->width > views->height ? views->width : views->height);
    lf_status status = source->resampled ? covering_filters(source, print, shape, backwards)
                                         : identity_filters(source, shape, backwards);

    source->line = lf_calloc(longest, 3 * sizeof *source->line);
    if (status == LF_OK && !source->line)
        status = LF_E_NOMEM;
    if (status != LF_OK)
        lf_print_source_finish(source);
    return status;
}

void lf_print_source_finish(lf_print_source *source)
{
    lf_axis_filter_finish(&source->across);
    lf_axis_filter_finish(&source->along);
    lf_free(source->line);
    memset(source, 0, sizeof *source);
}

int lf_print_source_view(const lf_print_source *source, int i)
{
    return (int)(((2 * (int64_t)i + 1) * source->views->n_views) /
                 (2 * (int64_t)source->n_stripe_views));
}

static float finite_or_zero(float v)
{
    return isfinite(v) ? v : 0.0F;
}

/* Where the samples of a line lie in a view. */
typedef struct line_place {
    size_t step, tap_step; /* from sample to sample, and to those that a sample is mixed of */
    int n;
} line_place;

static void add_floats(const float *in, const line_place *place, float weight, float *line)
{
    for (int s = 0; s < place->n; s++)
        for (int c = 0; c < 3; c++)
            line[3 * s + c] += weight * finite_or_zero(in[(size_t)s * place->step + (size_t)c]);
}

static void add_codes(const uint8_t *in, const float *light, const line_place *place, float weight,
                      float *line)
{
    for (int s = 0; s < place->n; s++)
        for (int c = 0; c < 3; c++)
            line[3 * s + c] += weight * light[in[(size_t)s * place->step + (size_t)c]];
}

/* One line of a view: samples, each the weighted mix of others. */
static void gather_line(const lf_views32 *views, int view, const line_place *place,
                        const lf_axis_filter *filter, int i, float *line)
{
    const float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;
    memset(line, 0, (size_t)place->n * 3 * sizeof *line);
    for (int t = 0; t < filter->n_taps[i]; t++) {
        size_t at = (size_t)(filter->first[i] + t) * place->tap_step;
        if (views->codes)
            add_codes(lf_views32_codes(views, view, 0) + at, views->light, place, weight[t], line);
        else
            add_floats(lf_views32_row(views, view, 0) + at, place, weight[t], line);
    }
}

static void filter_line(const lf_axis_filter *filter, const float *line, float *out)
{
    for (int i = 0; i < filter->n_out; i++) {
        const float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;
        const float *in = line + 3 * (size_t)filter->first[i];
        float sum[3] = {0.0F, 0.0F, 0.0F};
        for (int t = 0; t < filter->n_taps[i]; t++)
            for (int c = 0; c < 3; c++)
                sum[c] += weight[t] * in[3 * t + c];
        memcpy(out + 3 * (size_t)i, sum, sizeof sum);
    }
}

void lf_print_source_across(const lf_print_source *source, int i, int along, float *out)
{
    const line_place place = {source->across_step, source->along_step, source->n_across_in};
    gather_line(source->views, lf_print_source_view(source, i), &place, &source->along, along,
                source->line);
    filter_line(&source->across, source->line, out);
    lf_tone_linear(source->tone, (size_t)source->across.n_out, out, out);
}

void lf_print_source_along(const lf_print_source *source, int i, int lens, float *out)
{
    const line_place place = {source->along_step, source->across_step, source->n_along_in};
    gather_line(source->views, lf_print_source_view(source, i), &place, &source->across, lens,
                source->line);
    filter_line(&source->along, source->line, out);
    lf_tone_linear(source->tone, (size_t)source->along.n_out, out, out);
}
