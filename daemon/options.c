#include "daemon/options.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEFAULT_VIEWS 45
#define DEFAULT_VIEW_HEIGHT 560
#define MAX_THREADS 256
#define MAX_DEPTH 65536
#define MAX_TILES 64

/* How many long options the text before any '=' could mean. */
static int count_matches(const struct option *table, const char *text)
{
    size_t n = strcspn(text, "=");
    int matches = 0;

    for (; table->name; table++)
        matches += strncmp(table->name, text, n) == 0;
    return matches;
}

static const char *name_of_code(const struct option *table, int code)
{
    for (; table->name; table++)
        if (table->val == code)
            return table->name;
    return "";
}

lf_status lf_options_next(int argc, char *const argv[], const char *letters, const struct option *table, int *out_code,
                          lf_error *err)
{
    char where[128];

    opterr = 0;
    int code = getopt_long(argc, argv, letters, table, NULL);
    if (code != '?' && code != ':') {
        *out_code = code;
        return LF_OK;
    }
    const char *text = optind > 0 && optind <= argc ? argv[optind - 1] : "";
    if (optopt >= LF_OPTION_PRESET) {
        snprintf(where, sizeof where, "--%s", name_of_code(table, optopt));
        return lf_error_set(err, LF_E_ARG, where, code == ':' ? "expects an argument" : "takes no argument");
    }
    if (optopt != 0) {
        snprintf(where, sizeof where, "-%c", optopt);
        return lf_error_set(err, LF_E_ARG, where, code == ':' ? "expects an argument" : "unknown option (see --help)");
    }
    snprintf(where, sizeof where, "%.100s", text);
    if (strncmp(text, "--", 2) == 0 && count_matches(table, text + 2) > 1)
        return lf_error_set(err, LF_E_ARG, where, "could mean several options (see --help)");
    return lf_error_set(err, LF_E_ARG, where, "unknown option (see --help)");
}

int lf_usage_error(const char *program, const lf_error *err)
{
    char line[1400];

    fprintf(stderr, "%s: %s\n", program, lf_error_format(err, line, sizeof line));
    return LF_EXIT_USAGE;
}

void lf_print_version(const char *program)
{
    printf("%s %s\n", program, LF_VERSION);
}

/* ------------------------------------------------------------------------------------------------------- numbers -- */

lf_status lf_parse_int(const char *option, const char *text, int64_t low, int64_t high, int64_t *out, lf_error *err)
{
    char *end = NULL;
    bool starts = (text[0] >= '0' && text[0] <= '9') || text[0] == '-' || text[0] == '+';

    errno = 0;
    long long value = starts ? strtoll(text, &end, 10) : 0;
    if (!starts || errno != 0 || *end != '\0' || value < low || value > high)
        return lf_error_set(err, LF_E_ARG, option, "expects a whole number from %" PRId64 " to %" PRId64 ", not \"%s\"", low, high,
                            text);
    *out = value;
    return LF_OK;
}

/* Reads one decimal number up to `stop`, which must follow it. */
static bool read_double(const char *text, char stop, double low, double high, double *out, const char **out_end)
{
    char *end = NULL;

    if (strspn(text, "+-.0123456789") == 0 || strpbrk(text, "xXpP"))
        return false;
    double value = strtod(text, &end);
    if (end == text || *end != stop || !(value >= low && value <= high))
        return false;
    *out = value;
    *out_end = end;
    return true;
}

lf_status lf_parse_double(const char *option, const char *text, double low, double high, double *out, lf_error *err)
{
    const char *end = NULL;

    if (!read_double(text, '\0', low, high, out, &end))
        return lf_error_set(err, LF_E_ARG, option, "expects a number from %g to %g, not \"%s\"", low, high, text);
    return LF_OK;
}

lf_status lf_parse_pair(const char *option, const char *text, char separator, double low, double high, double out[2], lf_error *err)
{
    /* "x" cannot be told from hexadecimal by strtod: cut the text in two first */
    const char *cut = strchr(text, separator);
    const char *end = NULL;
    char first[32];
    double pair[2];

    if (cut && (size_t)(cut - text) < sizeof first) {
        memcpy(first, text, (size_t)(cut - text));
        first[cut - text] = '\0';
        if (read_double(first, '\0', low, high, &pair[0], &end) && read_double(cut + 1, '\0', low, high, &pair[1], &end)) {
            memcpy(out, pair, sizeof pair);
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, option, "expects two numbers A%cB from %g to %g, not \"%s\"", separator, low, high, text);
}

lf_status lf_parse_seed(const char *option, const char *text, uint64_t *out, lf_error *err)
{
    char *end = NULL;
    bool starts = text[0] >= '0' && text[0] <= '9';

    errno = 0;
    unsigned long long value = starts ? strtoull(text, &end, 10) : 0;
    if (!starts || errno != 0 || *end != '\0')
        return lf_error_set(err, LF_E_ARG, option, "expects a whole number from 0 to %" PRIu64 ", not \"%s\"", UINT64_MAX, text);
    *out = value;
    return LF_OK;
}

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

static lf_status parse_small(const char *option, const char *text, int low, int high, int *out, lf_error *err)
{
    int64_t value = 0;
    lf_status status = lf_parse_int(option, text, low, high, &value, err);

    if (status == LF_OK)
        *out = (int)value;
    return status;
}

/* --------------------------------------------------------------------------------------------------------- names -- */

static lf_status find_integrator(const char *name, const char **out, lf_error *err)
{
    char known[128] = "";

    for (int i = 0; lf_integrator_name(i); i++) {
        if (strcmp(name, lf_integrator_name(i)) == 0) {
            *out = lf_integrator_name(i);
            return LF_OK;
        }
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", lf_integrator_name(i));
    }
    return lf_error_set(err, LF_E_ARG, "--integrator", "unknown integrator \"%s\" (there are: %s)", name, known);
}

/* Errors of the rooms name what they like as `where`; on the command line it is the option. */
static lf_status blame(lf_status status, const char *option, lf_error *err)
{
    if (status != LF_OK && err)
        snprintf(err->where, sizeof err->where, "%s", option);
    return status;
}

static lf_status take_view_option(lf_options *options, int code, const char *argument, lf_error *err)
{
    switch (code) {
    case LF_OPTION_PRESET:
        return blame(lf_preset_find(argument, &options->preset, err), "--preset", err);
    case LF_OPTION_VIEWS:
        return parse_small("--views", argument, 1, LF_MAX_VIEWS, &options->views, err);
    case LF_OPTION_QUILT:
        return blame(lf_parse_tiles(argument, &options->columns, &options->rows, err), "--quilt", err);
    case LF_OPTION_VIEW_SIZE:
        return parse_view_size(options, argument, err);
    default:
        assert(code == LF_OPTION_CALIBRATION);
        options->calibration = argument;
        return LF_OK;
    }
}

static lf_status take_render_option(lf_options *options, int code, const char *argument, lf_error *err)
{
    lf_status status = LF_OK;

    switch (code) {
    case LF_OPTION_INTEGRATOR:
        return find_integrator(argument, &options->integrator, err);
    case LF_OPTION_ESTIMATOR:
        status = blame(lf_estimator_from_name(argument, &options->estimator, err), "--estimator", err);
        options->has_estimator |= status == LF_OK;
        return status;
    case LF_OPTION_SAMPLER:
        status = blame(lf_sampler_from_name(argument, &options->sampler, err), "--sampler", err);
        options->has_sampler |= status == LF_OK;
        return status;
    case LF_OPTION_THREADS:
        return parse_small("--threads", argument, 1, MAX_THREADS, &options->threads, err);
    case LF_OPTION_SEED:
        status = lf_parse_seed("--seed", argument, &options->seed, err);
        options->has_seed |= status == LF_OK;
        return status;
    case LF_OPTION_SKIP:
        return blame(lf_skip_parse(argument, &options->kept, err), "--skip", err);
    case LF_OPTION_MAX_DEPTH:
        return parse_small("--max-depth", argument, 1, MAX_DEPTH, &options->max_depth, err);
    default:
        assert(code == LF_OPTION_TARGET_ERROR);
        return lf_parse_double("--target-error", argument, 1e-12, 1e6, &options->target_error, err);
    }
}

lf_status lf_options_take(lf_options *options, int code, const char *argument, bool *out_taken, lf_error *err)
{
    *out_taken = code >= LF_OPTION_PRESET && code <= LF_OPTION_CALIBRATION;
    if (!*out_taken)
        return LF_OK;
    if (code <= LF_OPTION_VIEW_SIZE || code == LF_OPTION_CALIBRATION)
        return take_view_option(options, code, argument, err);
    return take_render_option(options, code, argument, err);
}

/* ---------------------------------------------------------------------------------------------------- resolution -- */

void lf_choose_tiles(int n_views, int view_width, int view_height, int *out_columns, int *out_rows)
{
    double best = INFINITY;

    if (n_views == DEFAULT_VIEWS) {
        *out_columns = 5;
        *out_rows = 9;
        return;
    }
    for (int columns = 1; columns <= MAX_TILES && columns <= n_views; columns++) {
        int rows = (n_views + columns - 1) / columns;
        double shape = fabs(log2((double)columns * view_width / ((double)rows * view_height)));
        double score = shape + 4.0 * (columns * rows - n_views) / n_views;
        if (rows <= MAX_TILES && score < best) {
            best = score;
            *out_columns = columns;
            *out_rows = rows;
        }
    }
}

static void resolve_camera(const lf_options *options, const lf_camera *camera, const lf_calibration *calibration, lf_camera *out)
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
            return lf_error_set(err, LF_E_ARG, "--quilt", "%dx%d holds %d tiles, but there are %d views (--views says how many)",
                                options->columns, options->rows, options->columns * options->rows, layout->n_views);
        layout->columns = options->columns;
        layout->rows = options->rows;
    } else if (options->preset && options->preset->layout.n_views == layout->n_views) {
        layout->columns = options->preset->layout.columns;
        layout->rows = options->preset->layout.rows;
    } else {
        lf_choose_tiles(layout->n_views, layout->view_width, layout->view_height, &layout->columns, &layout->rows);
    }
    return LF_OK;
}

lf_status lf_resolve_view(const lf_options *options, const lf_camera *camera, const lf_calibration *calibration,
                          lf_render_settings *out_settings, lf_layout *out_layout, lf_error *err)
{
    lf_render_settings settings = {
        .integrator = options->integrator,
        .sampler = options->sampler,
        .seed = options->seed,
        .max_depth = options->max_depth,
        .kept = options->kept,
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
