#include "quilt/print/print.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/marks.h"

/* ----------------------------------------------------------------------------- what is asked -- */

char *lf_print_dpi_text(const lf_print *print, char *buf, size_t size)
{
    const double down = lf_print_dpi_down(print);
    snprintf(buf, size, down == print->dpi ? "%.10g" : "%.10gx%.10g", print->dpi, down);
    return buf;
}

/* With more views, stripes are so narrow that neighbouring views ghost. */
#define VIEWS_A_PIXEL 0.8

static lf_status check_views(const lf_print *print, const char **out_warning, lf_error *err)
{
    const double pixels_per_lens = lf_print_dpi_across(print) / print->lpi;
    const int most = (int)fmax(floor(pixels_per_lens + 0.5), 1.0);
    if (print->n_views < 1 || print->n_views > most)
        return lf_error_set(err, LF_E_ARG, "print",
                            "%d views are not possible: a lens of %g lpi has %.4g pixels at %.10g "
                            "dpi; expected 1 to %d views",
                            print->n_views, print->lpi, pixels_per_lens, lf_print_dpi_across(print),
                            most);
    if (out_warning)
        *out_warning = print->n_views > 2 && print->n_views > VIEWS_A_PIXEL * pixels_per_lens + 1e-9
                           ? "with more than 0.8 dpi/lpi views, neighbouring views show as ghosts; "
                             "use fewer views or a higher resolution"
                           : NULL;
    return LF_OK;
}

static lf_status check_optics(const lf_print *print, lf_error *err)
{
    const lf_optics *o = &print->optics;
    const bool is_known = o->thickness_mm > 0.0 && o->distance_mm > 0.0;
    if (o->map == LF_MAP_EXACT && !is_known)
        return lf_error_set(err, LF_E_ARG, "print",
                            "an exact map needs the sheet's thickness and viewing distance; give "
                            "both, or use the uniform map");
    if (o->grid != LF_LENS_LINEAR)
        return lf_error_set(err, LF_E_ARG, "print",
                            "micro lens sheets cannot be printed; use a linear lens grid");
    if (o->slant != 0.0 || lf_print_is_exact(print))
        return lf_error_set(err, LF_E_ARG, "print",
                            "slanted lenses and exact maps cannot be printed; use a slant of 0 and "
                            "the uniform map");
    if (o->view_rows > 0 || o->phase_down_mm != 0.0)
        return lf_error_set(err, LF_E_ARG, "print",
                            "view rows and a phase down are for micro lens sheets");
    return LF_OK;
}

lf_status lf_print_check(const lf_print *print, const char **out_warning, lf_error *err)
{
    const lf_status status = lf_param_check(lf_print_params, print, "print", err);
    if (status != LF_OK)
        return status;
    if (!(print->view_aspect >= 0.0 && print->view_aspect <= 1000.0))
        return lf_error_set(err, LF_E_ARG, "print", "the views have aspect %g; expected 0 to 1000",
                            print->view_aspect);
    if (print->chart_range != 0.0 || print->chart_step != 0.0)
        return lf_error_set(err, LF_E_ARG, "print", "range and step are for charts only");
    if (print->rolled && !print->horizontal)
        return lf_error_set(err, LF_E_ARG, "print", "a rolled rig needs horizontal lenses");
    const lf_status optics = check_optics(print, err);
    return optics != LF_OK ? optics : check_views(print, out_warning, err);
}

lf_status lf_print_choose_views(lf_print *print, int n_most, const char *where, const char *pointer,
                                lf_error *err)
{
    if (print->n_views > n_most)
        return lf_error_set_at(err, LF_E_ARG, where, 0, pointer,
                               "%d views requested, but only %d exist", print->n_views, n_most);
    if (print->n_views > 0)
        return LF_OK;
    const double pixels_per_lens = lf_print_dpi_across(print) / print->lpi;
    if (pixels_per_lens < 1.5 && n_most > 1)
        return lf_error_set(err, LF_E_ARG, where,
                            "a lens of %g lpi has %.3g pixels at %.10g dpi, too few for 2 views; "
                            "use a lower lpi or higher dpi",
                            print->lpi, pixels_per_lens, lf_print_dpi_across(print));
    const double clean = fmax(2, floor(VIEWS_A_PIXEL * pixels_per_lens + 1e-9));
    print->n_views = (int)fmin(clean, n_most);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- shape -- */

/* The lenses whose cells overlap the raster; the cell of lens k is [phase + (k - 1/2) p, phase + (k
 * + 1/2) p]. */
static void lenses_of(const lf_print *print, int raster_across, int *out_first, int *out_last)
{
    /* in lenses */
    const double half = 0.5 * raster_across * print->lpi / lf_print_dpi_across(print);
    const double phase = print->phase_mm * print->lpi / 25.4;
    *out_first = (int)floor(-half - phase + 0.5);
    *out_last = (int)ceil(half - phase + 0.5) - 1;
}

void lf_print_shape_of(const lf_print *print, lf_print_shape *out)
{
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print),
                 pitch_mm = 25.4 / print->lpi;
    int last;
    memset(out, 0, sizeof *out);
    out->raster_width = (int)lround((print->width_mm + 2.0 * print->bleed_mm) / right_mm);
    out->raster_height = (int)lround((print->height_mm + 2.0 * print->bleed_mm) / down_mm);
    out->margin_px = print->marks ? (int)lround(LF_MARKS_MM / right_mm) : 0;
    out->margin_down_px = print->marks ? (int)lround(LF_MARKS_MM / down_mm) : 0;
    lenses_of(print, print->horizontal ? out->raster_height : out->raster_width, &out->first_lens,
              &last);
    out->n_lenses = last - out->first_lens + 1;
    out->n_along = print->horizontal ? out->raster_width : out->raster_height;

    const double across_mm = out->n_lenses * pitch_mm,
                 along_mm = out->n_along * (25.4 / lf_print_dpi_along(print));
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

/* ------------------------------------------------------------------------------- interlacing -- */

typedef struct line_key {
    int view, lens;
} line_key;

/* State of writing a print. */
typedef struct job {
    const lf_print *print;
    lf_print_shape shape;
    lf_print_source source;
    lf_print_colour *colour;
    lf_marks marks;
    lf_stripe_mix *mix; /* [pixels across the lenses] */
    /* vertical: [n_views][n_lenses][3] of this row; horizontal: [3][n_along][3], the stripes of
     * this row */
    float *samples;
    line_key held[3]; /* horizontal: the contents of the three lines of samples */
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
    if (!j->mix || !j->samples)
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
    lf_print_colour_destroy(j->colour);
    lf_free(j->mix);
    lf_free(j->samples);
}

/* Adds weighted pixels: out[i] = sum over slots of weight * in. */
static inline void mix_pixel(const lf_stripe_mix *mix, const float *const in[3], float *out)
{
    for (int c = 0; c < 3; c++)
        out[c] = mix->weight[0] * in[0][c] + mix->weight[1] * in[1][c] + mix->weight[2] * in[2][c];
}

static void vertical_row(job *j, int y, float *row)
{
    const size_t n_lenses = (size_t)j->shape.n_lenses;
    for (int view = 0; view < j->print->n_views; view++)
        lf_print_source_across(&j->source, view, y, j->samples + (size_t)view * n_lenses * 3);
    for (int x = 0; x < j->shape.raster_width; x++) {
        const lf_stripe_mix *mix = &j->mix[x];
        const float *in[3];
        for (int slot = 0; slot < 3; slot++)
            in[slot] =
                j->samples + 3 * ((size_t)mix->view[slot] * n_lenses + (size_t)mix->lens[slot]);
        mix_pixel(mix, in, row + 3 * (size_t)x);
    }
}

/* The line of one stripe, cached because consecutive rows share stripes. A line that this row needs
 * is never replaced, since it needs at most three and there are three. */
static const float *stripe_line(job *j, const lf_stripe_mix *mix, int slot)
{
    const size_t line_size = (size_t)j->shape.n_along * 3;
    int free_line = 0;
    for (int line = 0; line < 3; line++) {
        bool needed = false;
        if (j->held[line].view == mix->view[slot] && j->held[line].lens == mix->lens[slot])
            return j->samples + (size_t)line * line_size;
        for (int other = 0; other < 3; other++)
            needed = needed || (j->held[line].view == mix->view[other] &&
                                j->held[line].lens == mix->lens[other]);
        if (!needed)
            free_line = line;
    }
    j->held[free_line] = (line_key){mix->view[slot], mix->lens[slot]};
    float *out = j->samples + (size_t)free_line * line_size;
    lf_print_source_along(&j->source, mix->view[slot], mix->lens[slot], out);
    return out;
}

static void horizontal_row(job *j, int y, float *row)
{
    const lf_stripe_mix *mix = &j->mix[y];
    const float *line[3];
    for (int slot = 0; slot < 3; slot++)
        line[slot] = stripe_line(j, mix, slot);
    for (size_t x = 0; x < (size_t)j->shape.raster_width; x++) {
        const float *in[3] = {line[0] + 3 * x, line[1] + 3 * x, line[2] + 3 * x};
        mix_pixel(mix, in, row + 3 * x);
    }
}

static void draw_row(void *context, int y, float *row)
{
    job *j = context;
    const int margin = j->shape.margin_px;
    if (margin > 0)
        lf_marks_row(&j->marks, y, row);
    y -= j->shape.margin_down_px;
    row += (size_t)margin * 3;
    if (y < 0 || y >= j->shape.raster_height)
        return;
    if (j->print->horizontal)
        horizontal_row(j, y, row);
    else
        vertical_row(j, y, row);
}

static lf_status write_raster(job *j, const lf_print_run *run, int rows_per_strip, lf_outfile *tiff,
                              lf_error *err)
{
    char description[160], dpi[48];
    const lf_print_page page = {j->print,    j->marks.width, j->marks.height,
                                description, draw_row,       j};
    snprintf(description, sizeof description,
             "%d views interlaced for %.10g lenses per inch at %s dpi: print at 100 %%",
             j->print->n_views, j->print->lpi, lf_print_dpi_text(j->print, dpi, sizeof dpi));
    return lf_print_page_write(&page, j->colour, run, rows_per_strip, tiff, err);
}

/* --------------------------------------------------------------------------------------- all -- */

lf_status lf_print_write_strips(const lf_print *print, const lf_views32 *views,
                                const lf_print_run *run, int rows_per_strip, lf_outfile *tiff,
                                lf_outfile *manifest, lf_error *err)
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
    j.marks = lf_marks_of(print, &j.shape);
    status = lf_print_colour_create(print, &j.colour, err);
    if (status == LF_OK) {
        status = job_init(&j, views, tone);
        if (status != LF_OK)
            lf_error_set(err, status, "print", "out of memory");
    }
    if (status == LF_OK)
        status = write_raster(&j, run, rows_per_strip, tiff, err);
    facts.colour = j.colour;
    if (status == LF_OK)
        status = lf_print_manifest_write(&facts, tiff, manifest, err);
    job_finish(&j);
    lf_tone_destroy(tone);
    return status;
}

lf_status lf_print_write(const lf_print *print, const lf_views32 *views, const lf_print_run *run,
                         lf_outfile *tiff, lf_outfile *manifest, lf_error *err)
{
    return lf_print_write_strips(print, views, run, 0, tiff, manifest, err);
}
