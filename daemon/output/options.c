#include "daemon/output/options.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define DEFAULT_VIEWS 45
#define DEFAULT_VIEW_HEIGHT 560
#define MAX_THREADS 256
#define MAX_DEPTH 65536

static lf_status parse_view_size(lf_options *options, const char *text, lf_error *err)
{
    double size[2];
    lf_status status = lf_parse_pair("--view-size", text, 'x', 1, LF_MAX_VIEW_SIDE, size, err);
    if (status != LF_OK)
        return status;
    if (size[0] != floor(size[0]) || size[1] != floor(size[1]))
        return lf_error_set(err, LF_E_ARG, "--view-size", "expects whole pixels, not \"%s\"", text);
    options->view_width = (int)size[0];
    options->view_height = (int)size[1];
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- names -- */

static lf_status find_integrator(const char *name, const char **out, lf_error *err)
{
    char known[128] = "";
    for (int i = 0; lf_integrator_at(i); i++) {
        if (strcmp(name, lf_integrator_at(i)->name) == 0) {
            *out = lf_integrator_at(i)->name;
            return LF_OK;
        }
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "",
                 lf_integrator_at(i)->name);
    }
    return lf_error_set(err, LF_E_ARG, "--integrator", "unknown integrator \"%s\" (there are: %s)",
                        name, known);
}

/* Errors of the rooms name what they like as `where`; on the command line it is the option. */
static lf_status blame(lf_status status, const char *option, lf_error *err)
{
    if (status != LF_OK && err)
        snprintf(err->where, sizeof err->where, "%s", option);
    return status;
}

static lf_status take_view_option(lf_options *options, int code, const char *argument,
                                  lf_error *err)
{
    switch (code) {
    case LF_OPTION_PRESET:
        return blame(lf_preset_find(argument, &options->preset, err), "--preset", err);
    case LF_OPTION_VIEWS:
        return lf_parse_small("--views", argument, 1, LF_MAX_VIEWS, &options->views, err);
    case LF_OPTION_QUILT:
        return blame(lf_parse_tiles(argument, &options->columns, &options->rows, err), "--quilt",
                     err);
    case LF_OPTION_VIEW_SIZE:
        return parse_view_size(options, argument, err);
    default:
        assert(code == LF_OPTION_CALIBRATION);
        options->calibration = argument;
        return LF_OK;
    }
}

static lf_status take_render_option(lf_options *options, int code, const char *argument,
                                    lf_error *err)
{
    lf_status status = LF_OK;
    switch (code) {
    case LF_OPTION_INTEGRATOR:
        return find_integrator(argument, &options->integrator, err);
    case LF_OPTION_ESTIMATOR:
        status =
            blame(lf_estimator_from_name(argument, &options->estimator, err), "--estimator", err);
        options->has_estimator |= status == LF_OK;
        return status;
    case LF_OPTION_SAMPLER:
        status = blame(lf_sampler_from_name(argument, &options->sampler, err), "--sampler", err);
        options->has_sampler |= status == LF_OK;
        return status;
    case LF_OPTION_THREADS:
        return lf_parse_small("--threads", argument, 1, MAX_THREADS, &options->threads, err);
    case LF_OPTION_SEED:
        status = lf_parse_seed("--seed", argument, &options->seed, err);
        options->has_seed |= status == LF_OK;
        return status;
    case LF_OPTION_SKIP:
        options->has_skip = true;
        return blame(lf_skip_parse(argument, &options->skip, err), "--skip", err);
    case LF_OPTION_MAX_DEPTH:
        return lf_parse_small("--max-depth", argument, 1, MAX_DEPTH, &options->max_depth, err);
    default:
        assert(code == LF_OPTION_TARGET_ERROR);
        return lf_parse_double("--target-error", argument, 1e-12, 1e6, &options->target_error, err);
    }
}

lf_status lf_options_take(lf_options *options, int code, const char *argument, bool *out_taken,
                          lf_error *err)
{
    *out_taken = code >= LF_OPTION_PRESET && code <= LF_OPTION_CALIBRATION;
    if (!*out_taken)
        return LF_OK;
    if (code <= LF_OPTION_VIEW_SIZE || code == LF_OPTION_CALIBRATION)
        return take_view_option(options, code, argument, err);
    return take_render_option(options, code, argument, err);
}

/* -------------------------------------------------------------------------------- resolution -- */

static void resolve_camera(const lf_options *options, const lf_camera *camera,
                           const lf_calibration *calibration, lf_camera *out)
{
    *out = *camera;
    if (options->view_width > 0 && !camera->has_aspect)
        out->aspect = (double)options->view_width / options->view_height;
    if (!camera->has_views)
        out->n_views = DEFAULT_VIEWS;
    if (calibration) {
        out->aspect = (double)calibration->screen_width_px / calibration->screen_height_px;
        if (calibration->view_cone_deg > 0)
            out->cone = calibration->view_cone_deg * (M_PI / 180.0);
    }
    if (options->preset) {
        out->aspect = options->preset->layout.aspect;
        out->n_views = options->preset->layout.n_views;
    }
    if (options->views > 0)
        out->n_views = options->views;
}

static void resolve_view_size(const lf_options *options, double aspect, lf_layout *layout)
{
    double width = round(aspect * DEFAULT_VIEW_HEIGHT);
    layout->view_width = (int)fmax(1.0, fmin(width, LF_MAX_VIEW_SIDE));
    layout->view_height = DEFAULT_VIEW_HEIGHT;
    if (options->preset) {
        layout->view_width = options->preset->layout.view_width;
        layout->view_height = options->preset->layout.view_height;
    }
    if (options->view_width > 0) {
        layout->view_width = options->view_width;
        layout->view_height = options->view_height;
    }
}

static lf_status resolve_tiles(const lf_options *options, lf_layout *layout, lf_error *err)
{
    if (options->columns > 0) {
        if (options->columns * options->rows < layout->n_views)
            return lf_error_set(
                err, LF_E_ARG, "--quilt",
                "%dx%d holds %d tiles, but there are %d views (--views says how many)",
                options->columns, options->rows, options->columns * options->rows, layout->n_views);
        layout->columns = options->columns;
        layout->rows = options->rows;
    } else if (options->preset && options->preset->layout.n_views == layout->n_views) {
        layout->columns = options->preset->layout.columns;
        layout->rows = options->preset->layout.rows;
    } else {
        lf_layout_tiles(layout->n_views, layout->view_width, layout->view_height, &layout->columns,
                        &layout->rows);
    }
    return LF_OK;
}

lf_status lf_resolve_view(const lf_options *options, const lf_camera *camera,
                          const lf_calibration *calibration, lf_render_settings *out_settings,
                          lf_layout *out_layout, lf_error *err)
{
    lf_render_settings settings = {
        .integrator = options->integrator,
        .sampler = options->sampler,
        .seed = options->seed,
        .max_depth = options->max_depth,
        .skip = options->has_skip ? options->skip : LF_SKIP_ALL,
    };
    lf_layout layout = {0};
    resolve_camera(options, camera, calibration, &settings.camera);
    layout.n_views = settings.camera.n_views;
    layout.aspect = settings.camera.aspect;
    resolve_view_size(options, layout.aspect, &layout);
    lf_status status = resolve_tiles(options, &layout, err);
    if (status != LF_OK)
        return status;
    settings.width = layout.view_width;
    settings.height = layout.view_height;
    *out_settings = settings;
    *out_layout = layout;
    return LF_OK;
}
