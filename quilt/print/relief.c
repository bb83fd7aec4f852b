#include "quilt/print/relief.h"

#include <math.h>
#include <string.h>

#include "quilt/print/sheet.h"

/* ----------------------------------------------------------------------------------- numbers -- */

/* Thickness behind which a lens shows this angle: its edge rays meet the print at the edges of the
 * cell. */
static double thickness_of_angle(double angle, double pitch, double index)
{
    return 0.5 * pitch / tan(asin(sin(0.5 * angle * LF_DEGREE) / index));
}

static void choose_radius(lf_relief *relief)
{
    const lf_optics *o = &relief->print->optics;
    const double n = lf_optics_index(o);
    const double behind = o->thickness_mm > 0.0 ? o->thickness_mm
                          : o->angle > 0.0      ? thickness_of_angle(o->angle, relief->pitch_mm, n)
                                                : 0.0;
    relief->from = o->radius_mm > 0.0      ? "radius"
                   : o->thickness_mm > 0.0 ? "thickness"
                   : o->angle > 0.0        ? "viewing angle"
                                           : NULL;
    relief->radius_mm = o->radius_mm > 0.0 ? o->radius_mm : behind * (n - 1.0) / n;
    relief->focal_mm = relief->radius_mm * n / (n - 1.0);
    relief->thickness_mm = behind > 0.0 ? behind : relief->focal_mm;
}

/* From the axis to the farthest point of a cell. */
static double reach_of(const lf_relief *relief)
{
    const lf_lens_grid grid = relief->print->optics.grid;
    return relief->pitch_mm * (grid == LF_LENS_SQUARE      ? sqrt(0.5)
                               : grid == LF_LENS_HEXAGONAL ? sqrt(1.0 / 3.0)
                                                           : 0.5);
}

lf_status lf_relief_of(const lf_print *print, lf_relief *out, lf_error *err)
{
    const lf_optics *o = &print->optics;
    lf_relief relief = {.print = print,
                        .pitch_mm = lf_print_pitch_mm(print) / lf_lens_enlargement_of(print),
                        .is_mechanical = o->thickness_mm > 0.0 && o->distance_mm > 0.0,
                        .cosine = lf_print_cos(print),
                        .sine = lf_print_sin(print)};
    choose_radius(&relief);
    relief.reach_mm = reach_of(&relief);
    if (!relief.from)
        return lf_error_set(err, LF_E_ARG, "relief",
                            "needs the radius, the thickness or the viewing angle of the lenses");
    if (relief.radius_mm < relief.reach_mm)
        return lf_error_set(err, LF_E_ARG, "relief",
                            "a radius of %.4g mm (from the %s) spans no lens of %.4g mm; use at "
                            "least %.4g mm or a finer pitch",
                            relief.radius_mm, relief.from, relief.pitch_mm, relief.reach_mm);
    relief.sag_mm = relief.radius_mm -
                    sqrt(relief.radius_mm * relief.radius_mm - relief.reach_mm * relief.reach_mm);
    if (relief.sag_mm > relief.thickness_mm)
        return lf_error_set(err, LF_E_ARG, "relief",
                            "lenses %.4g mm high do not fit in a sheet of %.4g mm; use a larger "
                            "radius or thickness",
                            relief.sag_mm, relief.thickness_mm);
    *out = relief;
    return LF_OK;
}

double lf_relief_spot(const lf_relief *relief)
{
    return 2.0 * relief->reach_mm * fabs(relief->thickness_mm - relief->focal_mm) /
           relief->focal_mm;
}

void lf_relief_note(const lf_relief *relief, lf_image_notes *notes)
{
    const double stripe =
        relief->pitch_mm * lf_print_view_rows(relief->print) / relief->print->n_views;
    if (lf_relief_spot(relief) > stripe)
        lf_image_note(notes,
                      "relief: lenses of radius %.4g mm focus at %.4g mm, but the print lies at "
                      "%.4g mm; their spot is %.3g mm wide, a stripe %.3g mm",
                      relief->radius_mm, relief->focal_mm, relief->thickness_mm,
                      lf_relief_spot(relief), stripe);
    if (!relief->is_mechanical)
        lf_image_note(notes,
                      "relief: its pitch is that of the stripes; give thickness and distance for "
                      "the pitch of the sheet");
}

/* ----------------------------------------------------------------------------------- heights -- */

static double from_whole(double v)
{
    return v - round(v);
}

/* Squared distance from the nearest lens of a hexagonal grid, in pitches. */
static double hexagonal_distance(double u, double v)
{
    const double height = sqrt(0.75), low = floor(v / height);
    double least = HUGE_VAL;
    for (double row = low; row <= low + 1.0; row++) {
        const double across = from_whole(u - 0.5 * fmod(fabs(row), 2.0)), down = v - row * height;
        least = fmin(least, across * across + down * down);
    }
    return least;
}

double lf_relief_height(const lf_relief *relief, double x, double y)
{
    const lf_print *print = relief->print;
    const double right = x * relief->cosine + y * relief->sine,
                 down = -x * relief->sine + y * relief->cosine;
    const double u = ((print->horizontal ? down : right) - print->phase_mm) / relief->pitch_mm,
                 v = (down - print->optics.phase_down_mm) / relief->pitch_mm;
    const double across = from_whole(u), r = relief->radius_mm;
    const double distance = print->optics.grid == LF_LENS_SQUARE
                                ? across * across + from_whole(v) * from_whole(v)
                            : print->optics.grid == LF_LENS_HEXAGONAL ? hexagonal_distance(u, v)
                                                                      : across * across;
    const double height = sqrt(fmax(r * r - distance * relief->pitch_mm * relief->pitch_mm, 0.0)) -
                          (r - relief->sag_mm);
    return fmax(height, 0.0);
}

/* -------------------------------------------------------------------------------------- file -- */

typedef struct drawing {
    const lf_relief *relief;
    lf_print_shape shape;
    lf_sheet sheet;
} drawing;

/* One lens sheet lies over all copies; between them it is flat. */
static void draw_row(void *context, int y, float *row)
{
    const drawing *d = context;
    const lf_print *print = d->relief->print;
    const double right_mm = 25.4 / print->dpi, down_mm = 25.4 / lf_print_dpi_down(print),
                 down = (y + 0.5 - 0.5 * d->sheet.height) * down_mm;
    memset(row, 0, (size_t)d->sheet.width * sizeof *row);
    for (int i = 0; i < d->sheet.n_rows * d->sheet.n_columns; i++) {
        const lf_copy *copy = &d->sheet.copies[i];
        if (y < copy->top || y >= copy->top + d->shape.raster_height)
            continue;
        for (int x = copy->left; x < copy->left + d->shape.raster_width; x++)
            row[x] = (float)(lf_relief_height(d->relief,
                                              (x + 0.5 - 0.5 * d->sheet.width) * right_mm, down) /
                             d->relief->sag_mm);
    }
}

lf_status lf_relief_write(const lf_relief *relief, const lf_print_run *run, lf_outfile *file,
                          lf_error *err)
{
    drawing d = {.relief = relief};
    void *hands[LF_PRINT_MAX_HANDS];
    lf_print_run as_tiff = *run;
    char description[160];
    as_tiff.format = LF_PRINT_TIFF;
    as_tiff.progress = NULL; /* the print is reported */
    lf_print_shape_of(relief->print, &d.shape);
    lf_status status = lf_sheet_init(&d.sheet, relief->print, &d.shape, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < LF_PRINT_MAX_HANDS; i++)
        hands[i] = &d;
    snprintf(description, sizeof description,
             "lens relief: black 0 mm, white %.6g mm; radius %.6g mm, pitch %.8g mm",
             relief->sag_mm, relief->radius_mm, relief->pitch_mm);
    const lf_print_page page = {.print = relief->print,
                                .width = d.sheet.width,
                                .height = d.sheet.height,
                                .description = description,
                                .draw = draw_row,
                                .hands = hands,
                                .n_hands = lf_print_hands(run)};
    status = lf_print_page_write(&page, NULL, &as_tiff, 0, file, err);
    lf_sheet_finish(&d.sheet);
    return status;
}
