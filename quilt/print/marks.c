#include "quilt/print/marks.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/font.h"
#include "quilt/print/print.h"

#define LINE_MM 0.2
#define STRIP_FROM 1.0
#define STRIP_TO 5.0
#define TICK_FROM 5.5
#define TICK_TO 7.5
#define CROP_FROM 1.0
#define CROP_TO 6.0
#define REGISTER_AT 4.0
#define REGISTER_ARM 2.5
#define REGISTER_RADIUS 1.5

lf_status lf_marks_init(lf_marks *marks, const lf_print *print, const lf_sheet *sheet)
{
    const double trim_right = sheet->half_right - print->bleed_mm;
    const double trim_down = sheet->half_down - print->bleed_mm - lf_sheet_band(sheet);
    *marks = (lf_marks){
        .print = print,
        .sheet = sheet,
        .horizontal = print->horizontal,
        .right = 25.4 / print->dpi,
        .down = 25.4 / lf_print_dpi_down(print),
        .pitch = 25.4 / print->lpi,
        .phase = print->phase_mm,
        .straight = print->optics.slant == 0.0 && !lf_print_is_exact(print),
        .lens = lf_lens_of_print(print),
        .trim_across = print->horizontal ? trim_down : trim_right,
        .half_across = print->horizontal ? sheet->half_down : sheet->half_right,
        .half_along = print->horizontal ? sheet->half_right : sheet->half_down,
        .ink = lf_calloc((size_t)sheet->width, sizeof *marks->ink),
    };
    return marks->ink ? LF_OK : LF_E_NOMEM;
}

void lf_marks_finish(lf_marks *marks)
{
    lf_free(marks->ink);
    marks->ink = NULL;
}

/* The fraction of a pixel around x on a line of this width around `at`. */
static double on_line(double pixel, double x, double at, double width)
{
    const double half = 0.5 * pixel;
    const double covered = fmin(x + half, at + 0.5 * width) - fmax(x - half, at - 0.5 * width);
    return fmax(covered, 0.0) / pixel;
}

/* Size of a pixel in mm, across the lenses and along them. */
static double pixel_across(const lf_marks *marks)
{
    return marks->horizontal ? marks->down : marks->right;
}

static double pixel_along(const lf_marks *marks)
{
    return marks->horizontal ? marks->right : marks->down;
}

static bool within(double x, double from, double to)
{
    return x >= from && x < to;
}

/* Where a lens of phase 0 is, across, at this distance along it. */
static double middle_lens(const lf_marks *marks, double along)
{
    const double side = marks->horizontal ? -along : along;
    return marks->straight
               ? marks->phase
               : (marks->phase - side * lf_print_sin(marks->print)) / lf_print_cos(marks->print);
}

/* The nearest line of an alignment strip, across. */
static double strip_line(const lf_marks *marks, double across, double along)
{
    if (marks->straight)
        return marks->phase + marks->pitch * round((across - marks->phase) / marks->pitch);
    const double phase = marks->horizontal ? lf_lens_phase(&marks->lens, along, across, 0)
                                           : lf_lens_phase(&marks->lens, across, along, 0);
    return across - (phase - round(phase)) * marks->pitch / lf_print_cos(marks->print);
}

/* Ink beyond the ends of the lenses; out: distance from the last bleed or label. */
static double end_ink(const lf_marks *marks, double across, double along, double out)
{
    const double pixel = pixel_across(marks);
    if (within(out, STRIP_FROM, STRIP_TO) && fabs(across) < marks->trim_across - 1.0)
        return on_line(pixel, across, strip_line(marks, across, along), 0.25 * marks->pitch);
    return within(out, TICK_FROM, TICK_TO)
               ? on_line(pixel, across, middle_lens(marks, along), LINE_MM)
               : 0.0;
}

/* Ink beyond the first or last lens. */
static double side_ink(const lf_marks *marks, double out, double along)
{
    const double x = out - REGISTER_AT, radius = hypot(x, along);
    /* for the ring, which has all directions, a pixel is the finer of both sizes */
    const double finer = fmin(marks->right, marks->down);
    double ink = on_line(finer, radius, REGISTER_RADIUS, LINE_MM);
    if (fabs(along) < REGISTER_ARM)
        ink = fmax(ink, on_line(pixel_across(marks), x, 0.0, LINE_MM));
    if (fabs(x) < REGISTER_ARM)
        ink = fmax(ink, on_line(pixel_along(marks), along, 0.0, LINE_MM));
    return ink;
}

/* Ink of the marks of the sheet. */
static double sheet_ink(const lf_marks *marks, double across, double along)
{
    const double beside = fabs(across) - marks->half_across;
    const double beyond = fabs(along) - marks->half_along;
    if (beyond > 0.0 && beside <= 0.0)
        return end_ink(marks, across, along, beyond);
    if (beside > 0.0 && beyond <= 0.0)
        return side_ink(marks, beside, along);
    return 0.0;
}

static void add_ink(const lf_marks *marks, int x, double ink)
{
    marks->ink[x] = fmax(marks->ink[x], ink);
}

/* The pixel at a position, at most one outside the page. */
static int pixel_at(const lf_marks *marks, double right)
{
    const double x = floor(right / marks->right + 0.5 * marks->sheet->width);
    return (int)fmin(fmax(x, -1.0), marks->sheet->width);
}

static double right_of(const lf_marks *marks, int x)
{
    return (x + 0.5 - 0.5 * marks->sheet->width) * marks->right;
}

/* The marks of the sheet are outside all pictures: the row is skipped between them. */
static void draw_sheet_marks(const lf_marks *marks, double down)
{
    const int width = marks->sheet->width;
    const bool is_beside = fabs(down) <= marks->sheet->half_down;
    const int left = pixel_at(marks, -marks->sheet->half_right) + 1,
              right = pixel_at(marks, marks->sheet->half_right) - 1;
    for (int x = 0; x < width; x++) {
        if (is_beside && x == left && right > left)
            x = right;
        marks->ink[x] = marks->horizontal ? sheet_ink(marks, down, right_of(marks, x))
                                          : sheet_ink(marks, right_of(marks, x), down);
    }
}

/* Where crop marks outside a bleed end: at a neighbour's bleed they keep their distance from it. */
static double crop_end(bool has_neighbour, double step, double bleed)
{
    return has_neighbour ? fmin(CROP_TO, step - 2.0 * bleed - CROP_FROM) : CROP_TO;
}

/* Lines on the trim edges of copy i, outside its bleed. */
static void draw_crop_marks(const lf_marks *marks, int i, double down)
{
    const lf_print *print = marks->print;
    const lf_sheet *sheet = marks->sheet;
    const lf_copy *copy = &sheet->copies[i];
    const int column = i % sheet->n_columns, row = i / sheet->n_columns;
    const double trim_right = 0.5 * print->width_mm, trim_down = 0.5 * print->height_mm;
    const double bleed_right = trim_right + print->bleed_mm,
                 bleed_down = trim_down + print->bleed_mm;
    const double from_middle = fabs(down - copy->down_mm);
    const bool neighbour = down < copy->down_mm ? row > 0 : row + 1 < sheet->n_rows;
    const bool is_beyond = within(from_middle - bleed_down, CROP_FROM,
                                  crop_end(neighbour, sheet->step_down_mm, bleed_down));
    const double level = on_line(marks->down, from_middle, trim_down, LINE_MM);
    if (!is_beyond && !(level > 0.0))
        return;
    const double to_left = crop_end(column > 0, sheet->step_right_mm, bleed_right);
    const double to_right =
        crop_end(column + 1 < sheet->n_columns, sheet->step_right_mm, bleed_right);
    const int first = pixel_at(marks, copy->right_mm - bleed_right - CROP_TO),
              last = pixel_at(marks, copy->right_mm + bleed_right + CROP_TO) + 1;
    for (int x = first < 0 ? 0 : first; x <= last && x < sheet->width; x++) {
        const double at = right_of(marks, x) - copy->right_mm;
        if (is_beyond)
            add_ink(marks, x, on_line(marks->right, fabs(at), trim_right, LINE_MM));
        if (within(fabs(at) - bleed_right, CROP_FROM, at < 0.0 ? to_left : to_right))
            add_ink(marks, x, level);
    }
}

static void draw_label(const lf_marks *marks, const lf_copy *copy, double down)
{
    const lf_print *print = marks->print;
    const double y =
        down - (copy->down_mm + 0.5 * print->height_mm + print->bleed_mm + LF_LABEL_GAP);
    const double left = copy->right_mm - 0.5 * print->width_mm + LF_LABEL_INDENT;
    if (!(y >= 0.0 && y < lf_sheet_band(marks->sheet) - LF_LABEL_GAP))
        return;
    const int end = pixel_at(marks, left + print->width_mm);
    for (int x = pixel_at(marks, left); x < end; x++)
        if (lf_sheet_label_ink(marks->sheet, right_of(marks, x) - left, y))
            add_ink(marks, x, 1.0);
}

void lf_marks_row(lf_marks *marks, int y, float *row)
{
    const lf_sheet *sheet = marks->sheet;
    const double down = (y + 0.5 - 0.5 * sheet->height) * marks->down;
    memset(marks->ink, 0, (size_t)sheet->width * sizeof *marks->ink);
    if (marks->print->marks)
        draw_sheet_marks(marks, down);
    for (int i = 0; i < sheet->n_rows * sheet->n_columns; i++) {
        if (marks->print->marks)
            draw_crop_marks(marks, i, down);
        if (sheet->label_mm > 0.0)
            draw_label(marks, &sheet->copies[i], down);
    }
    for (int x = 0; x < sheet->width; x++)
        for (int c = 0; c < 3; c++)
            row[3 * x + c] = (float)(1.0 - marks->ink[x]);
}
