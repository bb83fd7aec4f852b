#include "quilt/proof/check.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "quilt/proof/check_internal.h"

#define MISFIT 1.6         /* of a mean square that is 1 for rounding alone */
#define LEAST_CONTRAST 3.0 /* of the same, half a stripe away */
#define BIG_FILE 4294967296.0

static const char *const names[LF_CHECK_POINTS] = {
    [CHECK_SIZE] = "pixel size",
    [CHECK_RESOLUTION] = "resolution",
    [CHECK_RASTER] = "the printer's raster",
    [CHECK_PROFILE] = "colour profile",
    [CHECK_LOSSLESS] = "lossless and upright",
    [CHECK_PITCH] = "pitch over the sheet",
    [CHECK_PHASE] = "phase in the middle",
    [CHECK_JITTER] = "jitter of stripes",
    [CHECK_ORDER] = "order of views",
    [CHECK_SHARE] = "own share of a view",
    [CHECK_RESAMPLED] = "no second resampling",
    [CHECK_VIEWS] = "number of views",
    [CHECK_DEPTH] = "depth",
    [CHECK_EDGES] = "bleed and marks",
    [CHECK_PDF] = "PDF boxes",
    [CHECK_MANIFEST] = "manifest",
    [CHECK_SAME] = "same bytes again",
    [CHECK_STORED] = "whole file",
};

const char *lf_check_point_name(int point)
{
    return names[point];
}

void lf_check_say(lf_check *check, int point, lf_check_result result, const char *limit,
                  const char *remedy, const char *format, ...)
{
    lf_check_point *at = &check->report->points[point];
    va_list arguments;
    at->result = result;
    va_start(arguments, format);
    vsnprintf(at->measured, sizeof at->measured, format, arguments);
    va_end(arguments);
    snprintf(at->limit, sizeof at->limit, "%s", limit ? limit : "");
    snprintf(at->remedy, sizeof at->remedy, "%s",
             remedy && (result == LF_CHECK_WARN || result == LF_CHECK_FAIL) ? remedy : "");
}

double lf_check_light(double code, int bits, double *out_slope)
{
    const double most = bits == 16 ? 65535.0 : 255.0, v = code / most;
    if (v <= 0.04045) {
        *out_slope = 1.0 / 12.92 / most;
        return v / 12.92;
    }
    const double base = (v + 0.055) / 1.055;
    *out_slope = 2.4 / 1.055 * pow(base, 1.4) / most;
    return pow(base, 2.4);
}

void lf_check_add_meter(lf_check *check, const lf_check_meter *meter)
{
    if (check->n_meters < CHECK_MAX_METERS)
        check->meters[check->n_meters++] = *meter;
}

bool lf_check_fit(const double *x_mm, const double *moved_um, const double *error_um, int n,
                  double width_mm, double limit_um, lf_check_meter *out)
{
    double s = 0.0, sx = 0.0, sm = 0.0, sxx = 0.0, sxm = 0.0;
    for (int b = 0; b < n; b++) {
        const double w = 1.0 / (error_um[b] * error_um[b]);
        s += w;
        sx += w * x_mm[b];
        sm += w * moved_um[b];
        sxx += w * x_mm[b] * x_mm[b];
        sxm += w * x_mm[b] * moved_um[b];
    }
    const double spread = s * sxx - sx * sx;
    if (n < 3 || !(spread > 0.0))
        return false;
    const double slope = (s * sxm - sx * sm) / spread, middle = (sm - slope * sx) / s;
    out->width_um = 1e3 * width_mm;
    out->pitch_um = slope * width_mm;
    out->phase_um = middle;
    out->error_um = 3.0 * fmax(sqrt(s / spread) * width_mm, sqrt(sxx / spread));
    out->jitter_um = 0.0;
    for (int b = 0; b < n; b++)
        out->jitter_um =
            fmax(out->jitter_um, fabs(moved_um[b] - middle - slope * x_mm[b]) - 4.0 * error_um[b]);
    return out->error_um <= limit_um;
}

/* ---------------------------------------------------------------------------------- verdicts -- */

/* Why pitch and phase are not measured. */
static void say_unmeasured(const lf_check *check, char *out, size_t size)
{
    const double pixels = check->dpi[check->print.horizontal ? 1 : 0] / check->print.lpi;
    if (!check->known || !check->file)
        snprintf(out, size, "not measured without a manifest and a readable file");
    else if (check->is_chart)
        snprintf(out, size, "a chart has no views");
    else if (!check->linear)
        snprintf(out, size,
                 check->laid ? "not measured on a page with several copies or a label"
                             : "not measured for micro lenses");
    else if (!check->fits)
        snprintf(out, size, "not measured: the file is not what the manifest describes");
    else if (check->print.compensation.on)
        snprintf(out, size, "not measured in a compensated picture, whose stripes are mixed");
    else if (!check->grid.can)
        snprintf(out, size,
                 "cannot be measured in this picture: %d views in %.4g pixels do not share enough",
                 check->print.n_views, pixels);
    else
        snprintf(out, size, "cannot be measured in this picture: its views differ too little");
}

static double number_of(const lf_check_meter *meter, int point)
{
    return point == CHECK_PITCH   ? meter->pitch_um
           : point == CHECK_PHASE ? meter->phase_um
                                  : meter->jitter_um;
}

/* One of the three numbers of all meters: the worst of them counts. */
static void judge_meters(lf_check *check, int point, double limit_um, const char *remedy)
{
    char limit[64], why[160];
    double worst = -INFINITY, value = 0.0;
    const lf_check_meter *at = NULL;
    snprintf(limit, sizeof limit, "at most %.3g um", limit_um);
    for (int i = 0; i < check->n_meters; i++) {
        const lf_check_meter *meter = &check->meters[i];
        const double here = number_of(meter, point);
        const double error = point == CHECK_JITTER ? 0.0 : meter->error_um;
        if (fabs(here) - error > worst) {
            worst = fabs(here) - error;
            value = here;
            at = meter;
        }
    }
    if (!at) {
        say_unmeasured(check, why, sizeof why);
        lf_check_say(check, point, LF_CHECK_NONE, limit, NULL, "%s", why);
        return;
    }
    lf_check_say(check, point, worst <= limit_um ? LF_CHECK_PASS : LF_CHECK_FAIL, limit, remedy,
                 point == CHECK_JITTER ? "%.2f um (%s)" : "%.2f um (%s), to %.2g um", value,
                 at->what, at->error_um);
}

static void judge_positions(lf_check *check)
{
    const bool nearest = check->print.stripes == LF_STRIPES_NEAREST;
    const double half_px =
        check->known ? 0.5 * 25400.0 / check->dpi[check->print.horizontal ? 1 : 0] : 0.0;
    judge_meters(check, CHECK_PITCH, nearest ? 3.0 : 1.0,
                 "The file was scaled, or has another pitch than the manifest; write it again.");
    judge_meters(check, CHECK_PHASE, 1.0,
                 "The picture was moved or cropped; write the print again.");
    judge_meters(check, CHECK_JITTER, nearest ? half_px : 0.5,
                 "Parts of the picture were moved or scaled; write the print again.");
}

static void judge_resampling(lf_check *check)
{
    static const char limit[] = "each pixel is made of the stripes that cover it";
    static const char remedy[] =
        "A program has resampled, sharpened or converted the picture; write the print again.";
    const lf_check_grid *grid = &check->grid;
    const bool nearest = check->print.stripes == LF_STRIPES_NEAREST;
    const bool absolute = nearest || grid->exact;
    const bool tells = grid->can && grid->contrast > (nearest ? 0.0 : LEAST_CONTRAST);
    char why[160];
    if (check->differing > 0)
        lf_check_say(check, CHECK_RESAMPLED, LF_CHECK_FAIL, limit, remedy,
                     "sampled rows differ from those that were written");
    else if (grid->can && absolute && grid->misfit > (nearest ? 0.0 : MISFIT))
        lf_check_say(check, CHECK_RESAMPLED, LF_CHECK_FAIL, limit, remedy,
                     nearest ? "pixels of one stripe differ by %.3g codes"
                             : "pixels differ from their stripes by %.3g roundings",
                     sqrt(grid->misfit));
    else if (tells && absolute)
        lf_check_say(check, CHECK_RESAMPLED, LF_CHECK_PASS, limit, NULL,
                     nearest ? "pixels of one stripe are equal"
                             : "pixels differ from their stripes by %.3g roundings",
                     sqrt(grid->misfit));
    else if (check->differing == 0)
        lf_check_say(check, CHECK_RESAMPLED, LF_CHECK_PASS, limit, NULL,
                     "sampled rows are those that were written");
    else if (tells && grid->misfit <= 1.3 * grid->at_best &&
             grid->contrast > LEAST_CONTRAST * grid->misfit)
        lf_check_say(check, CHECK_RESAMPLED, LF_CHECK_PASS, limit, NULL,
                     "stripes fit best where they should be");
    else {
        say_unmeasured(check, why, sizeof why);
        lf_check_say(check, CHECK_RESAMPLED, LF_CHECK_NONE, limit, NULL, "%s", why);
    }
}

static void judge_stored(lf_check *check)
{
    static const char limit[] = "all rows there; BigTIFF only where 4 GiB are not enough";
    const lf_print_tags *tags = check->tags;
    const double raster =
        tags ? (double)tags->width * tags->height * tags->samples * (tags->bits > 8 ? 2 : 1) : 0.0;
    if (check->trouble[0] || !tags)
        lf_check_say(check, CHECK_STORED, LF_CHECK_FAIL, limit,
                     "The file is damaged, or of another program; copy or write it again.", "%s",
                     check->trouble);
    else if (tags->big && 1.7 * raster < BIG_FILE)
        lf_check_say(check, CHECK_STORED, LF_CHECK_WARN, limit,
                     "Another program has saved the file; some printers cannot read BigTIFF.",
                     "a BigTIFF of %.1f MB", 1e-6 * (double)tags->file_bytes);
    else
        lf_check_say(check, CHECK_STORED, LF_CHECK_PASS, limit, NULL, "%s, %.1f MB",
                     lf_print_file_boxes(check->file) ? "PDF"
                     : tags->big                      ? "BigTIFF"
                                                      : "TIFF",
                     1e-6 * (double)tags->file_bytes);
}

/* Why bleed and marks are not measured. */
static void say_edges(lf_check *check)
{
    const lf_print *print = &check->print;
    const char *why = check->is_chart ? "a chart, whose marks are not measured"
                      : check->laid   ? "not measured on a page with several copies or a label"
                      : !check->fits  ? "not measured: the file is not what was promised"
                      : !print->marks ? "the bleed is too narrow to be measured"
                      : check->linear ? "not measured for slanted lenses or an exact map"
                                      : "not measured for micro lenses";
    if (check->report->points[CHECK_EDGES].measured[0] != '\0')
        return;
    if (!check->known)
        lf_check_say(check, CHECK_EDGES, LF_CHECK_NONE, NULL, NULL,
                     "not measured without a manifest");
    else if (!print->marks && !(print->bleed_mm > 0.0))
        lf_check_say(check, CHECK_EDGES, LF_CHECK_NONE, NULL, NULL, "no bleed and no marks");
    else
        lf_check_say(check, CHECK_EDGES, LF_CHECK_NONE, NULL, NULL, "bleed %g mm%s: %s",
                     print->bleed_mm, print->marks ? ", marks" : "", why);
}

/* --------------------------------------------------------------------------------------- run -- */

/* What a point says until a stage knows better. */
static void say_nothing_yet(lf_check *check)
{
    for (int point = 0; point < LF_CHECK_POINTS; point++)
        lf_check_say(check, point, LF_CHECK_NONE, NULL, NULL,
                     point == CHECK_EDGES ? "" : "not measured");
    lf_check_say(check, CHECK_PDF, LF_CHECK_NONE, NULL, NULL, "the file is a TIFF");
    lf_check_say(check, CHECK_SAME, LF_CHECK_NONE, NULL, NULL,
                 "the file was not compared with what was written");
}

/* LF_E_PATH and LF_E_IO are the caller's to tell; damage is a point. */
static lf_status open_file(lf_check *check, lf_error *err)
{
    lf_error trouble = {0};
    const lf_status status =
        lf_print_file_open(check->path, check->options->roots, &check->file, &trouble);
    if (status == LF_OK) {
        check->tags = lf_print_file_tags(check->file);
        snprintf(check->report->profile_name, sizeof check->report->profile_name, "%s",
                 lf_print_file_profile_name(check->file));
        return LF_OK;
    }
    if (status != LF_E_FORMAT) {
        if (err)
            *err = trouble;
        return status;
    }
    snprintf(check->trouble, sizeof check->trouble, "%s", trouble.what);
    lf_check_say(check, CHECK_LOSSLESS, LF_CHECK_FAIL, "a TIFF, or a PDF of quiltrender",
                 "Write the print again.", "%s", trouble.what);
    lf_check_say(check, CHECK_PDF, LF_CHECK_NONE, NULL, NULL, "the file cannot be read");
    return LF_OK;
}

/* Counts the rows that are not those that were written. */
static lf_status compare_witness(lf_check *check, lf_error *err)
{
    const lf_print_witness *witness = check->options->witness;
    check->differing = -1;
    if (!witness || witness->height == 0 || witness->n_rows == 0)
        return LF_OK;
    check->differing = witness->n_rows;
    if (!check->file || lf_print_file_unreadable(check->file) ||
        check->tags->height != witness->height ||
        lf_print_file_raw_bytes(check->file) != witness->row_bytes)
        return LF_OK;
    unsigned char *row = lf_calloc(1, witness->row_bytes);
    if (!row)
        return lf_error_set(err, LF_E_NOMEM, check->path, "out of memory");
    check->differing = 0;
    for (int i = 0; i < witness->n_rows; i++) {
        lf_error trouble = {0};
        const lf_status status =
            lf_print_file_raw(check->file, lf_print_witness_at(witness, i), row, &trouble);
        if (status != LF_OK)
            snprintf(check->trouble, sizeof check->trouble, "%s", trouble.what);
        check->differing +=
            status != LF_OK ||
            memcmp(row, witness->rows + (size_t)i * witness->row_bytes, witness->row_bytes) != 0;
    }
    lf_free(row);
    return LF_OK;
}

static bool fits(const lf_check *check)
{
    const lf_print_tags *tags = check->tags;
    return check->file && check->known && !lf_print_file_unreadable(check->file) &&
           tags->width == check->width && tags->height == check->height &&
           tags->bits == check->print.bits && tags->extra_samples == 0;
}

static lf_status run(lf_check *check, lf_error *err)
{
    say_nothing_yet(check);
    lf_status status = open_file(check, err);
    if (status == LF_OK)
        status = lf_check_manifest_read(check, err);
    if (status == LF_OK)
        status = lf_check_manifest(check, err);
    if (status != LF_OK)
        return status;
    if (check->file) {
        lf_check_tags(check);
        lf_check_pdf(check);
    }
    check->fits = fits(check);
    status = compare_witness(check, err);
    if (status == LF_OK)
        status = lf_check_picture(check, err);
    if (status == LF_OK)
        status = lf_check_marks(check, err);
    if (status == LF_OK)
        status = lf_check_bleed(check, err);
    if (status == LF_OK)
        status = lf_check_writer(check, err);
    if (status != LF_OK)
        return status;
    judge_positions(check);
    judge_resampling(check);
    judge_stored(check);
    lf_check_views(check);
    say_edges(check);
    return LF_OK;
}

lf_status lf_print_check_file(const char *path, const lf_print_check_options *options,
                              lf_print_report *out, lf_error *err)
{
    static const lf_print_check_options defaults;
    lf_check check = {.path = path, .options = options ? options : &defaults, .report = out};
    memset(out, 0, sizeof *out);
    out->file = lf_strdup(path);
    const lf_status status =
        out->file ? run(&check, err) : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    lf_print_file_close(check.file);
    if (status != LF_OK)
        lf_print_report_finish(out);
    return status;
}

void lf_print_report_finish(lf_print_report *report)
{
    lf_free(report->file);
    json_decref(report->manifest);
    memset(report, 0, sizeof *report);
}
