#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/flip.h"
#include "quilt/print/relief.h"

/* Aspects closer than this are equal: file names round them. */
#define SAME_ASPECT 1e-3

/* ------------------------------------------------------------------------------------ source -- */

/* Sets the strides of a view's samples. */
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

/* The placement of a picture on the raster, in mm. With bleed, a picture without a border inside
 * the trim size covers the whole raster. */
static lf_photo_place lay(const lf_print *print, const lf_print_shape *shape)
{
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print);
    const double width = shape->raster_width * right_mm, height = shape->raster_height * down_mm;
    if (!(print->view_aspect > 0.0))
        return (lf_photo_place){.width = width, .height = height};
    /* A rolled rig's picture is on its side. */
    const double aspect = print->rolled ? 1.0 / print->view_aspect : print->view_aspect;
    /* both sides of the raster are rounded to whole pixels */
    const double rounded_width = fmax(right_mm, 0.5 * (right_mm + aspect * down_mm)),
                 rounded_height = fmax(down_mm, 0.5 * (down_mm + right_mm / aspect));
    const double slack_width = 2 * print->bleed_mm + fmax(rounded_width, SAME_ASPECT * width),
                 slack_height = 2 * print->bleed_mm + fmax(rounded_height, SAME_ASPECT * height);
    return lf_photo_lay(&print->photo, aspect, width, height, slack_width, slack_height);
}

/* A lens or dot at the edge of the raster extends beyond it, but this is no border if the picture
 * also reaches the edge. */
static void no_border(lf_axis_filter *filter)
{
    for (int i = 0; i < filter->n_out; i++)
        filter->inside[i] = 1;
}

static lf_status laid_filters(lf_print_source *source, const lf_print *print,
                              const lf_print_shape *shape, bool backwards)
{
    const double pixel_mm = shape->step_along_mm, pitch_mm = shape->step_across_mm;
    /* a sample of a hexagonal sheet is as wide as its lens, which is two steps */
    const double lens_mm = print->optics.grid == LF_LENS_HEXAGONAL ? 2.0 * pitch_mm : pitch_mm;
    const lf_photo_place *place = &source->place;
    const double across_mm = print->horizontal ? place->height : place->width;
    const double along_mm = print->horizontal ? place->width : place->height;
    const double across_middle = print->horizontal ? place->down : place->right;
    const double along_middle =
        (print->horizontal ? place->right : place->down) * (backwards ? -1.0 : 1.0);
    const double across_scale = source->n_across_in / across_mm,
                 along_scale = source->n_along_in / along_mm;
    const double first_mm = shape->first_across_mm - across_middle;
    const double along_first_mm = shape->first_along_mm * (backwards ? -1.0 : 1.0) - along_middle;
    lf_status status = lf_axis_filter_init(&source->across, source->n_across_in, shape->n_lenses,
                                           (first_mm + 0.5 * across_mm) * across_scale,
                                           pitch_mm * across_scale, lens_mm * across_scale);

    if (status == LF_OK)
        status = lf_axis_filter_init(&source->along, source->n_along_in, shape->n_along,
                                     (along_first_mm + 0.5 * along_mm) * along_scale,
                                     pixel_mm * along_scale * (backwards ? -1.0 : 1.0),
                                     pixel_mm * along_scale);
    if (status == LF_OK && !((print->horizontal ? place->above : place->beside) > 0))
        no_border(&source->across);
    if (status == LF_OK && !((print->horizontal ? place->beside : place->above) > 0))
        no_border(&source->along);
    return status;
}

lf_status lf_print_source_share(lf_print_source *copy)
{
    copy->line = lf_calloc(copy->line_pixels, 3 * sizeof *copy->line);
    return copy->line ? LF_OK : LF_E_NOMEM;
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
    source->print = print;
    source->resampled = views->width != shape->view_width || views->height != shape->view_height;
    set_axes(source, print);
    source->place = lay(print, shape);
    lf_status status = source->resampled ? laid_filters(source, print, shape, backwards)
                                         : identity_filters(source, shape, backwards);

    source->line_pixels = (size_t)(views->width > views->height ? views->width : views->height);
    const lf_status line = lf_print_source_share(source);
    if (status == LF_OK)
        status = line;
    if (status != LF_OK)
        lf_print_source_finish(source);
    return status;
}

/* Dots of the print per pixel of the views, along the lenses. */
static double scale_along(const lf_print *print, const lf_views32 *views,
                          const lf_photo_place *place)
{
    const double dots_mm = lf_print_is_micro(print) ? 1.0 / lf_print_pitch_mm(print)
                                                    : lf_print_dpi_along(print) / 25.4;
    const int n = print->horizontal && !print->rolled ? views->width : views->height;
    return (print->horizontal ? place->width : place->height) * dots_mm / n;
}

void lf_print_note_laid(const lf_print *print, const lf_views32 *views, lf_image_notes *notes)
{
    lf_print_shape shape;
    lf_relief relief;
    if (print->relief && lf_relief_of(print, &relief, NULL) == LF_OK)
        lf_relief_note(&relief, notes);
    lf_print_shape_of(print, &shape);
    if (views->width == shape.view_width && views->height == shape.view_height)
        return;
    const lf_photo_place place = lay(print, &shape);
    const double scale = scale_along(print, views, &place);
    if (place.cut > 0)
        lf_image_note(notes,
                      "%.0f %% of the image (aspect %.4g) is cropped for a print of %g x %g mm "
                      "(photo fit shows it whole)",
                      100 * place.cut, print->view_aspect, print->width_mm, print->height_mm);
    if (place.beside > 0 || place.above > 0)
        lf_image_note(notes,
                      "the image (aspect %.4g) is whole on a print of %g x %g mm, with white "
                      "borders of %.1f mm %s (photo fill crops it)",
                      print->view_aspect, print->width_mm, print->height_mm,
                      place.beside + place.above,
                      place.beside > 0 ? "left and right" : "above and below");
    if (scale > 2 || scale < 0.5)
        lf_image_note(notes, "views of %dx%d pixels are scaled by %.3g along the lenses",
                      views->width, views->height, scale);
}

double lf_print_lenses(const lf_print *print)
{
    lf_print_shape shape;
    lf_print_shape_of(print, &shape);
    const lf_photo_place place = lay(print, &shape);
    return (print->horizontal ? place.height : place.width) * print->lpi / 25.4 *
           lf_print_cos(print);
}

void lf_print_source_finish(lf_print_source *source)
{
    lf_axis_filter_finish(&source->across);
    lf_axis_filter_finish(&source->along);
    lf_free(source->line);
    memset(source, 0, sizeof *source);
}

static float finite_or_zero(float v)
{
    return isfinite(v) ? v : 0.0F;
}

/* Position of a line's samples in a view. */
typedef struct line_place {
    size_t step, tap_step; /* strides from sample to sample, and between its taps */
    int first, n;          /* the samples that are needed */
} line_place;

static void add_floats(const float *in, const line_place *place, float weight, float *line)
{
    for (int s = place->first; s < place->first + place->n; s++)
        for (int c = 0; c < 3; c++)
            line[3 * s + c] += weight * finite_or_zero(in[(size_t)s * place->step + (size_t)c]);
}

static void add_codes(const uint8_t *in, const float *light, const line_place *place, float weight,
                      float *line)
{
    for (int s = place->first; s < place->first + place->n; s++)
        for (int c = 0; c < 3; c++)
            line[3 * s + c] += weight * light[in[(size_t)s * place->step + (size_t)c]];
}

/* Adds a share of one line of a view; each sample is the weighted sum of taps. */
static void add_view(const lf_views32 *views, int view, float share, const line_place *place,
                     const lf_axis_filter *filter, int i, float *line)
{
    const float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;
    for (int t = 0; t < filter->n_taps[i]; t++) {
        size_t at = (size_t)(filter->first[i] + t) * place->tap_step;
        if (views->codes)
            add_codes(lf_views32_codes(views, view, 0) + at, views->light, place, share * weight[t],
                      line);
        else
            add_floats(lf_views32_row(views, view, 0) + at, place, share * weight[t], line);
    }
}

/* Samples of a line. */
typedef struct span {
    int first, n;
} span;

/* The input samples of a part of a filter's output; those of its ends bound all others. */
static span taps_of(const lf_axis_filter *filter, span part)
{
    const int ends[] = {part.first, part.first + part.n - 1};
    const bool rises = filter->first[ends[0]] <= filter->first[ends[1]];
    const int low = ends[!rises], high = ends[rises];
    const int first = filter->first[low];
    return (span){first, filter->first[high] + filter->n_taps[high] - first};
}

/* Gathers a part of a line of what a stripe shows, along both axes. False: it is of one light. */
static bool gather_line(const lf_print_source *source, int stripe, line_place place,
                        const lf_axis_filter *filter, int i, const lf_axis_filter *other, span part,
                        float *out)
{
    const lf_stripe_content content =
        lf_flip_content(source->print, source->views->n_views, stripe);
    if (content.neutral) {
        for (int s = 0; s < 3 * part.n; s++)
            out[s] = content.light;
        return false;
    }
    const span taps = taps_of(other, part);
    place.first = taps.first;
    place.n = taps.n;
    memset(source->line + 3 * (size_t)taps.first, 0, (size_t)taps.n * 3 * sizeof *source->line);
    add_view(source->views, content.image, 1.0F - content.blend, &place, filter, i, source->line);
    if (content.blend > 0.0F)
        add_view(source->views, content.next, content.blend, &place, filter, i, source->line);
    lf_axis_filter_part(other, part.first, part.n, source->line, out);
    lf_tone_linear(source->tone, (size_t)part.n, out, out);
    return true;
}

/* Adds paper white outside the picture. */
static void add_border(const lf_print_source *source, const lf_axis_filter *filter, span part,
                       float inside, float *out)
{
    if (!(source->resampled && (source->place.beside > 0 || source->place.above > 0)))
        return;
    for (int i = 0; i < part.n; i++) {
        const float share = inside * filter->inside[part.first + i];
        for (int c = 0; c < 3; c++)
            out[3 * i + c] = share * out[3 * i + c] + (1.0F - share);
    }
}

void lf_print_source_across(const lf_print_source *source, int i, int along, float *out)
{
    const line_place place = {.step = source->across_step, .tap_step = source->along_step};
    const span all = {0, source->across.n_out};
    if (gather_line(source, i, place, &source->along, along, &source->across, all, out))
        add_border(source, &source->across, all, source->along.inside[along], out);
}

void lf_print_source_part(const lf_print_source *source, int i, int lens, int first, int n,
                          float *out)
{
    const line_place place = {.step = source->along_step, .tap_step = source->across_step};
    const span part = {first, n};
    if (gather_line(source, i, place, &source->across, lens, &source->along, part, out))
        add_border(source, &source->along, part, source->across.inside[lens], out);
}

void lf_print_source_along(const lf_print_source *source, int i, int lens, float *out)
{
    lf_print_source_part(source, i, lens, 0, source->along.n_out, out);
}

/* Adds a part of a sample of a view, by both filters. */
static void add_point(const lf_print_source *source, int view, float part, int across, int along,
                      float sum[3])
{
    const lf_views32 *views = source->views;
    const lf_axis_filter *a = &source->across, *b = &source->along;
    const float *weight_a = a->weight + (size_t)across * (size_t)a->max_taps,
                *weight_b = b->weight + (size_t)along * (size_t)b->max_taps;
    const line_place place = {.step = source->across_step, .n = a->n_taps[across]};
    for (int t = 0; t < b->n_taps[along]; t++) {
        const size_t at = (size_t)(b->first[along] + t) * source->along_step +
                          (size_t)a->first[across] * place.step;
        for (int s = 0; s < place.n; s++) {
            const size_t i = at + (size_t)s * place.step;
            const float weight = part * weight_a[s] * weight_b[t];
            for (int c = 0; c < 3; c++)
                sum[c] +=
                    weight * (views->codes
                                  ? views->light[lf_views32_codes(views, view, 0)[i + (size_t)c]]
                                  : finite_or_zero(lf_views32_row(views, view, 0)[i + (size_t)c]));
        }
    }
}

void lf_print_source_point(const lf_print_source *source, int i, int across, int along, float *out)
{
    float sum[3] = {0.0F, 0.0F, 0.0F};
    const lf_stripe_content content = lf_flip_content(source->print, source->views->n_views, i);
    if (content.neutral) {
        out[0] = out[1] = out[2] = content.light;
        return;
    }
    add_point(source, content.image, 1.0F - content.blend, across, along, sum);
    if (content.blend > 0.0F)
        add_point(source, content.next, content.blend, across, along, sum);
    lf_tone_linear(source->tone, 1, sum, out);
    if (!(source->resampled && (source->place.beside > 0 || source->place.above > 0)))
        return;
    const float share = source->across.inside[across] * source->along.inside[along];
    for (int c = 0; c < 3; c++)
        out[c] = share * out[c] + (1.0F - share);
}
