#include "daemon/render_arguments.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

#define DEFAULT_SPP 16
#define MAX_PASSES (INT64_C(1) << 40)

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

static lf_status take_budget(lf_render_arguments *a, int code, const char *text, lf_error *err)
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

static lf_status take_print_pitch(lf_render_arguments *a, const char *text, lf_error *err)
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

static lf_status take_print_size(lf_render_arguments *a, const char *text, lf_error *err)
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

static lf_status take_orientation(lf_render_arguments *a, const char *text, lf_error *err)
{
    if (strcmp(text, "vertical") != 0 && strcmp(text, "horizontal") != 0)
        return lf_error_set(err, LF_E_ARG, "--orientation", "unknown name \"%s\" (there are: vertical, horizontal)", text);
    a->print.horizontal = strcmp(text, "horizontal") == 0;
    return LF_OK;
}

static lf_status take_bits(lf_render_arguments *a, const char *text, lf_error *err)
{
    if (strcmp(text, "8") != 0 && strcmp(text, "16") != 0)
        return lf_error_set(err, LF_E_ARG, "--bits", "expects 8 or 16, not \"%s\"", text);
    a->print.bits = strcmp(text, "8") == 0 ? 8 : 16;
    return LF_OK;
}

static lf_status take_print(lf_render_arguments *a, int code, const char *text, lf_error *err)
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

/* Says how paths are traced, so nothing where nothing is rendered. */
static bool is_render_option(int code)
{
    return (code >= LF_OPTION_INTEGRATOR && code <= LF_OPTION_TARGET_ERROR && code != LF_OPTION_THREADS) ||
           (code >= OPTION_PASSES && code <= OPTION_TIME);
}

static const char *name_of_option(int code)
{
    for (const struct option *o = table; o->name; o++)
        if (o->val == code)
            return o->name;
    return "";
}

static lf_status take_own(lf_render_arguments *a, int code, const char *text, lf_error *err)
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
static lf_status choose_kind(lf_render_arguments *a, lf_error *err)
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

static lf_status check_arguments(lf_render_arguments *a, int argc, char *const argv[], lf_error *err)
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

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    lf_render_arguments *a = context;
    bool taken = false;
    lf_status status = lf_options_take(&a->options, code, text, &taken, err);

    if (status == LF_OK && !taken)
        status = take_own(a, code, text, err);
    if (status == LF_OK && !a->render_option && is_render_option(code))
        a->render_option = name_of_option(code);
    return status;
}

lf_status lf_render_arguments_parse(int argc, char *const argv[], lf_render_arguments *a, bool *out_done, lf_error *err)
{
    *a = (lf_render_arguments){.print = {.bits = 8}};
    const lf_options_rules rules = {LF_RENDER_PROGRAM, ":o:", table, print_help, NULL, take, a};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);

    return status != LF_OK || *out_done ? status : check_arguments(a, argc, argv, err);
}
