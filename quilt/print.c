#include "quilt/print.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* ---------------------------------------------------------------------------------------------------- what is asked -- */

static lf_status check_range(const char *name, double value, double low, double high, lf_error *err)
{
    if (isfinite(value) && value >= low && value <= high)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, "print", "%s %g: expected %g to %g", name, value, low, high);
}

static lf_status check_views(const lf_print *print, const char **out_warning, lf_error *err)
{
    const double pixels_per_lens = print->dpi / print->lpi;
    const int most = (int)fmax(floor(pixels_per_lens + 0.5), 1.0);

    if (print->n_views < 1 || print->n_views > most)
        return lf_error_set(err, LF_E_ARG, "print", "%d views: a lens of %g lpi has %.4g pixels at %d dpi, expected 1 to %d",
                            print->n_views, print->lpi, pixels_per_lens, print->dpi, most);
    if (out_warning)
        *out_warning = print->n_views > 1 && print->n_views > 0.8 * pixels_per_lens
                           ? "more than 0.8 dpi/lpi views: neighbouring views ghost; fewer views or a finer raster are cleaner"
                           : NULL;
    return LF_OK;
}

lf_status lf_print_check(const lf_print *print, const char **out_warning, lf_error *err)
{
    const struct {
        const char *name;
        double value, low, high;
    } ranges[] = {
        {"lpi", print->lpi, 5.0, 600.0},
        {"dpi", print->dpi, 50.0, 9600.0},
        {"width in mm", print->width_mm, 1.0, 5000.0},
        {"height in mm", print->height_mm, 1.0, 5000.0},
        {"bleed in mm", print->bleed_mm, 0.0, 100.0},
        {"phase in mm", print->phase_mm, -100.0, 100.0},
        {"aspect of the views", print->view_aspect, 0.0, 1000.0},
    };

    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const lf_status status = check_range(ranges[i].name, ranges[i].value, ranges[i].low, ranges[i].high, err);

        if (status != LF_OK)
            return status;
    }
    if (print->bits != 8 && print->bits != 16)
        return lf_error_set(err, LF_E_ARG, "print", "%d bits: expected 8 or 16", print->bits);
    if (print->stripes != LF_STRIPES_FRACTIONAL && print->stripes != LF_STRIPES_NEAREST)
        return lf_error_set(err, LF_E_ARG, "print", "stripes %d: expected fractional or nearest", (int)print->stripes);
    if (print->compress != LF_COMPRESS_NONE && print->compress != LF_COMPRESS_LZW && print->compress != LF_COMPRESS_DEFLATE)
        return lf_error_set(err, LF_E_ARG, "print", "compression %d: expected none, lzw or deflate", (int)print->compress);
    if (print->rolled && !print->horizontal)
        return lf_error_set(err, LF_E_ARG, "print", "a rolled rig: expected horizontal lenses");
    return check_views(print, out_warning, err);
}

/* ---------------------------------------------------------------------------------------------------------- shape -- */

/* The lenses whose cells overlap the raster: lens k's is [phase + (k - 1/2) p, phase + (k + 1/2) p]. */
static void lenses_of(const lf_print *print, int raster_across, int *out_first, int *out_last)
{
    const double half = 0.5 * raster_across * print->lpi / print->dpi; /* in lenses */
    const double phase = print->phase_mm * print->lpi / 25.4;

    *out_first = (int)floor(-half - phase + 0.5);
    *out_last = (int)ceil(half - phase + 0.5) - 1;
}

void lf_print_shape_of(const lf_print *print, lf_print_shape *out)
{
    const double pixel_mm = 25.4 / print->dpi, pitch_mm = 25.4 / print->lpi;
    int last;

    memset(out, 0, sizeof *out);
    out->raster_width = (int)lround((print->width_mm + 2.0 * print->bleed_mm) / pixel_mm);
    out->raster_height = (int)lround((print->height_mm + 2.0 * print->bleed_mm) / pixel_mm);
    lenses_of(print, print->horizontal ? out->raster_height : out->raster_width, &out->first_lens, &last);
    out->n_lenses = last - out->first_lens + 1;
    out->n_along = print->horizontal ? out->raster_width : out->raster_height;

    const double across_mm = out->n_lenses * pitch_mm, along_mm = out->n_along * pixel_mm;
    const double center_mm = print->phase_mm + 0.5 * (out->first_lens + last) * pitch_mm;
    if (print->horizontal && !print->rolled) {
        out->view_width = out->n_along;
        out->view_height = out->n_lenses;
        out->window_width_mm = along_mm;
        out->window_height_mm = across_mm;
        out->window_center_y_mm = center_mm;
    } else {
        out->view_width = out->n_lenses;
        out->view_height = out->n_along;
        out->window_width_mm = across_mm;
        out->window_height_mm = along_mm;
        out->window_center_x_mm = center_mm;
    }
}

/* ---------------------------------------------------------------------------------------------------- interlacing -- */

typedef struct line_key {
    int view, lens;
} line_key;

/* One print being written. */
typedef struct job {
    const lf_print *print;
    lf_print_shape shape;
    lf_print_source source;
    lf_print_colour *colour;
    lf_print_tiff *tiff;
    lf_stripe_mix *mix;   /* [pixels across the lenses] */
    float *samples;       /* vertical: [n_views][n_lenses][3] of this row; horizontal: [3][n_along][3], the stripes of this row */
    line_key held[3];     /* horizontal: what the three lines of samples hold */
    float *row;           /* [raster_width][3] linear */
    unsigned char *strip; /* device values */
    size_t row_bytes;
} job;

static lf_status job_init(job *j, const lf_views32 *views, const lf_tone *tone)
{
    const lf_print *print = j->print;
    const int across = print->horizontal ? j->shape.raster_height : j->shape.raster_width;
    const size_t lines = print->horizontal ? 3 : (size_t)print->n_views;
    const size_t line = (size_t)(print->horizontal ? j->shape.n_along : j->shape.n_lenses);
    lf_status status = lf_print_source_init(&j->source, print, &j->shape, views, tone);

    if (status != LF_OK)
        return status;
    j->mix = lf_calloc((size_t)across, sizeof *j->mix);
    j->samples = lf_calloc(lines * line, 3 * sizeof *j->samples);
    j->row = lf_calloc((size_t)j->shape.raster_width, 3 * sizeof *j->row);
    j->row_bytes = (size_t)j->shape.raster_width * (size_t)lf_print_colour_channels(j->colour) * (size_t)print->bits / 8;
    j->strip = lf_calloc((size_t)lf_print_tiff_strip_rows(j->tiff), j->row_bytes);
    if (!j->mix || !j->samples || !j->row || !j->strip)
        return LF_E_NOMEM;
    for (int pixel = 0; pixel < across; pixel++)
        lf_stripe_mix_at(print, &j->shape, pixel, &j->mix[pixel]);
    for (int line_index = 0; line_index < 3; line_index++)
        j->held[line_index] = (line_key){-1, -1};
    return LF_OK;
}

static void job_finish(job *j)
{
    lf_print_source_finish(&j->source);
    lf_print_tiff_abandon(j->tiff);
    lf_print_colour_destroy(j->colour);
    lf_free(j->mix);
    lf_free(j->samples);
    lf_free(j->row);
    lf_free(j->strip);
}

/* Adds weighted pixels: out[i] = sum over slots of weight * in. */
static inline void mix_pixel(const lf_stripe_mix *mix, const float *const in[3], float *out)
{
    for (int c = 0; c < 3; c++)
        out[c] = mix->weight[0] * in[0][c] + mix->weight[1] * in[1][c] + mix->weight[2] * in[2][c];
}

static void vertical_row(job *j, int y)
{
    const size_t n_lenses = (size_t)j->shape.n_lenses;

    for (int view = 0; view < j->print->n_views; view++)
        lf_print_source_across(&j->source, view, y, j->samples + (size_t)view * n_lenses * 3);
    for (int x = 0; x < j->shape.raster_width; x++) {
        const lf_stripe_mix *mix = &j->mix[x];
        const float *in[3];

        for (int slot = 0; slot < 3; slot++)
            in[slot] = j->samples + 3 * ((size_t)mix->view[slot] * n_lenses + (size_t)mix->lens[slot]);
        mix_pixel(mix, in, j->row + 3 * (size_t)x);
    }
}

/* The line of one stripe, read once: rows that follow each other share stripes. A line that this row needs is never replaced,
 * since it needs at most three and there are three. */
static const float *stripe_line(job *j, const lf_stripe_mix *mix, int slot)
{
    const size_t line_size = (size_t)j->shape.n_along * 3;
    int free_line = 0;

    for (int line = 0; line < 3; line++) {
        bool needed = false;

        if (j->held[line].view == mix->view[slot] && j->held[line].lens == mix->lens[slot])
            return j->samples + (size_t)line * line_size;
        for (int other = 0; other < 3; other++)
            needed = needed || (j->held[line].view == mix->view[other] && j->held[line].lens == mix->lens[other]);
        if (!needed)
            free_line = line;
    }
    j->held[free_line] = (line_key){mix->view[slot], mix->lens[slot]};
    float *out = j->samples + (size_t)free_line * line_size;
    lf_print_source_along(&j->source, mix->view[slot], mix->lens[slot], out);
    return out;
}

static void horizontal_row(job *j, int y)
{
    const lf_stripe_mix *mix = &j->mix[y];
    const float *line[3];

    for (int slot = 0; slot < 3; slot++)
        line[slot] = stripe_line(j, mix, slot);
    for (size_t x = 0; x < (size_t)j->shape.raster_width; x++) {
        const float *in[3] = {line[0] + 3 * x, line[1] + 3 * x, line[2] + 3 * x};

        mix_pixel(mix, in, j->row + 3 * x);
    }
}

static void mirror_row(float *row, int width)
{
    for (int left = 0, right = width - 1; left < right; left++, right--) {
        float pixel[3];

        memcpy(pixel, row + 3 * (size_t)left, sizeof pixel);
        memcpy(row + 3 * (size_t)left, row + 3 * (size_t)right, sizeof pixel);
        memcpy(row + 3 * (size_t)right, pixel, sizeof pixel);
    }
}

static void write_row(job *j, int y, unsigned char *out)
{
    if (j->print->horizontal)
        horizontal_row(j, y);
    else
        vertical_row(j, y);
    if (j->print->mirror)
        mirror_row(j->row, j->shape.raster_width);
    lf_print_colour_encode(j->colour, (size_t)j->shape.raster_width, j->row, out);
}

static lf_status write_raster(job *j, const lf_print_run *run, lf_error *err)
{
    const int height = j->shape.raster_height, strip_rows = lf_print_tiff_strip_rows(j->tiff);

    for (int y = 0, strip = 0; y < height; y += strip_rows, strip++) {
        const int rows = height - y < strip_rows ? height - y : strip_rows;

        if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, "print", "cancelled");
        for (int r = 0; r < rows; r++)
            write_row(j, y + r, j->strip + (size_t)r * j->row_bytes);
        const lf_status status = lf_print_tiff_strip(j->tiff, strip, j->strip, (size_t)rows * j->row_bytes, err);
        if (status != LF_OK)
            return status;
        if (run->progress)
            run->progress(run->context, (double)(y + rows) / height);
    }
    lf_print_tiff *tiff = j->tiff;
    j->tiff = NULL;
    return lf_print_tiff_close(tiff, err);
}

/* ------------------------------------------------------------------------------------------------------------- all -- */

lf_status lf_print_write_strips(const lf_print *print, const lf_views32 *views, const lf_print_run *run, int rows_per_strip,
                                lf_outfile *tiff, lf_outfile *manifest, lf_error *err)
{
    job j = {.print = print};
    lf_tone *tone = NULL;
    lf_print_facts facts = {.print = print, .shape = &j.shape, .source = &j.source, .run = run};
    lf_status status = lf_print_check(print, &facts.warning, err);

    if (status == LF_OK && (views->n_views < 1 || views->width < 1 || views->height < 1))
        status = lf_error_set(err, LF_E_ARG, "print", "no views");
    if (status == LF_OK)
        status = lf_tone_create(run->exposure, run->tonemap ? run->tonemap : "srgb", &tone, err);
    if (status != LF_OK)
        return status;
    lf_print_shape_of(print, &j.shape);
    status = lf_print_colour_create(print, &j.colour, err);
    if (status == LF_OK)
        status = lf_print_tiff_open(tiff, print, &j.shape, j.colour, rows_per_strip, &j.tiff, err);
    if (status == LF_OK) {
        status = job_init(&j, views, tone);
        if (status != LF_OK)
            lf_error_set(err, status, "print", "out of memory");
    }
    if (status == LF_OK)
        status = write_raster(&j, run, err);
    facts.colour = j.colour;
    if (status == LF_OK)
        status = lf_print_manifest_write(&facts, tiff, manifest, err);
    job_finish(&j);
    lf_tone_destroy(tone);
    return status;
}

lf_status lf_print_write(const lf_print *print, const lf_views32 *views, const lf_print_run *run, lf_outfile *tiff,
                         lf_outfile *manifest, lf_error *err)
{
    return lf_print_write_strips(print, views, run, 0, tiff, manifest, err);
}
