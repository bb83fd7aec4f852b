/* What profiles give to a print, and the pitch at a distance. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "quilt/lens.h"
#include "quilt/profile/profile.h"

/* Distances that differ by less are one. */
#define SAME_MM 0.05

/* ------------------------------------------------------------------------------------ optics -- */

double lf_profile_pitch(double lpi, double from_mm, double to_mm, double thickness_mm, double index)
{
    return lpi * lf_lens_enlargement(thickness_mm, index, from_mm) /
           lf_lens_enlargement(thickness_mm, index, to_mm);
}

double lf_profile_thickness(double lpi, double angle, double index)
{
    const double inside = asin(sin(0.5 * angle * LF_DEGREE) / index);
    return 0.5 * (25.4 / lpi) / tan(inside);
}

double lf_profile_angle(double lpi, double thickness_mm, double index)
{
    const double sine = index * sin(atan(0.5 * (25.4 / lpi) / thickness_mm));
    return sine < 1 ? 2 * asin(sine) / LF_DEGREE : 180;
}

/* ------------------------------------------------------------------------------------- given -- */

bool lf_print_is_given(const lf_print_given *given, const char *key)
{
    for (int i = 0; i < given->n; i++)
        if (strcmp(given->keys[i], key) == 0)
            return true;
    return false;
}

static void give(lf_print_given *given, const char *key)
{
    if (!lf_print_is_given(given, key) &&
        given->n < (int)(sizeof given->keys / sizeof *given->keys))
        given->keys[given->n++] = key;
}

void lf_print_give(lf_print_given *given, const lf_param *row)
{
    for (const lf_param *end = lf_param_next(row); row < end; row++)
        give(given, row->name ? row->name : row->option);
}

lf_print_given lf_print_given_in(const json_t *values)
{
    lf_print_given given = {0};
    for (const lf_param *row = lf_print_params; row->name || row->option; row++)
        if (row->name && json_object_get(values, row->name))
            give(&given, row->name);
    return given;
}

/* ------------------------------------------------------------------------------------- apply -- */

typedef struct filling {
    const lf_lens_profile *lens;
    const lf_printer_profile *printer;
    const lf_print_given *given;
    lf_print *print;
    lf_profile_told *told;
    lf_error *err;
    char line[512]; /* about the lens */
} filling;

/* The number of the profile, for a key that was not given; 0 may be "unknown". */
static void fill(const filling *f, const char *key, double value, double *out)
{
    if (!lf_print_is_given(f->given, key))
        *out = value;
}

/* A number that the profile knows. */
static void fill_known(const filling *f, const char *key, double known, double *out)
{
    if (known != 0)
        fill(f, key, known, out);
}

static void say(filling *f, const char *what)
{
    const size_t used = strlen(f->line);
    snprintf(f->line + used, sizeof f->line - used, "%s%s", used > 0 ? ", " : "", what);
}

static void say_number(filling *f, const char *name, double value, const char *unit)
{
    char what[96];
    snprintf(what, sizeof what, "%s %.6g%s%s", name, value, unit[0] != '\0' ? " " : "", unit);
    say(f, what);
}

static void take_sheet(filling *f)
{
    const lf_lens_profile *lens = f->lens;
    lf_optics *optics = &f->print->optics;
    fill(f, "thickness", lens->optics.thickness_mm, &optics->thickness_mm);
    fill(f, "index", lens->optics.index, &optics->index);
    fill(f, "radius", lens->optics.radius_mm, &optics->radius_mm);
    fill(f, "viewing_angle", lens->optics.angle, &optics->angle);
    fill(f, "slant", lens->optics.slant, &optics->slant);
    fill(f, "spot", lens->spot_mm, &f->print->blur.spot_mm);
    f->print->blur.n_crosstalk = 0;
    if (!lf_print_is_given(f->given, "lens_grid"))
        optics->grid = lens->optics.grid;
    if (lens->has_horizontal && !lf_print_is_given(f->given, "orientation"))
        f->print->horizontal = lens->horizontal;
    if (optics->thickness_mm > 0 || !(optics->angle > 0))
        return;
    optics->thickness_mm =
        lf_profile_thickness(lens->pitch_lpi, optics->angle, lf_optics_index(optics));
    lf_image_note(&f->told->warnings,
                  "%s: the thickness is unknown; %.3f mm follow from the viewing angle",
                  lens->file.name, optics->thickness_mm);
}

static void say_sheet(filling *f)
{
    const lf_optics *optics = &f->print->optics;
    if (f->lens->optics.thickness_mm > 0 && !lf_print_is_given(f->given, "thickness"))
        say_number(f, "thickness", optics->thickness_mm, "mm");
    if (f->lens->optics.index > 0 && !lf_print_is_given(f->given, "index"))
        say_number(f, "index", optics->index, "");
    else if (optics->thickness_mm > 0 && !(optics->index > 0))
        say_number(f, "index unknown, taken as", lf_optics_index(optics), "");
    if (f->lens->optics.slant != 0 && !lf_print_is_given(f->given, "slant"))
        say_number(f, "slant", optics->slant, "degrees");
    if (f->lens->has_horizontal && !lf_print_is_given(f->given, "orientation"))
        say(f, f->print->horizontal ? "horizontal lenses" : "vertical lenses");
}

/* The lenses of a chart run as those of the sheet, or else vertically, unless the calibration says
 * otherwise. */
static bool was_horizontal(const filling *f, const lf_lens_calibration *c)
{
    return c->has_horizontal ? c->horizontal : f->lens->has_horizontal && f->lens->horizontal;
}

/* The calibration with this printer that is nearest to the wanted distance; NULL = none. *out_n
 * counts those with the printer. any: also of lenses that run otherwise than the print's. */
static const lf_lens_calibration *nearest(const filling *f, bool any, int *out_n)
{
    const lf_lens_calibration *best = NULL;
    const double wanted = f->print->optics.distance_mm;
    *out_n = 0;
    for (int i = 0; f->printer && i < f->lens->n_calibrations; i++) {
        const lf_lens_calibration *c = &f->lens->calibrations[i];
        if (strcmp(c->printer, f->printer->file.name) != 0 ||
            (!any && was_horizontal(f, c) != f->print->horizontal))
            continue;
        ++*out_n;
        if (!best || fabs(c->distance_mm - wanted) < fabs(best->distance_mm - wanted))
            best = c;
    }
    return best;
}

static void take_phase(const filling *f, const lf_lens_calibration *c)
{
    const bool horizontal = was_horizontal(f, c);
    if (lf_print_is_given(f->given, "phase") || !f->printer->registered)
        return;
    if (horizontal == f->print->horizontal) {
        f->print->phase_mm = c->phase_mm;
        return;
    }
    lf_image_note(&f->told->warnings,
                  "%s was measured with %s lenses, so the phase of %s ones is unknown; measure a "
                  "chart with --orientation %s",
                  f->lens->file.name, horizontal ? "horizontal" : "vertical",
                  horizontal ? "vertical" : "horizontal", horizontal ? "vertical" : "horizontal");
}

static void say_measured(filling *f, const lf_lens_calibration *c)
{
    char what[160];
    const bool wanted = !lf_print_is_given(f->given, "phase"), registered = f->printer->registered;
    if (wanted && registered && was_horizontal(f, c) == f->print->horizontal)
        say_number(f, "phase", c->phase_mm, "mm");
    if (wanted && !registered && c->phase_mm != 0) {
        snprintf(what, sizeof what, "phase %+.4g mm not applied, because %s is not registered",
                 c->phase_mm, f->printer->file.name);
        say(f, what);
    }
    if (c->reverse && !lf_print_is_given(f->given, "reverse"))
        say(f, "views in reverse order");
    if (c->n_crosstalk > 0)
        say(f, "crosstalk");
}

static void take_measured(const filling *f, const lf_lens_calibration *c)
{
    take_phase(f, c);
    if (!lf_print_is_given(f->given, "reverse"))
        f->print->reverse = c->reverse;
    f->print->blur.n_crosstalk = c->n_crosstalk;
    f->print->blur.crosstalk_views = c->crosstalk_views;
    memcpy(f->print->blur.crosstalk, c->crosstalk, sizeof c->crosstalk);
}

static lf_status take_calibration(filling *f, const lf_lens_calibration *c, int n)
{
    lf_print *print = f->print;
    lf_optics *optics = &print->optics;
    char what[256], from[96];
    if (!lf_print_is_given(f->given, "distance") && n > 1)
        return lf_error_set(f->err, LF_E_ARG, "--distance",
                            "is needed; %s has %d calibrations with %s, one of them for %g mm",
                            f->lens->file.name, n, f->printer->file.name, c->distance_mm);
    const double wanted =
        lf_print_is_given(f->given, "distance") ? optics->distance_mm : c->distance_mm;
    const bool is_same = fabs(wanted - c->distance_mm) <= SAME_MM;
    if (!is_same && !(optics->thickness_mm > 0))
        return lf_error_set(
            f->err, LF_E_ARG, "--distance",
            "%g mm: %s was measured at %g mm, and its thickness is unknown; give the "
            "thickness, too",
            wanted, f->lens->file.name, c->distance_mm);
    take_measured(f, c);
    optics->distance_mm = wanted;
    print->lpi = is_same ? c->visual_lpi
                         : lf_profile_pitch(c->visual_lpi, c->distance_mm, wanted,
                                            optics->thickness_mm, lf_optics_index(optics));
    f->told->pitch_kind = is_same ? "visual, as measured" : "visual, from one that was measured";
    from[0] = '\0';
    if (!is_same)
        snprintf(from, sizeof from, "computed for %g mm from %.4f lpi ", wanted, c->visual_lpi);
    snprintf(what, sizeof what, "%.4f lpi %sat %g mm, measured%s%s with %s", print->lpi, from,
             c->distance_mm, c->date[0] != '\0' ? " on " : "", c->date, c->printer);
    say(f, what);
    say_measured(f, c);
    return LF_OK;
}

/* The pitch from the mechanical one, which no chart has confirmed. */
static lf_status compute_pitch(filling *f)
{
    const lf_lens_profile *lens = f->lens;
    const lf_optics *optics = &f->print->optics;
    char what[128];
    if (!(optics->distance_mm > 0))
        return lf_error_set(f->err, LF_E_ARG, "--distance",
                            "is needed, because %s has no calibration with %s%s", lens->file.name,
                            f->printer ? "" : "a printer", f->printer ? f->printer->file.name : "");
    f->print->lpi = lf_profile_pitch(lens->pitch_lpi, 0, optics->distance_mm, optics->thickness_mm,
                                     lf_optics_index(optics));
    snprintf(what, sizeof what, "%.4f lpi computed for %g mm from %g lpi", f->print->lpi,
             optics->distance_mm, lens->pitch_lpi);
    say(f, what);
    f->told->pitch_kind = "visual, computed, not measured";
    lf_image_note(&f->told->warnings,
                  "%s: the pitch is not measured; print a chart and keep its result with "
                  "quiltprint calibrate",
                  lens->file.name);
    if (!(optics->thickness_mm > 0))
        lf_image_note(&f->told->warnings,
                      "%s: the thickness is unknown, so the pitch is that seen from far away",
                      lens->file.name);
    return LF_OK;
}

static lf_status take_pitch(filling *f)
{
    int n = 0;
    if (lf_print_is_given(f->given, "lpi"))
        return LF_OK;
    const lf_lens_calibration *c = nearest(f, false, &n);
    if (!c)
        c = nearest(f, true, &n);
    return c ? take_calibration(f, c, n) : compute_pitch(f);
}

/* ------------------------------------------------------------------------------- the printer -- */

static void warn_of_raster(const filling *f)
{
    const double used[] = {f->print->dpi,
                           f->print->dpi_down > 0 ? f->print->dpi_down : f->print->dpi};
    for (int k = 0; k < 2 && f->printer->n_native > 0; k++) {
        int i = 0;
        while (i < f->printer->n_native && f->printer->native_dpi[i] != used[k])
            i++;
        if (i < f->printer->n_native)
            continue;
        lf_image_note(&f->told->warnings,
                      "%g dpi is not a native resolution of %s; its driver will resample the print",
                      used[k], f->printer->file.name);
        return;
    }
}

static void take_printer(const filling *f)
{
    const lf_printer_profile *printer = f->printer;
    lf_print *print = f->print;
    const bool raster = !lf_print_is_given(f->given, "dpi"),
               icc = !lf_print_is_given(f->given, "icc");
    fill_known(f, "dot_gain", printer->dot_gain, &print->blur.dot_gain);
    fill_known(f, "ink_spread", printer->ink_mm, &print->blur.ink_mm);
    if (raster) {
        print->dpi = printer->dpi;
        print->dpi_down = printer->dpi_down;
    }
    if (icc && printer->icc[0] != '\0')
        print->icc_path = printer->icc;
    warn_of_raster(f);
    if (raster && print->dpi_down > 0 && print->dpi_down != print->dpi)
        lf_image_note(&f->told->lines, "printer %s: %gx%g dpi%s%s", printer->file.name, print->dpi,
                      print->dpi_down, icc && printer->icc[0] != '\0' ? ", " : "",
                      icc ? printer->icc : "");
    else
        lf_image_note(&f->told->lines, "printer %s: %g dpi%s%s%s", printer->file.name, print->dpi,
                      raster ? "" : " as given", icc && printer->icc[0] != '\0' ? ", " : "",
                      icc ? printer->icc : "");
}

lf_status lf_profile_apply(const lf_lens_profile *lens, const lf_printer_profile *printer,
                           const lf_print_given *given, lf_print *print, lf_profile_told *told,
                           lf_error *err)
{
    filling f = {
        .lens = lens, .printer = printer, .given = given, .print = print, .told = told, .err = err};
    *told = (lf_profile_told){0};
    if (!lens && !lf_print_is_given(given, "lpi"))
        return lf_error_set(err, LF_E_ARG, "--printer",
                            "the pitch is unknown; name a lens, or give the pitch");
    if (!printer && !lf_print_is_given(given, "dpi"))
        return lf_error_set(err, LF_E_ARG, "--lens",
                            "the raster is unknown; name a printer, or give the dpi");
    if (lens) {
        take_sheet(&f);
        lf_status status = take_pitch(&f);
        if (status != LF_OK)
            return status;
        say_sheet(&f);
        lf_image_note(&told->lines, "lens %s: %s", lens->file.name,
                      f.line[0] != '\0' ? f.line : "nothing, because options give all");
    }
    if (printer)
        take_printer(&f);
    return LF_OK;
}

/* ------------------------------------------------------------------------------- the account -- */

static json_t *lines_of(const lf_image_notes *notes)
{
    json_t *lines = json_array();
    char line[512];
    for (size_t at = 0; lf_image_notes_next(notes, &at, line, sizeof line);)
        json_array_append_new(lines, json_string(line));
    return lines;
}

static json_t *file_json(const lf_profile_file *file, const char *title)
{
    return json_pack("{s:s, s:s?, s:s}", "profile", file->name, "name",
                     title[0] != '\0' ? title : NULL, "sha256", file->sha256);
}

static void set_known(json_t *out, const char *key, double value)
{
    if (value != 0)
        json_object_set_new(out, key, json_real(value));
}

static json_t *lens_json(const lf_lens_profile *lens)
{
    json_t *out = file_json(&lens->file, lens->title);
    set_known(out, "pitch_lpi", lens->pitch_lpi);
    set_known(out, "thickness_mm", lens->optics.thickness_mm);
    set_known(out, "index", lens->optics.index);
    set_known(out, "radius_mm", lens->optics.radius_mm);
    set_known(out, "viewing_angle", lens->optics.angle);
    set_known(out, "slant", lens->optics.slant);
    set_known(out, "spot_mm", lens->spot_mm);
    return out;
}

static json_t *numbers_of(const double *values, int n)
{
    json_t *list = json_array();
    for (int i = 0; i < n; i++)
        json_array_append_new(list, json_real(values[i]));
    return list;
}

static json_t *printer_json(const lf_printer_profile *printer)
{
    json_t *out = file_json(&printer->file, printer->title);
    set_known(out, "dpi", printer->dpi);
    set_known(out, "dpi_down", printer->dpi_down);
    set_known(out, "dot_gain", printer->dot_gain);
    set_known(out, "ink_mm", printer->ink_mm);
    if (printer->n_native > 0)
        json_object_set_new(out, "native_dpi", numbers_of(printer->native_dpi, printer->n_native));
    return out;
}

json_t *lf_profile_account(const lf_lens_profile *lens, const lf_printer_profile *printer,
                           const lf_profile_told *told)
{
    return json_pack("{s:o*, s:o*, s:s*, s:o, s:o}", "lens", lens ? lens_json(lens) : NULL,
                     "printer", printer ? printer_json(printer) : NULL, "pitch_kind",
                     told->pitch_kind, "used", lines_of(&told->lines), "warnings",
                     lines_of(&told->warnings));
}

lf_status lf_profiles_open(const lf_profile_names *names, const lf_roots *roots,
                           const lf_print_given *given, lf_print *print, lf_profiles *out,
                           lf_error *err)
{
    const lf_lens_profile *lens = names->lens ? &out->lens : NULL;
    const lf_printer_profile *printer = names->printer ? &out->printer : NULL;
    lf_status status = LF_OK;
    if (!lens && !printer)
        return LF_OK;
    if (lens)
        status = lf_profile_lens_read(names->lens, roots, &out->lens, err);
    if (status == LF_OK && printer)
        status = lf_profile_printer_read(names->printer, roots, &out->printer, err);
    if (status == LF_OK)
        status = lf_profile_apply(lens, printer, given, print, &out->told, err);
    if (status != LF_OK)
        return status;
    out->account = lf_profile_account(lens, printer, &out->told);
    if (!out->account)
        return lf_error_set(err, LF_E_NOMEM, "profiles", "out of memory");
    print->profiles = out->account;
    if (printer && print->icc_path == printer->icc && !lf_profile_is_path(names->printer))
        print->icc_roots = NULL;
    return LF_OK;
}

void lf_profiles_finish(lf_profiles *profiles)
{
    json_decref(profiles->account);
    profiles->account = NULL;
}
