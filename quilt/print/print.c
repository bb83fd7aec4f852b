#include "quilt/print/print.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/compensate.h"
#include "quilt/print/flip.h"
#include "quilt/print/marks.h"
#include "quilt/print/relief.h"

/* ----------------------------------------------------------------------------- what is asked -- */

char *lf_print_dpi_text(const lf_print *print, char *buf, size_t size)
{
    const double down = lf_print_dpi_down(print);
    snprintf(buf, size, down == print->dpi ? "%.10g" : "%.10gx%.10g", print->dpi, down);
    return buf;
}

double lf_print_pixels_per_lens(const lf_print *print)
{
    const double across = lf_print_dpi_across(print) / print->lpi;
    /* a micro lens has them both ways */
    return lf_print_is_micro(print)     ? fmin(print->dpi, lf_print_dpi_down(print)) / print->lpi
           : print->optics.slant == 0.0 ? across
                                        : across / lf_print_cos(print);
}

int lf_print_view_rows(const lf_print *print)
{
    if (!lf_print_is_micro(print) || print->n_views < 1)
        return 1;
    return print->optics.view_rows > 0 ? print->optics.view_rows
                                       : (int)lround(sqrt((double)print->n_views));
}

/* With more views, stripes are so narrow that neighbouring views ghost. */
#define VIEWS_A_PIXEL 0.8

static const char ghosts[] = "with more than 0.8 dpi/lpi views, neighbouring views show as ghosts; "
                             "use fewer views or a higher resolution";

static lf_status check_views(const lf_print *print, const char **out_warning, lf_error *err)
{
    const double pixels_per_lens = lf_print_pixels_per_lens(print);
    const int most = (int)fmax(floor(pixels_per_lens + 0.5), 1.0);
    const int rows = lf_print_view_rows(print), columns = print->n_views / rows;
    if (print->n_views < 1 || columns < 1 || columns * rows != print->n_views)
        return lf_error_set(err, LF_E_ARG, "print",
                            "%d views do not fill %d rows; set the number of view rows",
                            print->n_views, rows);
    if (columns > most || rows > most)
        return lf_error_set(err, LF_E_ARG, "print",
                            "%d views are not possible: a lens of %g lpi has %.4g pixels at %.10g "
                            "dpi; expected 1 to %d views%s",
                            print->n_views, print->lpi, pixels_per_lens, lf_print_dpi_across(print),
                            most, lf_print_is_micro(print) ? " each way" : "");
    const int widest = columns > rows ? columns : rows;
    if (out_warning)
        *out_warning =
            widest > 2 && widest > VIEWS_A_PIXEL * pixels_per_lens + 1e-9 ? ghosts : NULL;
    return LF_OK;
}

static lf_status check_micro(const lf_print *print, lf_error *err)
{
    if (print->horizontal)
        return lf_error_set(err, LF_E_ARG, "print",
                            "micro lenses have no orientation; leave out \"horizontal\"");
    if (print->marks)
        return lf_error_set(err, LF_E_ARG, "print",
                            "marks are for rows of lenses; leave them out for micro lenses");
    return LF_OK;
}

static lf_status check_optics(const lf_print *print, lf_error *err)
{
    const lf_optics *o = &print->optics;
    if (o->map == LF_MAP_EXACT && !lf_print_is_exact(print))
        return lf_error_set(err, LF_E_ARG, "print",
                            "an exact map needs the sheet's thickness and viewing distance; give "
                            "both, or use the uniform map");
    if (lf_print_is_micro(print))
        return check_micro(print, err);
    if (o->view_rows > 0 || o->phase_down_mm != 0.0)
        return lf_error_set(err, LF_E_ARG, "print",
                            "view rows and a phase down are for micro lens sheets");
    return LF_OK;
}

/* The copies, labels and marks fit on their page. */
static lf_status check_sheet(const lf_print *print, lf_error *err)
{
    lf_print_shape shape;
    lf_sheet sheet;
    lf_print_shape_of(print, &shape);
    const lf_status status = lf_sheet_init(&sheet, print, &shape, err);
    lf_sheet_finish(&sheet);
    return status;
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
    lf_relief relief;
    lf_status parts = check_optics(print, err);
    if (parts == LF_OK)
        parts = check_sheet(print, err);
    if (parts == LF_OK && print->relief)
        parts = lf_relief_of(print, &relief, err);
    if (parts == LF_OK)
        parts = check_views(print, out_warning, err);
    return parts != LF_OK ? parts : lf_compensate_check(print, err);
}

/* A micro sheet shows all views that there are, if a lens has a pixel for each; otherwise as many
 * as it shows without ghosting. */
static lf_status choose_micro_views(lf_print *print, int n_most, const char *where, lf_error *err)
{
    const double pixels = lf_print_pixels_per_lens(print);
    const int most = (int)fmax(1, floor(pixels + 0.5)),
              clean = (int)fmax(2, floor(VIEWS_A_PIXEL * pixels + 1e-9));
    const int asked = print->optics.view_rows,
              rows = asked > 0 ? asked : (int)lround(sqrt((double)n_most)),
              columns = asked > 0 ? n_most / asked : rows;
    const bool are_grid = columns * rows == n_most;
    const double could = (asked > 0 ? asked : clean) * (double)clean;
    if (!are_grid && could > n_most)
        return lf_error_set(err, LF_E_ARG, where,
                            "%d views do not fill %d rows; set the number of view rows", n_most,
                            rows);
    const bool all = are_grid && ((columns <= most && rows <= most) || could > n_most);
    print->n_views = all ? n_most : (int)could;
    return LF_OK;
}

lf_status lf_print_choose_views(lf_print *print, int n_most, const char *where, const char *pointer,
                                lf_error *err)
{
    const int n_frames = lf_flip_frames(print, n_most), guard = print->sheet.guard;
    if (print->n_views > n_frames && guard == 0)
        return lf_error_set_at(err, LF_E_ARG, where, 0, pointer,
                               "%d views requested, but only %d exist", print->n_views, n_frames);
    if (print->n_views > 0)
        return lf_flip_check(print, n_most, where, err);
    if (lf_print_is_micro(print))
        return choose_micro_views(print, n_most, where, err);
    const double pixels_per_lens = lf_print_pixels_per_lens(print);
    if (pixels_per_lens < 1.5 && n_most > 1)
        return lf_error_set(err, LF_E_ARG, where,
                            "a lens of %g lpi has %.3g pixels at %.10g dpi, too few for 2 views; "
                            "use a lower lpi or higher dpi",
                            print->lpi, pixels_per_lens, lf_print_dpi_across(print));
    const double clean = fmax(2, floor(VIEWS_A_PIXEL * pixels_per_lens + 1e-9));
    if (guard == 0) {
        print->n_views = (int)fmin(clean, n_frames);
        return LF_OK;
    }
    const double evenly = n_frames * floor(clean / n_frames);
    print->n_views = (int)(evenly >= n_frames * (1.0 + guard) ? evenly : clean);
    const lf_status status = lf_flip_check(print, n_most, where, err);
    if (status != LF_OK)
        print->n_views = 0;
    return status;
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

/* Where the axis of lens 0 crosses the middle row (column). */
static double phase_across(const lf_print *print)
{
    return print->optics.slant == 0.0 ? print->phase_mm : print->phase_mm / lf_print_cos(print);
}

/* Samples `step` apart, one of them at `phase`, from half a lens beyond one edge to half a lens
 * beyond the other. */
static int samples_beyond(double phase, double step, double lens, double half, int *out_n)
{
    const int first = (int)floor((-half - 0.5 * lens - phase) / step);
    *out_n = (int)ceil((half + 0.5 * lens - phase) / step) - first + 1;
    return first;
}

static void linear_samples(const lf_print *print, lf_print_shape *out)
{
    const int raster_across = print->horizontal ? out->raster_height : out->raster_width;
    int last;
    out->step_across_mm = lf_print_pitch_mm(print);
    out->step_along_mm = 25.4 / lf_print_dpi_along(print);
    out->n_along = print->horizontal ? out->raster_width : out->raster_height;
    if (lf_print_is_separable(print)) {
        lenses_of(print, raster_across, &out->first_lens, &last);
        out->n_lenses = last - out->first_lens + 1;
    } else {
        out->step_across_mm /= lf_print_cos(print);
        out->first_lens =
            samples_beyond(phase_across(print), out->step_across_mm, out->step_across_mm,
                           0.5 * raster_across * 25.4 / lf_print_dpi_across(print), &out->n_lenses);
    }
    out->first_across_mm = phase_across(print) + out->first_lens * out->step_across_mm;
    out->first_along_mm = (0.5 - 0.5 * out->n_along) * out->step_along_mm;
}

/* A turned sheet's lens may lie further out by half a diagonal. */
#define MICRO_REACH 1.6

static void micro_samples(const lf_print *print, lf_print_shape *out)
{
    const bool is_hexagonal = print->optics.grid == LF_LENS_HEXAGONAL;
    const double pitch = lf_print_pitch_mm(print), right_mm = 25.4 / print->dpi,
                 down_mm = 25.4 / lf_print_dpi_down(print);
    int first;
    out->step_across_mm = is_hexagonal ? 0.5 * pitch : pitch;
    out->step_along_mm = is_hexagonal ? pitch * sqrt(0.75) : pitch;
    out->first_lens = samples_beyond(print->phase_mm, out->step_across_mm, MICRO_REACH * pitch,
                                     0.5 * out->raster_width * right_mm, &out->n_lenses);
    first = samples_beyond(print->optics.phase_down_mm, out->step_along_mm, MICRO_REACH * pitch,
                           0.5 * out->raster_height * down_mm, &out->n_along);
    out->first_across_mm = print->phase_mm + out->first_lens * out->step_across_mm;
    out->first_along_mm = print->optics.phase_down_mm + first * out->step_along_mm;
}

void lf_print_shape_of(const lf_print *print, lf_print_shape *out)
{
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print);
    memset(out, 0, sizeof *out);
    out->raster_width = (int)lround((print->width_mm + 2.0 * print->bleed_mm) / right_mm);
    out->raster_height = (int)lround((print->height_mm + 2.0 * print->bleed_mm) / down_mm);
    out->margin_px = print->marks ? (int)lround(LF_MARKS_MM / right_mm) : 0;
    out->margin_down_px = print->marks ? (int)lround(LF_MARKS_MM / down_mm) : 0;
    if (lf_print_is_micro(print))
        micro_samples(print, out);
    else
        linear_samples(print, out);
    const double across_mm = out->n_lenses * out->step_across_mm,
                 along_mm = out->n_along * out->step_along_mm;
    const int last = out->first_lens + out->n_lenses - 1;
    const double center_mm = (lf_print_is_micro(print) ? print->phase_mm : phase_across(print)) +
                             0.5 * (out->first_lens + last) * out->step_across_mm;
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
    if (lf_print_is_micro(print))
        out->window_center_y_mm =
            out->first_along_mm + 0.5 * (out->n_along - 1) * out->step_along_mm;
}

/* ------------------------------------------------------------------------------- interlacing -- */

typedef struct line_key {
    int view, lens;
} line_key;

/* State of drawing rows of copies. Strips that are made at the same time have a job each, with
 * lines and samples of its own. */
typedef struct job {
    const struct page *page;
    lf_print_source source;
    lf_marks marks;
    /* vertical: [n_views][n_lenses][3] of this row; horizontal: [3][n_along][3], the stripes of
     * this row */
    float *samples;
    line_key held[3];     /* horizontal: the contents of the three lines of samples */
    lf_print_shape shape; /* of the copy that is drawn, with its shift, for … */
    lf_slanted *slanted;  /* … these, instead of samples */
    lf_micro *micro;
    lf_compensate *compensate; /* NULL: off */
} job;

/* What all jobs share. */
typedef struct page {
    const lf_print *print;
    lf_print_shape shape;
    lf_sheet sheet;
    lf_print_source source;
    lf_print_colour *colour;
    bool is_alone;      /* one copy fills the page */
    lf_stripe_mix *mix; /* [n_mixes][n_across]: copies with one place on their pixels share one;
                           NULL: not separable */
    lf_compensate *compensate; /* NULL: off; otherwise there is one copy */
    lf_print_shape only;       /* of this copy, with its shift */
    int n_mixes, n_across;     /* pixels of a copy across the lenses */
    job jobs[LF_PRINT_MAX_HANDS];
    int n_jobs;
} page;

/* Straight lenses give a column (row) of copies one place on the pixels. */
static const lf_stripe_mix *mix_of(const page *p, int copy)
{
    const int n_columns = p->sheet.n_columns;
    const int i = p->print->horizontal ? copy / n_columns : copy % n_columns;
    return p->mix + (size_t)i * (size_t)p->n_across;
}

static lf_status make_mixes(page *p)
{
    if (!lf_print_is_separable(p->print))
        return LF_OK;
    const bool horizontal = p->print->horizontal;
    p->n_mixes = horizontal ? p->sheet.n_rows : p->sheet.n_columns;
    p->n_across = horizontal ? p->shape.raster_height : p->shape.raster_width;
    p->mix = lf_calloc((size_t)p->n_mixes * (size_t)p->n_across, sizeof *p->mix);
    for (int i = 0; p->mix && i < p->n_mixes; i++) {
        const lf_copy *copy = &p->sheet.copies[horizontal ? i * p->sheet.n_columns : i];
        lf_print_shape shape = p->shape;
        shape.shift_right_mm = copy->shift_right_mm;
        shape.shift_down_mm = copy->shift_down_mm;
        for (int pixel = 0; pixel < p->n_across; pixel++)
            lf_stripe_mix_at(p->print, &shape, pixel,
                             p->mix + (size_t)i * (size_t)p->n_across + pixel);
    }
    return p->mix ? LF_OK : LF_E_NOMEM;
}

static lf_status make_samples(job *j, const page *p)
{
    const size_t lines = p->print->horizontal ? 3 : (size_t)p->print->n_views;
    const size_t line = (size_t)(p->print->horizontal ? p->shape.n_along : p->shape.n_lenses);
    j->samples = lf_calloc(lines * line, 3 * sizeof *j->samples);
    for (int i = 0; i < 3; i++)
        j->held[i] = (line_key){-1, -1};
    return j->samples ? LF_OK : LF_E_NOMEM;
}

/* Call job_finish also after a failure. */
static lf_status job_init(job *j, const page *p)
{
    *j = (job){.page = p, .source = p->source, .shape = p->shape};
    lf_status status = lf_print_source_share(&j->source);
    if (status == LF_OK)
        status = lf_marks_init(&j->marks, p->print, &p->sheet);
    if (status != LF_OK)
        return status;
    if (lf_print_is_micro(p->print))
        return lf_micro_create(p->print, &j->shape, &j->source, &j->micro);
    if (p->compensate && lf_compensate_share(p->compensate, &j->source, &j->compensate) != LF_OK)
        return LF_E_NOMEM;
    if (!p->mix)
        return lf_slanted_create(p->print, &j->shape, &j->source, &j->slanted);
    return make_samples(j, p);
}

static void job_finish(job *j)
{
    lf_free(j->source.line);
    lf_marks_finish(&j->marks);
    lf_compensate_destroy(j->compensate);
    lf_slanted_destroy(j->slanted);
    lf_micro_destroy(j->micro);
    lf_free(j->samples);
}

/* Adds weighted pixels: out[i] = sum over slots of weight * in. */
static inline void mix_pixel(const lf_stripe_mix *mix, const float *const in[3], float *out)
{
    for (int c = 0; c < 3; c++)
        out[c] = mix->weight[0] * in[0][c] + mix->weight[1] * in[1][c] + mix->weight[2] * in[2][c];
}

/* The samples of row y of a copy, for vertical_row. */
static void gather_row(job *j, int y)
{
    const size_t n_lenses = (size_t)j->page->shape.n_lenses;
    for (int view = 0; view < j->page->print->n_views; view++)
        lf_print_source_across(&j->source, view, y, j->samples + (size_t)view * n_lenses * 3);
}

static void vertical_row(const job *j, const lf_stripe_mix *mixes, float *row)
{
    const size_t n_lenses = (size_t)j->page->shape.n_lenses;
    for (int x = 0; x < j->page->shape.raster_width; x++) {
        const lf_stripe_mix *mix = &mixes[x];
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
    const size_t line_size = (size_t)j->page->shape.n_along * 3;
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

static void horizontal_row(job *j, const lf_stripe_mix *mix, float *row)
{
    const float *line[3];
    for (int slot = 0; slot < 3; slot++)
        line[slot] = stripe_line(j, mix, slot);
    for (size_t x = 0; x < (size_t)j->page->shape.raster_width; x++) {
        const float *in[3] = {line[0] + 3 * x, line[1] + 3 * x, line[2] + 3 * x};
        mix_pixel(mix, in, row + 3 * x);
    }
}

/* Draws row y of the copies from the first of their row on. Horizontal lenses are the same in all
 * of them. */
static void draw_copies(job *j, int first, int y, float *row)
{
    const page *p = j->page;
    const size_t size = (size_t)p->shape.raster_width * 3;
    const lf_copy *copies = p->sheet.copies;
    float *start = row + (size_t)copies[first].left * 3;
    if (p->print->horizontal && j->compensate)
        lf_compensate_down(j->compensate, y, start);
    else if (p->print->horizontal)
        horizontal_row(j, mix_of(p, first) + y, start);
    else
        gather_row(j, y);
    for (int i = first; i < first + p->sheet.n_columns; i++) {
        float *out = row + (size_t)copies[i].left * 3;
        if (!p->print->horizontal)
            vertical_row(j, mix_of(p, i), out);
        else if (i > first)
            memcpy(out, start, size * sizeof *out);
        if (!p->print->horizontal && j->compensate)
            lf_compensate_across(j->compensate, y, j->samples, out);
    }
}

/* Draws row y of the page where it meets a copy of a sheet that is not separable. */
static void draw_general(job *j, const lf_copy *copy, int y, float *row)
{
    const int at = y - copy->top;
    float *out = row + (size_t)copy->left * 3;
    if (at < 0 || at >= j->page->shape.raster_height)
        return;
    j->shape.shift_right_mm = copy->shift_right_mm;
    j->shape.shift_down_mm = copy->shift_down_mm;
    if (j->compensate && j->page->print->horizontal)
        lf_compensate_down(j->compensate, at, out);
    else if (j->micro)
        lf_micro_row(j->micro, at, out);
    else
        lf_slanted_row(j->slanted, at, out);
    if (j->compensate && !j->page->print->horizontal)
        lf_compensate_across(j->compensate, at, lf_slanted_samples(j->slanted), out);
}

static void draw_row(void *context, int y, float *row)
{
    job *j = context;
    const page *p = j->page;
    if (!p->is_alone)
        lf_marks_row(&j->marks, y, row);
    for (int i = 0; !p->mix && i < p->sheet.n_rows * p->sheet.n_columns; i++)
        draw_general(j, &p->sheet.copies[i], y, row);
    for (int r = 0; p->mix && r < p->sheet.n_rows; r++) {
        const int first = r * p->sheet.n_columns, at = y - p->sheet.copies[first].top;
        if (at >= 0 && at < p->shape.raster_height)
            draw_copies(j, first, at, row);
    }
}

/* -------------------------------------------------------------------------------------- page -- */

static lf_status page_init(page *p, const lf_views32 *views, const lf_tone *tone, int n_jobs,
                           lf_error *err)
{
    lf_print_shape_of(p->print, &p->shape);
    lf_status status = lf_sheet_init(&p->sheet, p->print, &p->shape, err);
    if (status == LF_OK)
        status = lf_print_colour_create(p->print, &p->colour, err);
    if (status != LF_OK)
        return status;
    p->is_alone =
        p->sheet.width == p->shape.raster_width && p->sheet.height == p->shape.raster_height;
    status = lf_print_source_init(&p->source, p->print, &p->shape, views, tone);
    if (status == LF_OK)
        status = make_mixes(p);
    p->only = p->shape;
    p->only.shift_right_mm = p->sheet.copies[0].shift_right_mm;
    p->only.shift_down_mm = p->sheet.copies[0].shift_down_mm;
    if (status == LF_OK)
        status = lf_compensate_create(p->print, &p->only, &p->compensate);
    if (p->compensate && p->print->horizontal)
        n_jobs = 1; /* strips in turn would make the same rows again */
    while (p->n_jobs < n_jobs && status == LF_OK)
        status = job_init(&p->jobs[p->n_jobs++], p);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, "print", "out of memory");
}

static void page_finish(page *p)
{
    for (int i = 0; i < p->n_jobs; i++)
        job_finish(&p->jobs[i]);
    lf_print_source_finish(&p->source);
    lf_print_colour_destroy(p->colour);
    lf_compensate_destroy(p->compensate);
    lf_free(p->mix);
    lf_sheet_finish(&p->sheet);
}

static lf_status write_raster(page *p, const lf_print_run *run, const char *description,
                              int rows_per_strip, lf_outfile *tiff, lf_error *err)
{
    void *contexts[LF_PRINT_MAX_HANDS];
    for (int i = 0; i < p->n_jobs; i++)
        contexts[i] = &p->jobs[i];
    const lf_print_page file = {.print = p->print,
                                .width = p->sheet.width,
                                .height = p->sheet.height,
                                .description = description,
                                .draw = draw_row,
                                .context = contexts[0],
                                .hands = contexts,
                                .n_hands = p->n_jobs,
                                .sheet = &p->sheet};
    return lf_print_page_write(&file, p->colour, run, rows_per_strip, tiff, err);
}

/* --------------------------------------------------------------------------------------- all -- */

static lf_status write_relief(const lf_print *print, const lf_print_run *run, lf_relief *out,
                              lf_error *err)
{
    const lf_status status = lf_relief_of(print, out, err);
    if (status != LF_OK)
        return status;
    return run->relief ? lf_relief_write(out, run, run->relief, err)
                       : lf_error_set(err, LF_E_ARG, "print", "a relief needs a file of its own");
}

static lf_status check_given(const lf_print *print, const lf_views32 *views, const char **warning,
                             lf_error *err)
{
    lf_status status = lf_print_check(print, warning, err);
    if (status == LF_OK && (views->n_views < 1 || views->width < 1 || views->height < 1))
        status = lf_error_set(err, LF_E_ARG, "print", "no views");
    if (status == LF_OK && lf_print_is_micro(print) && views->n_views != print->n_views)
        status = lf_error_set(
            err, LF_E_ARG, "print",
            "a micro lens sheet shows all views: there are %d, but %d x %d are requested",
            views->n_views, print->n_views / lf_print_view_rows(print), lf_print_view_rows(print));
    return status;
}

lf_status lf_print_write_strips(const lf_print *print, const lf_views32 *views,
                                const lf_print_run *run, int rows_per_strip, lf_outfile *tiff,
                                lf_outfile *manifest, lf_error *err)
{
    page p = {.print = print};
    lf_tone *tone = NULL;
    lf_relief relief;
    lf_print_facts facts = {
        .print = print, .shape = &p.shape, .sheet = &p.sheet, .source = &p.source, .run = run};
    char description[160], dpi[48];
    lf_status status = check_given(print, views, &facts.warning, err);
    if (status == LF_OK)
        status = lf_flip_check(print, views->n_views, "print", err);
    if (status == LF_OK)
        status = lf_tone_create(run->exposure, run->tonemap ? run->tonemap : "srgb", &tone, err);
    if (status != LF_OK)
        return status;
    snprintf(description, sizeof description,
             "%d views interlaced for %.10g lenses per inch at %s dpi: print at 100 %%",
             print->n_views, print->lpi, lf_print_dpi_text(print, dpi, sizeof dpi));
    status = page_init(&p, views, tone, lf_print_hands(run), err);
    if (status == LF_OK && print->relief) {
        status = write_relief(print, run, &relief, err);
        facts.relief = &relief;
    }
    lf_print_run measured = *run;
    measured.out_ink = &facts.ink;
    if (status == LF_OK)
        status = write_raster(&p, &measured, description, rows_per_strip, tiff, err);
    if (run->out_ink)
        *run->out_ink = facts.ink;
    if (status == LF_OK && p.compensate)
        facts.left = lf_compensate_left(p.compensate);
    if (run->out_left)
        *run->out_left = facts.left;
    facts.colour = p.colour;
    if (status == LF_OK)
        status = lf_print_manifest_write(&facts, tiff, manifest, err);
    page_finish(&p);
    lf_tone_destroy(tone);
    return status;
}

lf_status lf_print_write_frame(const lf_print *print, const lf_views32 *view,
                               const lf_print_run *run, const char *description, lf_outfile *tiff,
                               lf_error *err)
{
    page p = {.print = print};
    lf_tone *tone = NULL;
    lf_status status = check_given(print, view, NULL, err);
    if (status == LF_OK)
        status = lf_tone_create(run->exposure, run->tonemap ? run->tonemap : "srgb", &tone, err);
    if (status != LF_OK)
        return status;
    status = page_init(&p, view, tone, lf_print_hands(run), err);
    if (status == LF_OK)
        status = write_raster(&p, run, description, 0, tiff, err);
    page_finish(&p);
    lf_tone_destroy(tone);
    return status;
}

lf_status lf_print_write(const lf_print *print, const lf_views32 *views, const lf_print_run *run,
                         lf_outfile *tiff, lf_outfile *manifest, lf_error *err)
{
    return lf_print_write_strips(print, views, run, 0, tiff, manifest, err);
}
