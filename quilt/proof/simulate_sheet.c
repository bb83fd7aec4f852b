/* The sheet that a print lies under. */
#include <jansson.h>
#include <math.h>
#include <string.h>

#include "quilt/lens.h"
#include "quilt/profiles.h"
#include "quilt/proof/simulate.h"
#include "quilt/proof/simulate_weight.h"

#define MM_PER_INCH 25.4
/* Light inside the sheet that does not leave it: an eye at 80 degrees sees the rest. */
#define MOST_SINE 0.985
/* Copies are within this distance from the middle of their page, mm. */
#define MOST_ASIDE 1e4

static double spot_of(const lf_print *print, int n_views)
{
    return print->blur.spot_mm > 0.0 ? print->blur.spot_mm
                                     : 0.5 * MM_PER_INCH / print->lpi / n_views;
}

/* Across the lenses. */
static int views_of(const lf_print *print)
{
    const double dpi = print->horizontal && print->dpi_down > 0.0 ? print->dpi_down : print->dpi;
    const int usual = (int)floor(0.8 * dpi / print->lpi);
    if (print->n_views > 0)
        return print->n_views / lf_print_view_rows(print);
    return usual > 2 ? usual : 2;
}

void lf_proof_sheet_of(const lf_print *print, lf_proof_sheet *out, lf_image_notes *notes)
{
    const lf_optics *o = &print->optics;
    const double slant = o->slant * LF_DEGREE, visual_mm = MM_PER_INCH / print->lpi;
    const double index = lf_optics_index(o);
    const double angle = o->angle > 0.0 ? o->angle : LF_PROOF_ANGLE;
    const double thickness =
        o->thickness_mm > 0.0 ? o->thickness_mm : lf_profile_thickness(print->lpi, angle, index);
    const double distance = o->distance_mm > 0.0 ? o->distance_mm : LF_PROOF_DISTANCE;
    const double row = o->grid == LF_LENS_HEXAGONAL ? sqrt(0.75) : 1.0;
    if (o->thickness_mm <= 0.0)
        lf_image_note(
            notes,
            "the sheet's thickness is not known; %.3g mm is %s viewing angle of %.3g degrees",
            thickness, o->angle > 0.0 ? "from its" : "for a usual", angle);
    if (o->distance_mm <= 0.0)
        lf_image_note(
            notes,
            "the viewing distance is not known; the pitch is taken to be measured from %.3g mm",
            distance);
    const int n_views = views_of(print);
    *out = (lf_proof_sheet){
        .pitch_mm = visual_mm / lf_lens_enlargement(thickness, index, distance),
        .right = print->horizontal ? -sin(slant) : cos(slant),
        .down = print->horizontal ? cos(slant) : sin(slant),
        .horizontal = print->horizontal,
        .grid = o->grid,
        .offset = print->phase_mm / visual_mm,
        .offset_down = o->phase_down_mm / (visual_mm * row),
        .thickness_mm = thickness,
        .index = index,
        .distance_mm = distance,
        .spot_mm = spot_of(print, n_views),
        .ink_mm = print->blur.ink_mm,
        .dot_gain = print->blur.dot_gain,
        .width_mm = print->width_mm,
        .height_mm = print->height_mm,
        .mirror = print->mirror,
        .pixel_mm = {MM_PER_INCH / print->dpi,
                     MM_PER_INCH / (print->dpi_down > 0.0 ? print->dpi_down : print->dpi)},
        .n_views = n_views,
    };
    lf_proof_fit_spots(print, out->pixel_mm[print->horizontal ? 1 : 0], out);
}

double lf_proof_visual_mm(const lf_proof_sheet *sheet, double distance_mm)
{
    return sheet->pitch_mm * lf_lens_enlargement(sheet->thickness_mm, sheet->index, distance_mm);
}

double lf_proof_eye_at(const lf_proof_sheet *sheet, double distance_mm, double share)
{
    const double t = sheet->thickness_mm, n = sheet->index;
    const double cell = lf_proof_visual_mm(sheet, sheet->distance_mm);
    const double sine = n * sin(atan(share * cell / t));
    return distance_mm * tan(asin(fmin(fmax(sine, -MOST_SINE), MOST_SINE)));
}

double lf_proof_view_range(const lf_proof_sheet *sheet, double distance_mm)
{
    return 2.0 * lf_proof_eye_at(sheet, distance_mm, 0.5);
}

double lf_proof_view_step(const lf_proof_sheet *sheet, double distance_mm)
{
    return 2.0 * lf_proof_eye_at(sheet, distance_mm, 0.5 / sheet->n_views);
}

/* ---------------------------------------------------------------------------------- the page -- */

/* Lenses count from the middle of the page. Whole lenses do not matter. */
static void move_lenses(lf_proof_sheet *sheet)
{
    const double x = sheet->middle_right_mm, y = sheet->middle_down_mm;
    const double row_mm =
        sheet->grid == LF_LENS_HEXAGONAL ? sheet->pitch_mm * sqrt(0.75) : sheet->pitch_mm;
    double lenses = (x * sheet->right + y * sheet->down) / sheet->pitch_mm;
    const double rows = (sheet->horizontal ? x * sheet->down - y * sheet->right
                                           : y * sheet->right - x * sheet->down) /
                        row_mm;
    if (sheet->grid == LF_LENS_HEXAGONAL && fmod(fabs(round(rows)), 2.0) == 1.0)
        lenses -= 0.5;
    sheet->offset -= lenses - round(lenses);
    sheet->offset_down -= rows - round(rows);
}

lf_status lf_proof_take_copy(const json_t *manifest, const char *where, lf_proof_sheet *sheet,
                             int *out_columns, int *out_rows, lf_error *err)
{
    const json_t *page = json_object_get(manifest, "sheet");
    const json_t *middle =
        json_object_get(json_array_get(json_object_get(page, "copies"), 0), "middle_mm");
    const double right = json_number_value(json_array_get(middle, 0)),
                 down = json_number_value(json_array_get(middle, 1));
    const json_int_t columns = json_integer_value(json_object_get(page, "columns")),
                     rows = json_integer_value(json_object_get(page, "rows"));
    *out_columns = *out_rows = 1;
    if (!json_is_object(page))
        return LF_OK;
    if (!middle || !(fabs(right) <= MOST_ASIDE) || !(fabs(down) <= MOST_ASIDE) || columns < 1 ||
        rows < 1 || columns > LF_COPIES_MOST || rows > LF_COPIES_MOST)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "has a manifest whose copies have no place; write the print again");
    sheet->middle_right_mm = sheet->mirror ? -right : right;
    sheet->middle_down_mm = down;
    move_lenses(sheet);
    *out_columns = (int)columns;
    *out_rows = (int)rows;
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- manifest -- */

/* Raster and size as the file has them. */
static void from_tags(const lf_print_tags *tags, lf_print *out)
{
    out->dpi = tags->dpi[0];
    out->dpi_down = tags->dpi[1] != tags->dpi[0] ? tags->dpi[1] : 0.0;
    out->width_mm = tags->dpi[0] > 0.0 ? tags->width * MM_PER_INCH / tags->dpi[0] : 0.0;
    out->height_mm = tags->dpi[1] > 0.0 ? tags->height * MM_PER_INCH / tags->dpi[1] : 0.0;
}

static lf_status check_raster(const json_t *manifest, const lf_print_tags *tags, const char *where,
                              lf_error *err)
{
    const json_t *raster = json_object_get(json_object_get(manifest, "size"), "raster_px");
    const json_int_t width = json_integer_value(json_array_get(raster, 0)),
                     height = json_integer_value(json_array_get(raster, 1));
    if (!json_is_array(raster) || (width == tags->width && height == tags->height))
        return LF_OK;
    return lf_error_set(err, LF_E_FORMAT, where,
                        "has %dx%d pixels, but its manifest says %lldx%lld; something resized it",
                        tags->width, tags->height, (long long)width, (long long)height);
}

/* A manifest has all options; those that were not given are 0 or null, often out of range. A new
 * reference; NULL: out of memory. */
static json_t *given_options(json_t *options)
{
    json_t *given = json_object(), *value;
    const char *key;
    json_object_foreach(options, key, value)
    {
        const bool is_given =
            !json_is_null(value) && !(json_is_number(value) && json_number_value(value) == 0.0);
        if (given && is_given && json_object_set(given, key, value) != 0) {
            json_decref(given);
            given = NULL;
        }
    }
    return given;
}

lf_status lf_proof_print_of(const lf_print_file *file, const json_t *manifest, const char *where,
                            lf_print *out, lf_error *err)
{
    const lf_print_tags *tags = lf_print_file_tags(file);
    json_t *options = json_object_get(manifest, "options");
    lf_param_defaults(lf_print_params, out);
    from_tags(tags, out);
    if (json_object_get(manifest, "chart"))
        return lf_error_set(err, LF_E_FORMAT, where, "is a chart; it has no views to simulate");
    if (!options)
        return LF_OK;
    json_t *given = given_options(options);
    lf_status status = given ? check_raster(manifest, tags, where, err)
                             : lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    if (status == LF_OK && lf_param_from_json(lf_print_params, given, out, where, err) != LF_OK)
        status = LF_E_FORMAT;
    if (status == LF_OK)
        status = lf_print_take_crosstalk(manifest, where, &out->blur, err);
    json_decref(given);
    return status;
}
