/* quiltrender: one scene or quilt to one picture, print or folder of views. See docs/man/quiltrender.1. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/options.h"
#include "daemon/output.h"
#include "daemon/render_job.h"

#define PROGRAM "quiltrender"
#define DEFAULT_SPP 16
#define MAX_PASSES (INT64_C(1) << 40)

/* Everything the command line says. */
typedef struct arguments {
    lf_options options;
    const char *scene, *out, *stats;
    lf_output_kind kind;
    lf_budget budget; /* passes stay 0 for --spp until the number of views is known */
    int64_t spp;
    int n_budgets; /* of --passes, --spp, --time, --target-error */
    bool has_filter, has_invert;
    lf_filter filter;
    lf_invert invert;
    const char *print_option; /* the first option that only makes sense with --print */
    bool has_print, has_print_size;
    lf_print print;
} arguments;

/* ------------------------------------------------------------------------------------------------------- progress -- */

typedef struct progress_line {
    bool on;     /* stderr is a terminal */
    double last; /* when it was drawn; 0 = not there */
} progress_line;

static void draw(progress_line *line, const char *text)
{
    double now = lf_time_now();

    if (!line->on || (line->last > 0 && now - line->last < 0.1))
        return;
    line->last = now;
    fprintf(stderr, "\r" PROGRAM ": %s\033[K", text);
}

static void clear_line(progress_line *line)
{
    if (line->last > 0)
        fputs("\r\033[K", stderr);
    line->last = 0;
}

static void show_rendering(void *context, const lf_render_progress *progress)
{
    char text[160];
    char left[64] = "";

    if (progress->fraction > 0.01)
        snprintf(left, sizeof left, ", about %.0f s left", progress->seconds * (1 / progress->fraction - 1));
    snprintf(text, sizeof text, "rendering %3.0f %%, %.2f samples a view pixel, %.0f s%s", 100 * progress->fraction,
             progress->passes / progress->n_views, progress->seconds, left);
    draw(context, text);
}

static void show_writing(void *context, double fraction)
{
    char text[64];

    snprintf(text, sizeof text, "writing %3.0f %%", 100 * fraction);
    draw(context, text);
}

/* One job, half-built at any time. */
typedef struct job {
    const arguments *arguments;
    progress_line line;
    lf_calibration calibration;
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_render_settings settings;
    lf_layout layout;
    lf_quilt_file quilt;
    bool is_quilt;
    float *film; /* [row][view][column][3] */
    lf_print print;
    char *path;     /* final name */
    json_t *record; /* settings for attributes and the manifest */
    lf_render_times times;
} job;

static lf_cancel cancel;

static void on_signal(int number)
{
    (void)number;
    atomic_store_explicit(&cancel, 1, memory_order_relaxed);
}

/* ------------------------------------------------------------------------------------------------------ arguments -- */

enum {
    OPTION_OUT = 'o',
    OPTION_PASSES = LF_OPTION_OWN,
    OPTION_SPP,
    OPTION_TIME,
    OPTION_STATS,
    OPTION_FILTER,
    OPTION_INVERT,
    OPTION_PRINT, /* from here on: options of prints */
    OPTION_PRINT_SIZE,
    OPTION_STRIPES,
    OPTION_PHASE,
    OPTION_ORIENTATION,
    OPTION_BLEED,
    OPTION_ICC,
    OPTION_BITS,
    OPTION_COMPRESS,
    OPTION_REVERSE,
    OPTION_MIRROR,
};

static const struct option table[] = {
    LF_OPTIONS_LONG("panel"),
    {"output", required_argument, NULL, OPTION_OUT},
    {"passes", required_argument, NULL, OPTION_PASSES},
    {"spp", required_argument, NULL, OPTION_SPP},
    {"time", required_argument, NULL, OPTION_TIME},
    {"stats", required_argument, NULL, OPTION_STATS},
    {"filter", required_argument, NULL, OPTION_FILTER},
    {"invert", required_argument, NULL, OPTION_INVERT},
    {"print", required_argument, NULL, OPTION_PRINT},
    {"print-size", required_argument, NULL, OPTION_PRINT_SIZE},
    {"stripes", required_argument, NULL, OPTION_STRIPES},
    {"phase", required_argument, NULL, OPTION_PHASE},
    {"orientation", required_argument, NULL, OPTION_ORIENTATION},
    {"bleed", required_argument, NULL, OPTION_BLEED},
    {"icc", required_argument, NULL, OPTION_ICC},
    {"bits", required_argument, NULL, OPTION_BITS},
    {"compress", required_argument, NULL, OPTION_COMPRESS},
    {"reverse", no_argument, NULL, OPTION_REVERSE},
    {"mirror", no_argument, NULL, OPTION_MIRROR},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf(
        "Usage: quiltrender SCENE -o OUT [options]\n"
        "Renders a scene (JSON) into a quilt, an interlaced panel picture, a lenticular print or a folder of views.\n"
        "A quilt picture or a folder of views may stand in for SCENE: it is used as it is.\n"
        "\n"
        "OUT by its ending: .png or .exr is a quilt (named ..._qsCxRaASPECT), .tif a print, a path ending in / a folder of views.\n"
        "\n"
        "What:\n" LF_OPTIONS_HELP_VIEWS "  --panel FILE           interlaced for the panel with this calibration, into OUT.png\n"
        "  --filter NAME          nearest (default) or linear: how the panel's pixels are taken from the views\n"
        "  --invert MODE          auto (default), yes or no: order of the views under a lens of the panel\n"
        "  --print LPI@DPI        lenticular print into OUT.tif; LPI is the measured visual pitch, e.g. 60.13@600\n"
        "  --print-size WxH       trim size of the print in mm\n"
        "  --stripes NAME         fractional (default) or nearest\n"
        "  --phase MM             moves the lens in the middle of the print to the right\n"
        "  --orientation NAME     of the lenses: vertical (default) or horizontal\n"
        "  --bleed MM             on every side, rendered\n"
        "  --icc FILE             colour profile of the print (sRGB)\n"
        "  --bits 8|16            of a channel (8)\n"
        "  --compress NAME        none (default), lzw or deflate\n"
        "  --reverse, --mirror    views from first to last under a lens; the whole print mirrored\n"
        "\n"
        "How long (one of them; --spp %d when none is given):\n"
        "  --passes N             base paths: N for every pixel of one view's size\n"
        "  --spp N                base paths for every view pixel\n"
        "  --time SECONDS\n"
        "  --target-error RELMSE  until the estimated relative mean squared error is below this\n"
        "\n"
        "How:\n" LF_OPTIONS_HELP_RENDER "  --stats FILE.json      writes what was done and what it took\n" LF_OPTIONS_HELP_LAST,
        DEFAULT_SPP);
}

static lf_status take_budget(arguments *a, int code, const char *text, lf_error *err)
{
    a->n_budgets++;
    switch (code) {
    case OPTION_PASSES:
        return lf_parse_int("--passes", text, 1, MAX_PASSES, &a->budget.passes, err);
    case OPTION_SPP:
        return lf_parse_int("--spp", text, 1, MAX_PASSES / LF_MAX_VIEWS, &a->spp, err);
    default:
        return lf_parse_double("--time", text, 1e-3, 1e9, &a->budget.seconds, err);
    }
}

static lf_status take_print_pitch(arguments *a, const char *text, lf_error *err)
{
    double pair[2];
    lf_status status = lf_parse_pair("--print", text, '@', 1, 100000, pair, err);

    if (status != LF_OK)
        return status;
    if (pair[1] != floor(pair[1]))
        return lf_error_set(err, LF_E_ARG, "--print", "expects LPI@DPI with a whole DPI, not \"%s\"", text);
    a->has_print = true;
    a->print.lpi = pair[0];
    a->print.dpi = (int)pair[1];
    return LF_OK;
}

static lf_status take_print_size(arguments *a, const char *text, lf_error *err)
{
    double pair[2];
    lf_status status = lf_parse_pair("--print-size", text, 'x', 1e-3, 1e5, pair, err);

    if (status != LF_OK)
        return status;
    a->has_print_size = true;
    a->print.width_mm = pair[0];
    a->print.height_mm = pair[1];
    return LF_OK;
}

static lf_status take_orientation(arguments *a, const char *text, lf_error *err)
{
    if (strcmp(text, "vertical") != 0 && strcmp(text, "horizontal") != 0)
        return lf_error_set(err, LF_E_ARG, "--orientation", "unknown name \"%s\" (there are: vertical, horizontal)", text);
    a->print.horizontal = strcmp(text, "horizontal") == 0;
    return LF_OK;
}

static lf_status take_bits(arguments *a, const char *text, lf_error *err)
{
    if (strcmp(text, "8") != 0 && strcmp(text, "16") != 0)
        return lf_error_set(err, LF_E_ARG, "--bits", "expects 8 or 16, not \"%s\"", text);
    a->print.bits = strcmp(text, "8") == 0 ? 8 : 16;
    return LF_OK;
}

static lf_status take_print(arguments *a, int code, const char *text, lf_error *err)
{
    switch (code) {
    case OPTION_PRINT:
        return take_print_pitch(a, text, err);
    case OPTION_PRINT_SIZE:
        return take_print_size(a, text, err);
    case OPTION_STRIPES:
        return lf_stripes_from_name(text, &a->print.stripes, err);
    case OPTION_PHASE:
        return lf_parse_double("--phase", text, -100, 100, &a->print.phase_mm, err);
    case OPTION_ORIENTATION:
        return take_orientation(a, text, err);
    case OPTION_BLEED:
        return lf_parse_double("--bleed", text, 0, 100, &a->print.bleed_mm, err);
    case OPTION_ICC:
        a->print.icc_path = text;
        return LF_OK;
    case OPTION_BITS:
        return take_bits(a, text, err);
    case OPTION_COMPRESS:
        return lf_compress_from_name(text, &a->print.compress, err);
    case OPTION_REVERSE:
        a->print.reverse = true;
        return LF_OK;
    default:
        a->print.mirror = true;
        return LF_OK;
    }
}

static const char *name_of_option(int code)
{
    for (const struct option *o = table; o->name; o++)
        if (o->val == code)
            return o->name;
    return "";
}

static lf_status take_own(arguments *a, int code, const char *text, lf_error *err)
{
    lf_status status = LF_OK;
    char where[64];

    switch (code) {
    case OPTION_OUT:
        a->out = text;
        return LF_OK;
    case OPTION_STATS:
        a->stats = text;
        return LF_OK;
    case OPTION_PASSES:
    case OPTION_SPP:
    case OPTION_TIME:
        return take_budget(a, code, text, err);
    case OPTION_FILTER:
        a->has_filter = true;
        status = lf_filter_from_name(text, &a->filter, err);
        break;
    case OPTION_INVERT:
        a->has_invert = true;
        status = lf_invert_from_name(text, &a->invert, err);
        break;
    default:
        if (code != OPTION_PRINT && !a->print_option)
            a->print_option = name_of_option(code);
        status = take_print(a, code, text, err);
    }
    if (status != LF_OK) {
        snprintf(where, sizeof where, "--%s", name_of_option(code));
        snprintf(err->where, sizeof err->where, "%s", where);
    }
    return status;
}

static bool ends_with(const char *text, const char *ending)
{
    size_t n = strlen(text);
    size_t m = strlen(ending);

    return n >= m && strcasecmp(text + n - m, ending) == 0;
}

/* What OUT is, from the options and its ending. */
static lf_status choose_kind(arguments *a, lf_error *err)
{
    char *path = NULL;

    if (a->has_print && a->options.calibration)
        return lf_error_set(err, LF_E_ARG, "--print", "does not go with --panel: one job writes one of them");
    if (!a->has_print && a->print_option) {
        char where[64];
        snprintf(where, sizeof where, "--%s", a->print_option);
        return lf_error_set(err, LF_E_ARG, where, "only goes with --print LPI@DPI");
    }
    if (a->has_print && !a->has_print_size)
        return lf_error_set(err, LF_E_ARG, "--print", "needs --print-size WxH (in mm)");
    if (!a->options.calibration && (a->has_filter || a->has_invert))
        return lf_error_set(err, LF_E_ARG, a->has_filter ? "--filter" : "--invert", "only goes with --panel CALIBRATION.json");
    if (a->has_print)
        a->kind = LF_OUTPUT_PRINT;
    else if (a->options.calibration)
        a->kind = LF_OUTPUT_PANEL;
    else if (a->out[strlen(a->out) - 1] == '/')
        a->kind = LF_OUTPUT_VIEWS;
    else
        a->kind = LF_OUTPUT_QUILT;
    if (a->kind == LF_OUTPUT_QUILT && (ends_with(a->out, ".tif") || ends_with(a->out, ".tiff")))
        return lf_error_set(err, LF_E_ARG, a->out, "a .tif goes with --print LPI@DPI");
    if (a->kind == LF_OUTPUT_QUILT && !ends_with(a->out, ".png") && !ends_with(a->out, ".exr"))
        return lf_error_set(err, LF_E_ARG, a->out, "must end in .png or .exr (a quilt), .tif (a print) or / (a folder of views)");
    if (a->kind == LF_OUTPUT_QUILT)
        return LF_OK; /* the tiles of the name are checked when the layout is known */
    lf_status status = lf_output_path(a->kind, a->out, NULL, &path, err);
    lf_free(path);
    return status;
}

static lf_status check_arguments(arguments *a, int argc, char *const argv[], lf_error *err)
{
    if (optind >= argc)
        return lf_error_set(err, LF_E_ARG, "SCENE", "missing (see --help)");
    if (optind + 1 < argc)
        return lf_error_set(err, LF_E_ARG, argv[optind + 1], "one SCENE at a time");
    a->scene = argv[optind];
    if (!a->out || a->out[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "-o", "missing: where to write");
    a->budget.target_error = a->options.target_error;
    a->n_budgets += a->options.target_error > 0;
    if (a->n_budgets > 1)
        return lf_error_set(err, LF_E_ARG, "--passes, --spp, --time, --target-error", "only one of them");
    if (a->n_budgets == 0)
        a->spp = DEFAULT_SPP;
    return choose_kind(a, err);
}

/* LF_OK with *out_done for --help and --version. */
static lf_status parse_arguments(arguments *a, int argc, char *const argv[], bool *out_done, lf_error *err)
{
    int code = 0;
    bool taken = false;

    *out_done = false;
    for (;;) {
        lf_status status = lf_options_next(argc, argv, ":o:", table, &code, err);
        if (status != LF_OK)
            return status;
        if (code == -1)
            return check_arguments(a, argc, argv, err);
        if (code == LF_OPTION_HELP || code == LF_OPTION_VERSION) {
            *out_done = true;
            code == LF_OPTION_HELP ? print_help() : lf_print_version(PROGRAM);
            return LF_OK;
        }
        status = lf_options_take(&a->options, code, optarg, &taken, err);
        if (status == LF_OK && !taken)
            status = take_own(a, code, optarg, err);
        if (status != LF_OK)
            return status;
    }
}

/* ------------------------------------------------------------------------------------------------------------ job -- */

/* An hour of rendering must not end at a folder that is not there. */
static lf_status check_folder_of(const char *path, lf_error *err)
{
    size_t n = strlen(path);
    char *copy = lf_strdup(path);
    char *folder = NULL;
    lf_status status = LF_OK;

    while (copy && n > 1 && copy[n - 1] == '/')
        copy[--n] = '\0';
    folder = copy ? lf_path_folder(copy) : NULL;
    if (!folder)
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    else if (access(folder, W_OK | X_OK) != 0)
        status = lf_error_set(err, LF_E_IO, path, "cannot write into the folder %s: %s", folder, strerror(errno));
    lf_free(folder);
    lf_free(copy);
    return status;
}

static lf_status prepare_print(job *j, int n_views_most, lf_error *err)
{
    const char *warning = NULL;

    j->print = j->arguments->print;
    double most = floor(j->print.dpi / j->print.lpi + 1e-9);
    j->print.n_views = (int)fmax(1, fmin(most, n_views_most));
    if (j->arguments->options.views > 0)
        j->print.n_views = j->arguments->options.views;
    if (j->print.n_views > n_views_most)
        return lf_error_set(err, LF_E_ARG, "--views", "%d views asked for, but there are only %d", j->print.n_views, n_views_most);
    lf_status status = lf_print_check(&j->print, &warning, err);
    if (status == LF_OK && warning)
        lf_log(LF_LOG_WARNING, "--views: %s", warning);
    return status;
}

/* How a finished light field is laid out anew: a folder has neither tiles nor an aspect but what the options and the names say. */
static void lay_out_quilt(job *j)
{
    const arguments *a = j->arguments;
    int columns = 0;
    int rows = 0;
    double aspect = 0;
    bool stated = lf_layout_from_name(a->scene, &columns, &rows, &aspect) && aspect > 0;

    j->layout = j->quilt.layout;
    if (a->options.columns * a->options.rows >= j->layout.n_views) {
        j->layout.columns = a->options.columns;
        j->layout.rows = a->options.rows;
    }
    aspect = 0;
    if (!stated && lf_layout_from_name(a->out, &columns, &rows, &aspect) && aspect > 0)
        j->layout.aspect = aspect;
}

static lf_status open_quilt(job *j, lf_error *err)
{
    const arguments *a = j->arguments;
    const lf_options *o = &a->options;

    if (o->preset || o->view_width > 0)
        return lf_error_set(err, LF_E_ARG, o->preset ? "--preset" : "--view-size",
                            "does not go with a finished quilt (its name or --quilt says the layout)");
    lf_status status = lf_quilt_read(a->scene, NULL, o->columns, o->rows, &j->quilt, err);
    if (status != LF_OK)
        return status;
    j->is_quilt = true;
    if (a->kind == LF_OUTPUT_PRINT)
        status = prepare_print(j, j->quilt.layout.n_views, err);
    else if (o->views > j->quilt.layout.n_views)
        status =
            lf_error_set(err, LF_E_ARG, "--views", "%d views asked for, but the quilt has %d", o->views, j->quilt.layout.n_views);
    else if (o->views > 0)
        j->quilt.layout.n_views = j->quilt.views8.n_views = j->quilt.views32.n_views = o->views;
    if (status == LF_OK)
        lay_out_quilt(j);
    return status;
}

static lf_status open_scene(job *j, lf_error *err)
{
    const arguments *a = j->arguments;
    const lf_calibration *calibration = a->kind == LF_OUTPUT_PANEL ? &j->calibration : NULL;

    if (a->kind == LF_OUTPUT_PRINT && (a->options.preset || a->options.columns > 0 || a->options.view_width > 0))
        return lf_error_set(err, LF_E_ARG, "--print", "says what to render: no --preset, --quilt or --view-size");
    lf_status status = lf_scene_load(a->scene, NULL, NULL, &j->scene, err);
    if (status == LF_OK)
        status = lf_resolve_view(&a->options, lf_scene_camera(j->scene), calibration, &j->settings, &j->layout, err);
    if (status == LF_OK && a->kind == LF_OUTPUT_PRINT) {
        status = prepare_print(j, LF_MAX_VIEWS, err);
        if (status == LF_OK)
            lf_output_print_view(&j->print, &j->settings);
        j->print.rolled = j->print.horizontal;
    }
    return status;
}

static lf_status open_input(job *j, lf_error *err)
{
    const arguments *a = j->arguments;
    lf_status status = check_folder_of(a->out, err);

    if (status == LF_OK && a->stats)
        status = check_folder_of(a->stats, err);
    if (status == LF_OK && a->kind == LF_OUTPUT_PANEL)
        status = lf_calibration_load(a->options.calibration, &j->calibration, err);
    if (status == LF_OK)
        status = lf_is_quilt(a->scene, NULL) ? open_quilt(j, err) : open_scene(j, err);
    if (status == LF_OK)
        status = lf_output_path(a->kind, a->out, &j->layout, &j->path, err);
    if (status == LF_OK && lf_pool_create(a->options.threads, &j->pool) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "--threads", "cannot start the worker threads");
    return status;
}

static lf_status render(job *j, lf_error *err)
{
    const arguments *a = j->arguments;
    lf_budget budget = a->budget;
    size_t views = (size_t)j->settings.camera.n_views;
    lf_status status = lf_renderer_create(j->scene, &j->settings, j->pool, &j->renderer, err);

    if (status != LF_OK)
        return status;
    if (a->spp > 0)
        budget.passes = a->spp * j->settings.camera.n_views;
    j->film = lf_calloc((size_t)j->settings.height * views, (size_t)j->settings.width * 3 * sizeof(float));
    if (!j->film)
        return lf_error_set(err, LF_E_NOMEM, a->out, "no memory for %zu views of %dx%d pixels", views, j->settings.width,
                            j->settings.height);
    status = lf_render_run(j->renderer, &budget, a->options.estimator, j->film, show_rendering, &j->line, &cancel, &j->times);
    if (status == LF_E_CANCELLED)
        return lf_error_set(err, status, a->out, "interrupted: nothing was written");
    return status == LF_OK ? LF_OK : lf_error_set(err, status, a->out, "rendering failed");
}

static json_t *make_record(const job *j)
{
    const arguments *a = j->arguments;

    if (j->is_quilt)
        return json_pack("{s:s, s:i, s:f}", "scene", a->scene, "views", j->layout.n_views, "aspect", j->layout.aspect);
    return lf_output_settings(a->scene, &j->settings, a->kind == LF_OUTPUT_QUILT ? &j->layout : NULL, a->options.estimator,
                              (double)j->times.passes, lf_scene_film_settings(j->scene));
}

static lf_status write_output(job *j, lf_error *err)
{
    const arguments *a = j->arguments;
    const lf_film_settings *film = j->scene ? lf_scene_film_settings(j->scene) : NULL;
    lf_output_source source = j->is_quilt ? lf_output_from_quilt(&j->quilt) : lf_output_from_film(&j->settings, j->film);

    if (j->is_quilt)
        source.aspect = j->layout.aspect;
    j->record = make_record(j);
    if (!j->record)
        return lf_error_set(err, LF_E_NOMEM, a->out, "out of memory");
    const lf_output_request request = {
        .kind = a->kind,
        .path = j->path,
        .overwrite = true,
        .layout = j->layout,
        .calibration = &j->calibration,
        .filter = a->filter,
        .invert = a->invert,
        .print = &j->print,
        .exposure = film ? film->exposure : 0,
        .tonemap = film ? film->tonemap : NULL,
        .settings = j->record,
        .pool = j->pool,
        .cancel = &cancel,
        .progress = show_writing,
        .context = &j->line,
    };
    lf_status status = lf_output_write(&request, &source, err);
    if (status == LF_E_CANCELLED)
        return lf_error_set(err, status, a->out, "interrupted: nothing was written");
    return status;
}

static lf_status write_stats(const job *j, lf_error *err)
{
    const arguments *a = j->arguments;
    const lf_views32 *v32 = &j->quilt.views32;
    const lf_views8 *v8 = &j->quilt.views8;
    const lf_render_report report = {
        .scene = a->scene,
        .renderer = j->renderer,
        .estimator = a->options.estimator,
        .n_views = j->is_quilt ? j->layout.n_views : j->settings.camera.n_views,
        .width = !j->is_quilt        ? j->settings.width
                 : j->quilt.is_float ? v32->width
                                     : v8->width,
        .height = !j->is_quilt        ? j->settings.height
                  : j->quilt.is_float ? v32->height
                                      : v8->height,
        .threads = lf_pool_threads(j->pool),
        .times = j->times,
    };
    json_t *object = lf_render_report_json(&report);
    char *text = object ? json_dumps(object, JSON_INDENT(2)) : NULL;
    lf_outfile file = {.fd = -1};
    lf_status status = text ? LF_OK : lf_error_set(err, LF_E_NOMEM, a->stats, "out of memory");

    if (status == LF_OK)
        status = lf_outfile_open(&file, a->stats, true, err);
    if (status == LF_OK) {
        status = lf_outfile_write(&file, text, strlen(text), err);
        if (status == LF_OK)
            status = lf_outfile_write(&file, "\n", 1, err);
        if (status == LF_OK)
            status = lf_outfile_commit(&file, true, err);
        lf_outfile_abandon(&file);
    }
    free(text);
    json_decref(object);
    return status;
}

static void job_finish(job *j)
{
    lf_renderer_destroy(j->renderer);
    lf_scene_unref(j->scene);
    lf_pool_destroy(j->pool);
    lf_quilt_finish(&j->quilt);
    json_decref(j->record);
    lf_free(j->film);
    lf_free(j->path);
}

static int run(const arguments *a)
{
    job j = {.arguments = a, .line = {.on = isatty(STDERR_FILENO) == 1}};
    lf_error err = {0};
    lf_status status = open_input(&j, &err);
    int code = LF_EXIT_OK;

    if (status == LF_E_ARG) {
        code = lf_usage_error(PROGRAM, &err);
        job_finish(&j);
        return code;
    }
    if (status == LF_OK && !j.is_quilt)
        status = render(&j, &err);
    if (status == LF_OK)
        status = write_output(&j, &err);
    if (status == LF_OK && a->stats)
        status = write_stats(&j, &err);
    clear_line(&j.line);
    if (status != LF_OK) {
        lf_log_error(&err);
        code = LF_EXIT_FAILED;
    } else if (strcmp(j.path, a->out) != 0) {
        /* the suffix was added: say the name */
        lf_log(LF_LOG_INFO, "wrote %s", j.path);
    }
    job_finish(&j);
    return code;
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND};

    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    /* a limit on file size is to be an error like a full disk */
    action = (struct sigaction){.sa_handler = SIG_IGN};
    sigaction(SIGXFSZ, &action, NULL);
    sigaction(SIGPIPE, &action, NULL);
}

int main(int argc, char **argv)
{
    arguments a = {.print = {.bits = 8}};
    lf_error err = {0};
    bool done = false;

    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (parse_arguments(&a, argc, argv, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    catch_signals();
    return run(&a);
}
