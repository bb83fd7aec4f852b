#include "quilt/print/sheet.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/font.h"
#include "quilt/print/flip.h"
#include "quilt/print/print.h"

/* The largest page, mm: a print of the largest size with bleed and marks, and some paper. */
#define PAGE_MOST 5500.0
#define USUAL_LABEL 2.5
#define SMALLEST_LABEL 0.8
/* Whole numbers closer than this are met. */
#define SNAP 1e-9

/* ------------------------------------------------------------------------------------- label -- */

/* A label's height and width in squares of the font. */
static double label_squares(const lf_sheet *sheet)
{
    return (LF_FONT_COLUMNS + 1.0) * (double)strlen(sheet->label) - 1.0;
}

double lf_sheet_band(const lf_sheet *sheet)
{
    return sheet->label_mm > 0.0
               ? LF_LABEL_GAP + sheet->label_mm * LF_FONT_ROWS / (double)LF_FONT_ASCENT
               : 0.0;
}

bool lf_sheet_label_ink(const lf_sheet *sheet, double x, double y)
{
    const double square = sheet->label_mm / LF_FONT_ASCENT;
    const double column = floor(x / square), row = floor(y / square);
    if (!(column >= 0.0 && column < label_squares(sheet) && row >= 0.0 && row < LF_FONT_ROWS))
        return false;
    const int at = (int)column, bit = LF_FONT_COLUMNS - 1 - at % (LF_FONT_COLUMNS + 1);
    const uint8_t *rows = lf_font_rows(sheet->label[at / (LF_FONT_COLUMNS + 1)]);
    return bit >= 0 && (rows[(int)row] >> bit & 1) != 0;
}

/* A label that is too wide for the print gets smaller letters. */
static lf_status take_label(lf_sheet *sheet, const lf_print *print, lf_error *err)
{
    const lf_print_sheet *s = &print->sheet;
    const double room = print->width_mm - 2.0 * LF_LABEL_INDENT;
    if (!s->label || s->label[0] == '\0')
        return LF_OK;
    if (strlen(s->label) > LF_LABEL_MOST)
        return lf_error_set(err, LF_E_ARG, "print", "the label is longer than %d bytes; shorten it",
                            LF_LABEL_MOST);
    lf_font_ascii(s->label, sheet->label, sizeof sheet->label);
    sheet->label_mm = fmin(s->label_mm > 0.0 ? s->label_mm : USUAL_LABEL,
                           room * LF_FONT_ASCENT / label_squares(sheet));
    if (!(sheet->label_mm >= SMALLEST_LABEL))
        return lf_error_set(err, LF_E_ARG, "print",
                            "a label of %zu characters is not readable below a print %g mm wide; "
                            "shorten it",
                            strlen(sheet->label), print->width_mm);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ places -- */

/* One axis of the page: the copies are at whole units, `step` of them apart. */
typedef struct axis {
    int n, step;
    double unit, pixel, size; /* mm; the size is that of a copy with all between it and the next */
    int n_pixels;             /* of a copy */
    bool whole;               /* a copy is on whole pixels; otherwise it is shifted within one */
} axis;

static axis axis_of(const lf_print *print, const lf_print_shape *shape, const lf_sheet *sheet,
                    bool down)
{
    const lf_optics *o = &print->optics;
    const bool across = o->grid != LF_LENS_LINEAR || down == print->horizontal;
    const double lean = lf_print_cos(print);
    axis a = {.n = down ? sheet->n_rows : sheet->n_columns,
              .pixel = 25.4 / (down ? lf_print_dpi_down(print) : print->dpi),
              .size = (down ? print->height_mm + lf_sheet_band(sheet) : print->width_mm) +
                      2.0 * print->bleed_mm + print->sheet.gutter_mm,
              .n_pixels = down ? shape->raster_height : shape->raster_width,
              .whole = !across};
    a.unit = !across                                ? a.pixel
             : o->grid == LF_LENS_LINEAR            ? sheet->mechanical_mm / lean
             : down && o->grid == LF_LENS_HEXAGONAL ? sheet->mechanical_mm * sqrt(3.0)
                                                    : sheet->mechanical_mm;
    /* pixels round a copy up by half a pixel */
    const double least = across ? a.size : fmax(a.size, a.n_pixels * a.pixel);
    a.step = (int)ceil(least / a.unit - SNAP);
    return a;
}

static int units_of(const axis *a, int i)
{
    return i * a->step - (a->n - 1) * a->step / 2;
}

/* Puts a copy whose middle is at `middle` (mm) on an axis of n_page pixels. */
static double put(const axis *a, int n_page, double *middle, int *out_first)
{
    const double first = 0.5 * n_page + *middle / a->pixel - 0.5 * a->n_pixels;
    *out_first = (int)lround(first);
    const double of_pixels = (*out_first + 0.5 * a->n_pixels - 0.5 * n_page) * a->pixel;
    if (a->whole)
        *middle = of_pixels;
    return *middle - of_pixels;
}

/* Middles of all copies, before they are put on the page's pixels. */
static void place_copies(lf_sheet *sheet, const lf_print *print, const axis *right,
                         const axis *down)
{
    const double sine = lf_print_sin(print), pitch = sheet->mechanical_mm;
    for (int i = 0; i < sheet->n_rows * sheet->n_columns; i++) {
        lf_copy *copy = &sheet->copies[i];
        const int column = units_of(right, i % sheet->n_columns),
                  row = units_of(down, i / sheet->n_columns);
        copy->right_mm = column * right->unit;
        copy->down_mm = row * down->unit;
        copy->lens = print->horizontal ? row : column;
        if (print->optics.slant == 0.0 || print->optics.grid != LF_LENS_LINEAR)
            continue;
        /* the lens whose axis is nearest to the copy's middle goes through it */
        const double along = print->horizontal ? -copy->right_mm : copy->down_mm;
        copy->lens += (int)lround(along * sine / pitch);
        const double across = (copy->lens * pitch - along * sine) / lf_print_cos(print);
        *(print->horizontal ? &copy->down_mm : &copy->right_mm) = across;
    }
}

/* Pixels of the page along an axis, from the copy that is farthest from its middle. */
static lf_status page_of(const lf_print *print, const axis *a, double farthest, double band,
                         int margin, double paper, int *out, lf_error *err)
{
    const double half = farthest / a->pixel + 0.5 * a->n_pixels + band / a->pixel;
    const double content = ceil(2.0 * half - SNAP) + 2.0 * margin;
    const double page = paper > 0.0 ? round(paper / a->pixel) : content;
    if (content > page)
        return lf_error_set(err, LF_E_ARG, "print",
                            "the prints with labels and marks need %.1f mm, but the paper %gx%g "
                            "has %g mm there; use larger paper or fewer copies",
                            content * a->pixel, print->sheet.paper_width_mm,
                            print->sheet.paper_height_mm, paper);
    if (page * a->pixel > PAGE_MOST)
        return lf_error_set(err, LF_E_ARG, "print",
                            "the sheet is %.0f mm long; expected at most %g mm; use fewer copies",
                            page * a->pixel, PAGE_MOST);
    *out = (int)page;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- sheet -- */

static void mechanical_pitch(lf_sheet *sheet, const lf_print *print)
{
    const lf_optics *o = &print->optics;
    sheet->mechanical_known = o->thickness_mm > 0.0 && o->distance_mm > 0.0;
    sheet->mechanical_mm = lf_print_pitch_mm(print) / lf_lens_enlargement_of(print);
}

static void find_extent(const lf_sheet *sheet, double *out_right, double *out_down)
{
    *out_right = *out_down = 0.0;
    for (int i = 0; i < sheet->n_rows * sheet->n_columns; i++) {
        *out_right = fmax(*out_right, fabs(sheet->copies[i].right_mm));
        *out_down = fmax(*out_down, fabs(sheet->copies[i].down_mm));
    }
}

lf_status lf_sheet_init(lf_sheet *sheet, const lf_print *print, const lf_print_shape *shape,
                        lf_error *err)
{
    const lf_print_sheet *s = &print->sheet;
    memset(sheet, 0, sizeof *sheet);
    sheet->n_columns = s->columns > 0 ? s->columns : 1;
    sheet->n_rows = s->rows > 0 ? s->rows : 1;
    mechanical_pitch(sheet, print);
    lf_status status = take_label(sheet, print, err);
    if (status != LF_OK)
        return status;
    const axis right = axis_of(print, shape, sheet, false),
               down = axis_of(print, shape, sheet, true);
    sheet->step_right_mm = right.step * right.unit;
    sheet->step_down_mm = down.step * down.unit;
    sheet->copies =
        lf_calloc((size_t)sheet->n_rows * (size_t)sheet->n_columns, sizeof *sheet->copies);
    if (!sheet->copies)
        return lf_error_set(err, LF_E_NOMEM, "print", "out of memory");
    place_copies(sheet, print, &right, &down);
    const double band = lf_sheet_band(sheet);
    double far_right, far_down;
    find_extent(sheet, &far_right, &far_down);
    sheet->half_right = far_right + (0.5 * print->width_mm + print->bleed_mm);
    sheet->half_down = far_down + (0.5 * print->height_mm + print->bleed_mm) + band;
    status = page_of(print, &right, far_right, 0.0, shape->margin_px, s->paper_width_mm,
                     &sheet->width, err);
    if (status == LF_OK)
        status = page_of(print, &down, far_down, band, shape->margin_down_px, s->paper_height_mm,
                         &sheet->height, err);
    if (status != LF_OK)
        lf_sheet_finish(sheet);
    for (int i = 0; status == LF_OK && i < sheet->n_rows * sheet->n_columns; i++) {
        lf_copy *copy = &sheet->copies[i];
        copy->shift_right_mm = put(&right, sheet->width, &copy->right_mm, &copy->left);
        copy->shift_down_mm = put(&down, sheet->height, &copy->down_mm, &copy->top);
    }
    return status;
}

void lf_sheet_finish(lf_sheet *sheet)
{
    lf_free(sheet->copies);
    memset(sheet, 0, sizeof *sheet);
}

/* ------------------------------------------------------------------------------------- notes -- */

/* Of a usual sheet, for copies whose sheet is unknown: 0.6 mm thick, seen from 400 mm. */
#define USUAL_STRETCH (0.6 / (LF_USUAL_INDEX * 400.0))

static void note_pitch(const lf_sheet *sheet, const lf_print *print, lf_image_notes *notes)
{
    double right, down;
    find_extent(sheet, &right, &down);
    const double farthest = print->horizontal ? down : right;
    if (!sheet->mechanical_known && farthest > 0.0)
        lf_image_note(notes,
                      "the sheet's own pitch is unknown, so copies are placed by the visual one: "
                      "the outermost may be %.2f mm off their lens; give thickness and distance",
                      farthest * USUAL_STRETCH);
}

static void note_label(const lf_sheet *sheet, const lf_print *print, lf_image_notes *notes)
{
    const double asked = print->sheet.label_mm > 0.0 ? print->sheet.label_mm : USUAL_LABEL;
    if (!(sheet->label_mm > 0.0))
        return;
    if (strcmp(sheet->label, print->sheet.label) != 0)
        lf_image_note(notes, "the label is printed as \"%s\": its font has only ASCII characters",
                      sheet->label);
    if (sheet->label_mm < asked - SNAP)
        lf_image_note(notes, "the label is %.2g mm high instead of %.2g mm, to fit below the print",
                      sheet->label_mm, asked);
}

void lf_print_note_sheet(const lf_print *print, int n_images, lf_image_notes *notes)
{
    lf_print_shape shape;
    lf_sheet sheet;
    lf_print_shape_of(print, &shape);
    lf_flip_note(print, n_images, notes);
    if (lf_sheet_init(&sheet, print, &shape, NULL) != LF_OK)
        return;
    note_pitch(&sheet, print, notes);
    note_label(&sheet, print, notes);
    lf_sheet_finish(&sheet);
}

char *lf_print_layout_text(const lf_print *print, int n_images, char *buf, size_t size)
{
    lf_print_shape shape;
    lf_sheet sheet;
    char stripes[256], copies[96] = "", of[48] = "";
    lf_print_shape_of(print, &shape);
    lf_flip_text(print, n_images, stripes, sizeof stripes);
    if (lf_sheet_init(&sheet, print, &shape, NULL) == LF_OK && sheet.n_columns * sheet.n_rows > 1)
        snprintf(copies, sizeof copies, "%dx%d copies, %.2f mm apart across and %.2f mm down",
                 sheet.n_columns, sheet.n_rows, sheet.step_right_mm, sheet.step_down_mm);
    lf_sheet_finish(&sheet);
    if (print->sheet.guard == 0 && print->sheet.morph == 0)
        snprintf(of, sizeof of, " (%d of %d)", print->n_views, n_images);
    snprintf(buf, size, "%s%s%s%s%s", copies, copies[0] && stripes[0] ? "; " : "",
             stripes[0] ? "images under a lens: " : "", stripes, stripes[0] ? of : "");
    return buf;
}
