#include "daemon/tools/render_arguments.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/output/hld.h"
#include "daemon/tools/job_state.h"

#define MAX_PASSES (INT64_C(1) << 40)
#define MOST_MINUTES 1e6

enum {
    OPTION_OUT = 'o',
    OPTION_PASSES = LF_OPTION_OWN,
    OPTION_SPP,
    OPTION_TIME,
    OPTION_STATS,
    OPTION_STATE,
    OPTION_STATE_INFO,
    OPTION_FILES,
    OPTION_PLAN,
    OPTION_JSON,
    OPTION_TASK_MINUTES,
    OPTION_TASK_MEMORY,
    OPTION_READ_CHART,
    OPTION_CHART_FILE,
};

static const struct option table[] = {
    {"output", required_argument, NULL, OPTION_OUT},
    {"passes", required_argument, NULL, OPTION_PASSES},
    {"spp", required_argument, NULL, OPTION_SPP},
    {"time", required_argument, NULL, OPTION_TIME},
    {"stats", required_argument, NULL, OPTION_STATS},
    {"state", required_argument, NULL, OPTION_STATE},
    {"state-info", required_argument, NULL, OPTION_STATE_INFO},
    {"files", required_argument, NULL, OPTION_FILES},
    {"plan", no_argument, NULL, OPTION_PLAN},
    {"json", no_argument, NULL, OPTION_JSON},
    {"task-minutes", required_argument, NULL, OPTION_TASK_MINUTES},
    {"task-memory", required_argument, NULL, OPTION_TASK_MEMORY},
    {"read-chart", required_argument, NULL, OPTION_READ_CHART},
    {"chart-file", required_argument, NULL, OPTION_CHART_FILE},
    {NULL, 0, NULL, 0},
};

#define PLACE(field) .place = offsetof(lf_state_arguments, field)

/* clang-format off */
const lf_param lf_state_params[] = {
    {.option = "rows", .joined = ":", .argument = "A", PLACE(first_row), .type = LF_PARAM_WHOLE,
     .has = offsetof(lf_state_arguments, has_rows), .high = LF_MAX_VIEW_SIDE - 1,
     .help = "render only image rows A to B, into the file of --state"},
    {.option = "rows", .argument = "B", PLACE(last_row), .type = LF_PARAM_WHOLE,
     .high = LF_MAX_VIEW_SIDE - 1},
    {.option = "stream", .argument = "K", PLACE(stream), .type = LF_PARAM_WHOLE,
     .has = offsetof(lf_state_arguments, has_stream), .high = LF_MAX_STREAM,
     .help = "render random stream K of the seed, into the file of --state"},
    {0},
};
/* clang-format on */

static const char shared[] = LF_OPTIONS_VIEWS " " LF_OPTIONS_RENDER " " LF_OPTIONS_IMPORT
                                              " exposure panel png still quality target-error "
                                              "target-denoised-error target-shown-error aov"
                                              " fit guides light-paths suffixes";
static const char of_depth[] = "chroma-depth depthiness depth-cutoff";
/* Options of path tracing, which have no meaning if nothing is rendered. */
static const char tracing[] =
    "integrator estimator sampler max-depth light-paths suffixes skip seed target-error "
    "target-denoised-error target-shown-error aov fit guides denoise reconstruct";

static lf_status take_budget(lf_render_arguments *a, int code, const char *text, lf_error *err)
{
    a->budgets |= 1u << (code == OPTION_PASSES ? 0 : code == OPTION_SPP ? 1 : 2);
    if (!a->render_option)
        a->render_option = code == OPTION_PASSES ? "passes" : code == OPTION_SPP ? "spp" : "time";
    switch (code) {
    case OPTION_PASSES:
        return lf_parse_int("--passes", text, 1, MAX_PASSES, &a->budget.passes, err);
    case OPTION_SPP:
        return lf_parse_int("--spp", text, 1, MAX_PASSES / LF_MAX_VIEWS, &a->spp, err);
    default:
        return lf_parse_double("--time", text, 1e-3, 1e9, &a->budget.seconds, err);
    }
}

static lf_status take_plan(lf_render_arguments *a, int code, const char *text, lf_error *err)
{
    lf_plan_arguments *p = &a->plan;
    if (!p->option && code != OPTION_PLAN)
        p->option = code == OPTION_JSON           ? "json"
                    : code == OPTION_TASK_MINUTES ? "task-minutes"
                                                  : "task-memory";
    switch (code) {
    case OPTION_JSON:
        p->json = true;
        return LF_OK;
    case OPTION_TASK_MINUTES:
        return lf_parse_double("--task-minutes", text, 0, MOST_MINUTES, &p->minutes, err);
    case OPTION_TASK_MEMORY:
        return lf_parse_bytes("--task-memory", text, &p->memory, err);
    default:
        p->on = true;
        a->render_option = a->render_option ? a->render_option : "plan";
        return LF_OK;
    }
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    lf_render_arguments *a = context;
    switch (code) {
    case OPTION_OUT:
        a->out = text;
        return LF_OK;
    case OPTION_STATS:
        a->stats = text;
        return LF_OK;
    case OPTION_STATE:
        a->state.file = text;
        a->render_option = a->render_option ? a->render_option : "state";
        return LF_OK;
    case OPTION_STATE_INFO:
        a->state.info = text;
        return LF_OK;
    case OPTION_FILES:
        a->files = text;
        return LF_OK;
    case OPTION_PLAN:
    case OPTION_JSON:
    case OPTION_TASK_MINUTES:
    case OPTION_TASK_MEMORY:
        return take_plan(a, code, text, err);
    case OPTION_READ_CHART:
        a->of_print.photo = text;
        return LF_OK;
    case OPTION_CHART_FILE:
        a->of_print.chart_file = text;
        return LF_OK;
    default:
        return take_budget(a, code, text, err);
    }
}

/* The kind of output selected by an option; NULL: none. */
static const lf_output_kind *kind_of_option(const char *option)
{
    for (int i = 0; lf_output_kinds[i]; i++)
        if (lf_output_kinds[i]->option && strcmp(lf_output_kinds[i]->option, option) == 0)
            return lf_output_kinds[i];
    return strcmp(lf_output_wiggle.option, option) == 0     ? &lf_output_wiggle
           : strcmp(lf_output_hologram.option, option) == 0 ? &lf_output_hologram
                                                            : NULL;
}

static void take_video_option(lf_render_arguments *a, const char *option)
{
    const bool is_fps = strcmp(option, "fps") == 0;
    a->video_option = a->video_option ? a->video_option : option;
    a->has_codec |= strcmp(option, "codec") == 0;
    a->has_fps |= is_fps;
    a->mp4_option = a->mp4_option || is_fps ? a->mp4_option : option;
}

/* Stores the selected kinds, and the first option of each group that depends on a kind. */
static void taken(void *context, const lf_param *params, const lf_param *row)
{
    lf_render_arguments *a = context;
    const lf_output_kind *kind = kind_of_option(row->option);
    if (kind && a->asked && kind != a->asked)
        a->asked_too = kind;
    else if (kind)
        a->asked = kind;
    if (params != lf_print_params && params != lf_profile_params && !a->of_print.other)
        a->of_print.other = row->option;
    if (params == lf_print_params)
        lf_print_give(&a->of_print.given, kind ? lf_param_find(lf_print_params, "print") : row);
    if ((params == lf_print_params || params == lf_profile_params || params == lf_check_params) &&
        !kind && !a->of_print.option)
        a->of_print.option = row->option;
    if ((params == lf_panel_params || params == lf_response_params) && !a->panel_option)
        a->panel_option = row->option;
    if ((params == lf_photo_params || params == lf_picture_params ||
         params == lf_standing_params) &&
        !a->photo_option)
        a->photo_option = row->option;
    const bool is_inversion = strcmp(row->option, "depth-inversion") == 0;
    a->depth.inverts |= is_inversion;
    if (!a->depth.option && (is_inversion || lf_param_among(row, of_depth)))
        a->depth.option = row->option;
    if (params == lf_simulate_params && !a->of_print.simulate.first)
        a->of_print.simulate.first = row->option;
    if (params == lf_rgbd_params && !kind && !is_inversion && !a->depth.rgbd)
        a->depth.rgbd = row->option;
    if (params == lf_hologram_params && !kind && !a->hologram.option)
        a->hologram.option = row->option;
    if (params == lf_state_params && !a->render_option)
        a->render_option = row->option;
    if (params == lf_video_params && !kind)
        take_video_option(a, row->option);
    if (!a->render_option && (params == lf_integrator_params() ||
                              (params == lf_option_params && lf_param_among(row, tracing))))
        a->render_option = row->option;
}

/* A drawn output is not rendered: refuses options about the scene and rendering. */
static lf_status refuse_rendering(const lf_render_arguments *a, lf_error *err)
{
    const lf_options *o = &a->options;
    const char *other = a->scene            ? a->scene
                        : a->stats          ? "--stats"
                        : o->preset         ? "--preset"
                        : o->columns > 0    ? "--quilt"
                        : o->view_width > 0 ? "--view-size"
                        : o->has_exposure   ? "--exposure"
                        : a->depth.inverts  ? "--depth-inversion"
                                            : NULL;
    const char *option = a->panel_option   ? a->panel_option
                         : a->photo_option ? a->photo_option
                                           : a->render_option;
    char where[64];
    if (!other && option) {
        snprintf(where, sizeof where, "--%s", option);
        other = where;
    }
    if (!other)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, other, "cannot be combined with --%s, which renders nothing",
                        a->kind->option);
}

static bool reads_print(const lf_output_kind *kind)
{
    return kind->check_print;
}

static bool reads_panel(const lf_output_kind *kind)
{
    return kind->needs_panel;
}

static bool reads_rgbd(const lf_output_kind *kind)
{
    return kind->layers;
}

/* Refuses an option that depends on a kind that was not selected. */
static lf_status refuse_option(const char *option, bool (*reads)(const lf_output_kind *),
                               lf_error *err)
{
    char where[64], known[128] = "";
    for (int i = 0; lf_output_kinds[i]; i++) {
        const lf_output_kind *kind = lf_output_kinds[i];
        size_t used = strlen(known);
        if (reads(kind))
            snprintf(known + used, sizeof known - used, "%s--%s", used ? " or " : "", kind->option);
    }
    snprintf(where, sizeof where, "--%s", option);
    return lf_error_set(err, LF_E_ARG, where, "needs %s", known);
}

static lf_status check_video(const lf_render_arguments *a, lf_error *err)
{
    char where[64];
    const bool is_gif = lf_path_has_ending(a->out, ".gif"),
               is_video = a->kind == &lf_output_video || a->kind == &lf_output_wiggle;
    const char *option = !is_video ? a->video_option : is_gif ? a->mp4_option : NULL;
    if (!option)
        return LF_OK;
    snprintf(where, sizeof where, "--%s", option);
    return lf_error_set(err, LF_E_ARG, where, "applies only to OUT.mp4");
}

static lf_status check_hologram(const lf_render_arguments *a, lf_error *err)
{
    const lf_options *o = &a->options;
    char where[64];
    if (a->kind != &lf_output_hologram) {
        snprintf(where, sizeof where, "--%s", a->hologram.option ? a->hologram.option : "");
        return a->hologram.option
                   ? lf_error_set(err, LF_E_ARG, where, "needs --hologram and a folder as -o")
                   : LF_OK;
    }
    if (o->preset || o->columns > 0 || a->frames.has_range || a->frames.turntable > 0)
        return lf_error_set(err, LF_E_ARG, "--hologram", "cannot be combined with --%s",
                            o->preset             ? "preset; use --hologram-preset"
                            : o->columns > 0      ? "quilt"
                            : a->frames.has_range ? "frames; a plate holds one scene"
                                                  : "turntable; use --hologram-preset");
    return lf_hologram_check(&a->hologram.options, err);
}

/* Checks the kind and the options that depend on it. */
static lf_status check_kind(const lf_render_arguments *a, lf_error *err)
{
    char where[64];
    snprintf(where, sizeof where, "--%s", a->asked ? a->asked->option : "print-size");
    if (a->asked_too)
        return lf_error_set(err, LF_E_ARG, where,
                            "cannot be combined with --%s; run one job for each output",
                            a->asked_too->option);
    if (!a->kind->check_print && a->of_print.option)
        return refuse_option(a->of_print.option, reads_print, err);
    if (a->kind->check_print && lf_output_check_given(a->kind->what, a->kind->reads,
                                                      &a->of_print.given, true, NULL, err) != LF_OK)
        return LF_E_ARG;
    if (a->kind->check_print && !(a->print.width_mm > 0))
        return lf_error_set(err, LF_E_ARG, where,
                            a->asked ? "needs --print-size WxH in mm"
                                     : "is missing; give WxH in mm");
    if (!a->kind->needs_panel && a->panel_option)
        return refuse_option(a->panel_option, reads_panel, err);
    if (!a->kind->layers && a->depth.rgbd)
        return refuse_option(a->depth.rgbd, reads_rgbd, err);
    if (check_video(a, err) != LF_OK || check_hologram(a, err) != LF_OK)
        return LF_E_ARG;
    if (a->options.layers && !lf_output_is_light(a->kind, a->out))
        return lf_error_set(err, LF_E_ARG, "--aov",
                            "applies only to OUT.exr and folders of EXR views");
    if (a->options.file.quality > 0 && !lf_path_has_ending(a->out, ".jpg") &&
        !lf_path_has_ending(a->out, ".jpeg"))
        return lf_error_set(err, LF_E_ARG, "--quality", "applies only to OUT.jpg");
    if (a->options.guides && (a->kind->layers || !lf_path_has_ending(a->out, ".png")))
        return lf_error_set(err, LF_E_ARG, "--guides", "applies only to OUT.png without --rgbd");
    return LF_OK;
}

/* The kind whose endings fit OUT, among kinds that no option selects. */
static lf_status kind_of_ending(const char *out, const lf_output_kind **out_kind, lf_error *err)
{
    const lf_output_kind *meant = NULL; /* by an option that is missing */
    char endings[64];
    if (lf_output_fits(&lf_output_video, out)) {
        *out_kind = &lf_output_video;
        return LF_OK;
    }
    for (int i = 0; lf_output_kinds[i]; i++) {
        const lf_output_kind *kind = lf_output_kinds[i];
        if (!lf_output_fits(kind, out))
            continue;
        if (!kind->option) {
            *out_kind = kind;
            return LF_OK;
        }
        meant = meant ? meant : kind;
    }
    if (lf_path_has_ending(out, ".gif"))
        return lf_error_set(err, LF_E_ARG, out, ".gif holds a loop of views; add --wiggle");
    if (meant)
        return lf_error_set(err, LF_E_ARG, out, "this is the name of %s; add --%s", meant->what,
                            meant->option);
    return lf_error_set(err, LF_E_ARG, out,
                        "must end in %s for an image; quiltrender(1) has other outputs under OUT",
                        lf_output_endings(&lf_output_quilt, endings, sizeof endings));
}

/* Determines the kind of OUT from the options and its ending. */
static lf_status choose_kind(lf_render_arguments *a, lf_error *err)
{
    char *path = NULL;
    lf_status status = LF_OK;
    const bool is_video = lf_output_fits(&lf_output_video, a->out);
    if (a->asked && !(a->asked == &lf_output_still && is_video))
        a->kind = a->asked;
    else if (a->of_print.profiles.lens &&
             (lf_output_fits(&lf_output_print, a->out) || a->print.frame_ppi > 0))
        a->kind = &lf_output_print; /* --print is not needed: profiles give pitch and raster */
    else
        status = kind_of_ending(a->out, &a->kind, err);
    if (status == LF_OK && a->kind == &lf_output_print && a->print.frame_ppi > 0)
        a->kind = &lf_output_frame_set;
    if (status == LF_OK && a->kind->is_drawn && !a->asked_too)
        status = refuse_rendering(a, err);
    if (status == LF_OK)
        status = check_kind(a, err);
    lf_codes codes;
    if (status == LF_OK)
        status = lf_response_codes(&a->panel.response, &codes, err);
    if (status == LF_OK)
        status = lf_rgbd_check(&a->rgbd, "--near", err);
    a->options.layers |= status == LF_OK ? a->kind->layers : 0;
    a->print.n_views = a->options.views;
    if (status == LF_OK && a->kind->is_drawn)
        status = a->kind->check_print(&a->print, NULL, err);
    /* the tiles in a name are checked once the layout is known */
    if (status == LF_OK && !a->kind->has_tiles)
        status = lf_output_path(a->kind, a->out, NULL, &path, err);
    lf_free(path);
    return status;
}

/* A preset for a display without a lens: its videos are HEVC, and a turntable unless an option
 * about frames is given. */
static lf_status take_plain_preset(lf_render_arguments *a, lf_error *err)
{
    const lf_preset *preset = lf_options_preset(&a->options);
    if (!preset || !preset->is_plain)
        return LF_OK;
    if (a->kind->needs_panel || a->kind->check_print || a->kind->layers)
        return lf_error_set(
            err, LF_E_ARG, "--preset",
            "%s is one view for a display without lenses and cannot be combined with --%s",
            preset->name, a->kind->option);
    if (a->options.views > 1 || a->options.columns > 1 || a->options.rows > 1)
        return lf_error_set(err, LF_E_ARG, "--preset",
                            "%s is one view and cannot be combined with --%s", preset->name,
                            a->options.views > 1 ? "views" : "quilt");
    if (a->kind != &lf_output_video)
        return LF_OK;
    if (!a->has_codec)
        a->video.codec = LF_CODEC_H265;
    if (lf_frames_wanted(&a->frames))
        return LF_OK;
    a->frames.turntable = LF_HLD_FRAMES;
    return lf_frames_check(&a->frames, err);
}

/* --still is --views 1. */
static lf_status take_still(lf_render_arguments *a, lf_error *err)
{
    if (a->options.file.still && a->options.views > 1)
        return lf_error_set(err, LF_E_ARG, "--still",
                            "is one view and cannot be combined with --views %d", a->options.views);
    if (a->options.file.still)
        a->options.views = 1;
    return LF_OK;
}

/* Refuses options that are only for a single picture. */
static lf_status check_frames(const lf_render_arguments *a, lf_error *err)
{
    const char *where = lf_frames_option(&a->frames);
    if (a->kind->is_drawn)
        return lf_error_set(err, LF_E_ARG, where,
                            "cannot be combined with --%s, which renders nothing", a->kind->option);
    if (a->stats)
        return lf_error_set(err, LF_E_ARG, "--stats",
                            "cannot be combined with %s; render one frame at a time for it", where);
    if (a->kind == &lf_output_wiggle)
        return lf_error_set(
            err, LF_E_ARG, "--wiggle",
            "cannot be combined with %s, because it loops through the views of one image", where);
    if (a->frames.overwrite && (a->state.file || a->plan.on))
        return lf_error_set(err, LF_E_ARG, "--overwrite",
                            "cannot be combined with %s, which continues after finished %s; remove "
                            "the old files first",
                            a->plan.on ? "--plan" : "--state", lf_frames_noun(&a->frames));
    if (a->frames.of_rows && a->kind == &lf_output_video)
        return lf_error_set(err, LF_E_ARG, where,
                            "cannot be combined with a video; write the rows as quilts or folders");
    return LF_OK;
}

/* auto: image files are reconstructed; measurements and references are not. */
static lf_status choose_reconstruction(lf_render_arguments *a, lf_error *err)
{
    lf_options *o = &a->options;
    const lf_integrator_entry *entry = lf_integrator_named(o->integrator);
    if (o->denoise == LF_DENOISE_AUTO && (o->has_estimator || lf_output_is_light(a->kind, a->out) ||
                                          (entry && !entry->reconstructs)))
        o->denoise = LF_DENOISE_OFF;
    return o->target_denoised_error > 0 && o->denoise == LF_DENOISE_OFF
               ? lf_error_set(err, LF_E_ARG, "--target-denoised-error",
                              "needs a denoised image; add --denoise on")
               : LF_OK;
}

/* A folder of pictures with depth is a batch if OUT is a folder, too. LF_E_IO: there is no input;
 * LF_E_ARG: both are the same folder, where outputs would be the next run's inputs. */
static lf_status take_batch(lf_render_arguments *a, lf_error *err)
{
    struct stat folder, out;
    const lf_rgbd_in side = a->options.standing.rgbd_in;
    const bool is_jpeg = a->options.file.quality > 0 && (!a->asked || !a->asked->needs_panel);
    if (!a->scene || side == LF_RGBD_IN_AUTO || side == LF_RGBD_IN_OFF ||
        !lf_output_fits(&lf_output_views, a->out))
        return LF_OK;
    if (stat(a->scene, &folder) != 0)
        return lf_error_set(err, LF_E_IO, a->scene, "cannot open: %s", lf_errno_text(errno));
    if (!S_ISDIR(folder.st_mode))
        return LF_OK;
    if (stat(a->out, &out) == 0 && out.st_dev == folder.st_dev && out.st_ino == folder.st_ino)
        return lf_error_set(err, LF_E_ARG, a->out,
                            "is the folder of the images; choose another folder for the outputs");
    a->depth.batch = a->out;
    bool is_print = a->of_print.profiles.lens;
    if (a->asked)
        is_print = a->asked->check_print;
    a->out = is_print                                     ? "batch.tif"
             : a->asked == &lf_output_wiggle              ? "batch.gif"
             : is_jpeg && !(a->asked && a->asked->layers) ? "batch.jpg"
                                                          : "batch.png";
    return LF_OK;
}

/* A photo of a chart is read, and nothing is rendered. */
static lf_status check_read_chart(const lf_render_arguments *a, bool has_scene, lf_error *err)
{
    const char *other = has_scene           ? "a scene"
                        : a->asked          ? a->asked->option
                        : a->of_print.other ? a->of_print.other
                        : a->render_option  ? a->render_option
                        : a->stats          ? "stats"
                                            : NULL;
    if (!a->of_print.photo)
        return lf_error_set(err, LF_E_ARG, "--chart-file", "needs --read-chart PHOTO");
    if (other)
        return lf_error_set(err, LF_E_ARG, "--read-chart", "cannot be combined with %s%s",
                            has_scene ? "" : "--", other);
    if (a->out && !lf_path_has_ending(a->out, ".json"))
        return lf_error_set(err, LF_E_ARG, a->out, "must end in .json, the result of --read-chart");
    return lf_output_check_given("--read-chart", "thickness index distance", &a->of_print.given,
                                 true, NULL, err);
}

/* Refuses options that do not go with a part of a picture. */
static lf_status check_part(const lf_render_arguments *a, lf_error *err)
{
    const lf_state_arguments *s = &a->state;
    const char *where = s->has_rows ? "--rows" : "--stream";
    const char *other = a->stats                               ? "--stats"
                        : a->files                             ? "--files"
                        : a->options.target_error > 0          ? "--target-error"
                        : a->options.target_denoised_error > 0 ? "--target-denoised-error"
                        : a->budget.seconds > 0                ? "--time"
                                                               : NULL;
    if (!s->file)
        return lf_error_set(err, LF_E_ARG, where,
                            "needs --state FILE, which receives what is rendered");
    if (s->has_rows && s->first_row > s->last_row)
        return lf_error_set(err, LF_E_ARG, where,
                            "%d:%d ends before it begins; expected FIRST:LAST with FIRST <= LAST",
                            s->first_row, s->last_row);
    if (other)
        return lf_error_set(err, LF_E_ARG, where, "cannot be combined with %s%s", other,
                            a->stats || a->files ? "" : "; give --spp or --passes");
    return LF_OK;
}

static lf_status check_arguments(lf_render_arguments *a, int argc, char *const argv[],
                                 lf_error *err)
{
    if (a->state.info && (optind < argc || a->out))
        return lf_error_set(err, LF_E_ARG, "--state-info", "renders nothing; omit SCENE and -o");
    if (a->state.info)
        return LF_OK;
    if (a->of_print.photo || a->of_print.chart_file)
        return check_read_chart(a, optind < argc, err);
    if (a->of_print.simulate.first) {
        char where[64];
        snprintf(where, sizeof where, "--%s", a->of_print.simulate.first);
        return lf_error_set(err, LF_E_ARG, where, "needs --simulate and a finished print");
    }
    if (optind >= argc && !(a->asked && a->asked->is_drawn))
        return lf_error_set(err, LF_E_ARG, "SCENE", "is missing; see --help");
    if (optind + 1 < argc)
        return lf_error_set(err, LF_E_ARG, argv[optind + 1],
                            a->print.sheet.columns > 1 || a->print.sheet.rows > 1
                                ? "unexpected argument; --copies repeats one SCENE, it does not "
                                  "put different ones on a sheet"
                                : "unexpected argument; give only one SCENE");
    a->scene = optind < argc ? argv[optind] : NULL;
    if (!a->out || a->out[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "-o", "is missing; it gives the output file");
    a->options.standing.depth_inversion = a->rgbd.near_is_black;
    if (take_batch(a, err) != LF_OK)
        return err->status;
    if (a->depth.batch && (a->stats || a->files))
        return lf_error_set(err, LF_E_ARG, a->stats ? "--stats" : "--files",
                            "cannot be combined with a folder of images with depth");
    if (a->plan.option && !a->plan.on) {
        char where[64];
        snprintf(where, sizeof where, "--%s", a->plan.option);
        return lf_error_set(err, LF_E_ARG, where, "needs --plan");
    }
    a->budget.target_error = a->options.target_error;
    a->budget.target_denoised_error = a->options.target_denoised_error;
    a->n_budgets = __builtin_popcount(a->budgets) + (a->options.target_error > 0) +
                   (a->options.target_denoised_error > 0);
    if (a->n_budgets > 1)
        return lf_error_set(err, LF_E_ARG,
                            "--passes, --spp, --time, --target-error, --target-denoised-error",
                            "cannot be combined; give only one of them");
    if (a->options.denoise == LF_DENOISE_ON && a->options.estimator != LF_ESTIMATOR_MWIS)
        return lf_error_set(err, LF_E_ARG, "--denoise", "on needs --estimator mwis");
    a->hologram.all_rows = !a->frames.of_rows;
    lf_status status = lf_options_check_integrator(&a->options, err);
    if (status == LF_OK)
        status = lf_frames_check(&a->frames, err);
    if (status == LF_OK)
        status = take_still(a, err);
    if (status == LF_OK)
        status = choose_kind(a, err);
    if (status == LF_OK)
        status = choose_reconstruction(a, err);
    if (status == LF_OK)
        status = take_plain_preset(a, err);
    if (status == LF_OK && a->kind == &lf_output_hologram)
        a->frames.of_rows = true;
    if (status == LF_OK && lf_state_is_all(&a->state))
        status = check_part(a, err);
    return status == LF_OK && lf_frames_wanted(&a->frames) ? check_frames(a, err) : status;
}

/* Profiles have no word for --print. */
static void explain_print(lf_error *err)
{
    const size_t used = err ? strlen(err->what) : 0;
    if (err && strcmp(err->where, "--print") == 0)
        snprintf(err->what + used, sizeof err->what - used,
                 "; without --print, --lens and --printer give both");
}

lf_status lf_render_arguments_parse(int argc, char *const argv[], lf_render_arguments *a,
                                    bool *out_done, lf_error *err)
{
    const lf_options_part parts[] = {{lf_option_params, shared, &a->options},
                                     {lf_integrator_params(), NULL, &a->options.choices},
                                     {lf_alone_params, NULL, &a->options.alone},
                                     {lf_panel_params, NULL, &a->panel},
                                     {lf_response_params, NULL, &a->panel.response},
                                     {lf_print_params, NULL, &a->print},
                                     {lf_profile_params, NULL, &a->of_print.profiles},
                                     {lf_simulate_params, NULL, &a->of_print.simulate},
                                     {lf_check_params, NULL, &a->of_print.check},
                                     {lf_rgbd_params, NULL, &a->rgbd},
                                     {lf_hologram_params, NULL, &a->hologram.options},
                                     {lf_photo_params, NULL, &a->options.photo},
                                     {lf_picture_params, NULL, &a->options.photo},
                                     {lf_standing_params, LF_RENDER_STANDING, &a->options.standing},
                                     {lf_frames_params, NULL, &a->frames},
                                     {lf_state_params, NULL, &a->state},
                                     {lf_video_params, NULL, &a->video},
                                     {0}};
    const lf_options_rules rules = {.program = LF_RENDER_PROGRAM,
                                    .letters = ":o:",
                                    .parts = parts,
                                    .table = table,
                                    .print_help = lf_render_help,
                                    .take = take,
                                    .taken = taken,
                                    .context = a};
    *a = (lf_render_arguments){.argv = argv, .plan.minutes = LF_PLAN_MINUTES};
    a->options.tracing.offline = true;
    lf_param_defaults(lf_print_params, &a->print);
    lf_param_defaults(lf_video_params, &a->video);
    lf_param_defaults(lf_standing_params, &a->options.standing);
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK)
        explain_print(err);
    return status != LF_OK || *out_done ? status : check_arguments(a, argc, argv, err);
}
