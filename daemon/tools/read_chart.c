#include "daemon/tools/read_chart.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "base/sandbox/raster.h"
#include "daemon/output/content.h"
#include "quilt/chart/reading.h"
#include "quilt/profiles.h"

#define PROGRAM LF_RENDER_PROGRAM

/* The manifest of a chart. */
typedef struct manifest {
    char *path;
    json_t *json;
    lf_print print;
} manifest;

/* chart.json beside the photo, unless another one is named. */
static char *manifest_path(const lf_print_arguments *a)
{
    if (a->chart_file)
        return lf_strdup(a->chart_file);
    char *folder = lf_path_folder(a->photo);
    char *path = folder ? lf_path_join(folder, "chart.json") : NULL;
    lf_free(folder);
    return path;
}

/* The options that a chart's layout follows from. */
static lf_status take_options(manifest *chart, lf_error *err)
{
    static const char *const keys[] = {"lpi",   "range",  "step",       "dpi",
                                       "width", "height", "orientation"};
    const json_t *options = json_object_get(chart->json, "options");
    json_t *own = json_object();
    for (size_t i = 0; own && i < sizeof keys / sizeof *keys; i++)
        json_object_set(own, keys[i], json_object_get(options, keys[i]));
    lf_param_defaults(lf_print_params, &chart->print);
    const lf_status status =
        lf_param_from_json(lf_print_params, own, &chart->print, chart->path, err);
    json_decref(own);
    return status;
}

static lf_status open_manifest(const lf_print_arguments *a, manifest *out, lf_error *err)
{
    lf_error cause = {0};
    out->path = manifest_path(a);
    if (!out->path)
        return lf_error_set(err, LF_E_NOMEM, a->photo, "out of memory");
    lf_status status = lf_profile_json(out->path, NULL, &out->json, &cause);
    if (status == LF_E_IO && !a->chart_file)
        return lf_error_set(err, LF_E_ARG, "--chart-file",
                            "is missing, and %s is not there; give the manifest of the chart",
                            out->path);
    if (status != LF_OK) {
        if (err)
            *err = cause;
        return status;
    }
    if (!json_is_object(json_object_get(out->json, "chart")))
        return lf_error_set(err, LF_E_FORMAT, out->path,
                            "is not the manifest of a chart; make one with --chart");
    return take_options(out, err);
}

/* What options and the profile say of the sheet; options win. */
static lf_status take_sheet(const lf_render_arguments *a, const manifest *chart,
                            lf_chart_photo *photo, lf_error *err)
{
    const lf_optics *given = &a->print.optics;
    lf_optics optics = *given;
    if (a->of_print.profiles.lens) {
        lf_lens_profile *lens = lf_calloc(1, sizeof *lens);
        lf_status status = lens ? lf_profile_lens_read(a->of_print.profiles.lens, NULL, lens, err)
                                : lf_error_set(err, LF_E_NOMEM, "--lens", "out of memory");
        if (status == LF_OK && lens->has_horizontal && lens->horizontal != chart->print.horizontal)
            status = lf_error_set(err, LF_E_ARG, "--lens",
                                  "%s is a sheet of %s lenses; print the chart with --orientation "
                                  "%s",
                                  a->of_print.profiles.lens,
                                  lens->horizontal ? "horizontal" : "vertical",
                                  lens->horizontal ? "horizontal" : "vertical");
        if (status == LF_OK && !(optics.thickness_mm > 0.0))
            optics.thickness_mm = lens->optics.thickness_mm;
        if (status == LF_OK && !(optics.index > 0.0))
            optics.index = lens->optics.index;
        lf_free(lens);
        if (status != LF_OK)
            return status;
    }
    photo->thickness_mm = optics.thickness_mm;
    photo->index = optics.index;
    photo->distance_mm = optics.distance_mm;
    return LF_OK;
}

static lf_status write_result(const lf_render_arguments *a, const manifest *chart,
                              const lf_chart_reading *reading, lf_error *err)
{
    const json_t *file = json_object_get(chart->json, "file");
    json_t *json =
        lf_chart_reading_json(reading, json_string_value(json_object_get(file, "sha256")));
    if (json)
        json_object_set_new(json, "orientation",
                            json_string(chart->print.horizontal ? "horizontal" : "vertical"));
    char *text = json ? json_dumps(json, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    lf_status status = text ? lf_outfile_text(a->out, text, err)
                            : lf_error_set(err, LF_E_NOMEM, a->out, "out of memory");
    free(text);
    json_decref(json);
    return status;
}

/* Results may be replaced, manifests may not. */
static lf_status check_out(const char *out, lf_error *err)
{
    json_t *there = NULL;
    lf_error cause = {0};
    lf_status status = LF_OK;
    if (out && access(out, F_OK) == 0 && lf_profile_json(out, NULL, &there, &cause) == LF_OK &&
        json_object_get(there, "quiltd_print"))
        status = lf_error_set(err, LF_E_ARG, out,
                              "is the manifest of a print; choose another name for the result");
    json_decref(there);
    return status;
}

static void say_next(const lf_render_arguments *a, const manifest *chart, const lf_chart_reading *r)
{
    const char *lens = a->of_print.profiles.lens, *printer = a->of_print.profiles.printer;
    if (a->out || lens || printer)
        printf("next   %s%squiltprint calibrate %s %s %s\n", a->out ? "" : "read again with ",
               a->out ? "" : "-o result.json, then ", lens ? lens : "LENS",
               printer ? printer : "PRINTER", a->out ? a->out : "result.json");
    else
        printf("next   quiltrender SCENE -o sheet.tif --print %.4f@%.10g --phase %.4f "
               "--print-size WxH\n",
               r->visual_lpi, chart->print.dpi, r->phase_mm);
}

static void print_reading(const lf_render_arguments *a, const manifest *chart,
                          const lf_chart_reading *r)
{
    printf("pitch  %.4f +- %.4f lpi from %.0f mm\n", r->visual_lpi, r->error_lpi, r->distance_mm);
    printf("camera %.0f mm away, %.0f to the right, %.0f down; %.4f +- %.4f lpi from there\n",
           r->camera_mm[2], r->camera_mm[0], r->camera_mm[1], r->camera_lpi, r->error_camera_lpi);
    printf("phase  %+.4f +- %.4f mm\n", r->phase_mm, r->error_phase_mm);
    printf("skew   %+.3f +- %.3f degrees, clockwise\n", r->skew_deg, r->error_skew_deg);
    printf("order  %s\n", !r->has_order    ? "not told by this photo; take one from further aside"
                          : r->is_reversed ? "reversed: print with --reverse"
                                           : "normal");
    if (r->n_crosstalk > 0) {
        printf("views  of %d, from %d left to %d right:", LF_CHART_CODES, LF_CHART_KERNEL,
               LF_CHART_KERNEL);
        for (int i = 0; i < r->n_crosstalk; i++)
            printf(" %.2f", r->crosstalk[i]);
        printf("\n");
    }
    say_next(a, chart, r);
}

static lf_status read_it(const lf_render_arguments *a, manifest *chart, lf_raster *raster,
                         lf_error *err)
{
    lf_chart_photo photo = {0};
    lf_chart_reading reading;
    lf_status status = check_out(a->out, err);
    if (status == LF_OK)
        status = open_manifest(&a->of_print, chart, err);
    if (status == LF_OK)
        status = take_sheet(a, chart, &photo, err);
    if (status == LF_OK)
        status = lf_raster_open(a->of_print.photo, NULL, false, raster, err);
    if (status == LF_OK && !raster->data8)
        status = lf_error_set(err, LF_E_FORMAT, a->of_print.photo,
                              "is not a photo; expected JPEG or PNG");
    if (status != LF_OK)
        return status;
    photo.data = raster->data8;
    photo.width = raster->width;
    photo.height = raster->height;
    photo.focal_35mm = raster->meta.focal_35mm;
    status = lf_chart_read(&chart->print, &photo, a->of_print.photo, &reading, err);
    if (status == LF_OK && a->out)
        status = write_result(a, chart, &reading, err);
    if (status != LF_OK)
        return status;
    lf_log_notes(&reading.notes, a->of_print.photo);
    print_reading(a, chart, &reading);
    return LF_OK;
}

int lf_read_chart(const lf_render_arguments *a)
{
    manifest chart = {0};
    lf_raster raster = {0};
    lf_error err = {0};
    const lf_status status = read_it(a, &chart, &raster, &err);
    lf_raster_close(&raster);
    json_decref(chart.json);
    lf_free(chart.path);
    if (status == LF_E_ARG && strncmp(err.where, "--", 2) == 0)
        return lf_usage_error(PROGRAM, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    return status == LF_OK && fflush(stdout) == 0 ? LF_EXIT_OK : LF_EXIT_FAILED;
}
