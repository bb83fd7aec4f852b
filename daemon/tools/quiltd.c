/* quiltd: the daemon. See docs/man/quiltd.1. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/output.h"
#include "daemon/server/server.h"
#include "device/device.h"

#define PROGRAM "quiltd"

enum {
    OPTION_SOCKET = LF_OPTION_OWN,
    OPTION_DEVICE,
    OPTION_STATE,
    OPTION_ALLOW_PATH,
    OPTION_EXPORT_DIR,
    OPTION_FARM,
    OPTION_PLAYLIST,
    OPTION_SECONDS,
    OPTION_CROSSFADE,
    OPTION_WATCH,
    OPTION_RUN_FOR,
    OPTION_BUTTONS,
    OPTION_WEB,
};

static const struct option table[] = {
    {"socket", required_argument, NULL, OPTION_SOCKET},
    {"device", required_argument, NULL, OPTION_DEVICE},
    {"state", required_argument, NULL, OPTION_STATE},
    {"allow-path", required_argument, NULL, OPTION_ALLOW_PATH},
    {"export-dir", required_argument, NULL, OPTION_EXPORT_DIR},
    {"farm", required_argument, NULL, OPTION_FARM},
    {"playlist", required_argument, NULL, OPTION_PLAYLIST},
    {"seconds", required_argument, NULL, OPTION_SECONDS},
    {"crossfade", required_argument, NULL, OPTION_CROSSFADE},
    {"watch", no_argument, NULL, OPTION_WATCH},
    {"run-for", required_argument, NULL, OPTION_RUN_FOR},
    {"buttons", required_argument, NULL, OPTION_BUTTONS},
    {"web", optional_argument, NULL, OPTION_WEB},
    {NULL, 0, NULL, 0},
};

static const lf_options_words words[] = {
    {"device", lf_device_kind_at}, {"farm", lf_farmed_engine_at}, {0}};

static const char shared[] = "calibration " LF_OPTIONS_VIEWS " " LF_OPTIONS_RENDER
                             " " LF_OPTIONS_IMPORT " exposure guides target-error";

static void print_help(void)
{
    printf("Usage: quiltd [SCENE] [options]\n"
           "Render a scene (JSON) as a light field and show it on a Looking Glass panel.\n"
           "SCENE may also be a model or a volume (.glb, .obj, .vdb ...), a finished quilt or a "
           "folder of views.\n"
           "By default, quiltd uses the lens calibration of the panel and stops rendering at a "
           "relative error of 1e-4.\n\n"
           "  --socket PATH          socket for clients ($QUILTD_SOCKET, "
           "$XDG_RUNTIME_DIR/quiltd.sock,\n"
           "                         /run/quiltd/control.sock)\n"
           "  --device SPEC          auto (default), drm[:OUTPUT], window[:MONITOR],\n"
           "                         usb[:BUS-PORT], sim:DIR[,option=value...] or none\n");
    lf_param_print_help(lf_option_params, shared);
    lf_param_print_help(lf_response_params, NULL);
    lf_param_print_help(lf_alone_params, NULL);
    lf_param_print_help(lf_photo_params, NULL);
    lf_param_print_help(lf_picture_params, NULL);
    lf_param_print_help(lf_standing_params, NULL);
    printf(
        "  --playlist FOLDER      show the pictures, quilts, videos, scenes and models in FOLDER "
        "in turn,\n"
        "                         instead of SCENE\n"
        "  --seconds N            with --playlist: time of each that is no video (10)\n"
        "  --crossfade N          with --playlist: seconds in which images turn into each other "
        "(0)\n"
        "  --state DIR            keep rendering states in DIR across restarts\n"
        "  --allow-path DIR       let clients read files below DIR (repeatable)\n"
        "  --export-dir DIR       let clients write files below DIR\n"
        "  --farm LIST            let clients render on farms: slurm, parallel, list (none)\n"
        "  --buttons LIST         actions of the panel's buttons: none, next, previous, pause "
        "or reset\n"
        "                         (square=pause,left=previous,right=next,circle=reset)\n"
        "  --web[=PORT]           also start quiltweb and print the URL of its page\n"
        "                         (8033; 0: any free port)\n"
        "  --watch                reload the scene when its file or an included file changes\n"
        "  --run-for SECONDS      exit after SECONDS\n" LF_OPTIONS_HELP_LAST
            LF_OPTIONS_HELP_SHELLS);
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    lf_server_config *config = context;
    switch (code) {
    case OPTION_SOCKET:
        config->socket = text;
        return LF_OK;
    case OPTION_DEVICE:
        config->device = text;
        return LF_OK;
    case OPTION_STATE:
        config->state_dir = text;
        return LF_OK;
    case OPTION_EXPORT_DIR:
        config->export_dir = text;
        return LF_OK;
    case OPTION_FARM:
        return lf_farmed_engines(text, &config->farms, err);
    case OPTION_PLAYLIST:
        config->playlist.folder = text;
        return LF_OK;
    case OPTION_SECONDS:
        return lf_parse_double("--seconds", text, 0.1, 86400, &config->playlist.seconds, err);
    case OPTION_CROSSFADE:
        return lf_parse_double("--crossfade", text, 0, LF_MAX_FADE, &config->playlist.crossfade,
                               err);
    case OPTION_WATCH:
        config->watch = true;
        return LF_OK;
    case OPTION_BUTTONS:
        return lf_button_actions_parse(text, &config->buttons, err);
    case OPTION_WEB:
        config->web = true;
        return text ? lf_parse_small("--web", text, 0, 65535, &config->web_port, err) : LF_OK;
    case OPTION_RUN_FOR:
        return lf_parse_double("--run-for", text, 0.001, 1e9, &config->run_for, err);
    case OPTION_ALLOW_PATH:
        if (config->n_allow >= LF_MAX_ROOTS - 2)
            return lf_error_set(err, LF_E_ARG, "--allow-path", "may be given at most %d times",
                                LF_MAX_ROOTS - 2);
        config->allow[config->n_allow++] = text;
        return LF_OK;
    default:
        return lf_error_set(err, LF_E_ARG, "", "option %d is not handled", code);
    }
}

/* The absolute path of a scene or a folder. Owned by the caller. */
static char *absolute(const char *scene)
{
    char *here = getcwd(NULL, 0);
    char *path = here ? lf_path_join(here, scene) : NULL;
    free(here);
    return path;
}

/* Checks that no scene could satisfy. */
static lf_status check_tiles(const lf_options *options, lf_error *err)
{
    const lf_preset *preset = lf_options_preset(options);
    int views = options->views == 0 && preset ? preset->layout.n_views : options->views;
    int tiles = options->columns * options->rows;
    if (preset && preset->is_plain)
        return lf_error_set(err, LF_E_ARG, "--preset",
                            "%s is not for panels with lenses; use it with quiltrender",
                            preset->name);
    if (tiles > 0 && tiles < views)
        return lf_error_set(
            err, LF_E_ARG, "--quilt",
            "%dx%d has %d tiles, but there are %d views; use a larger --quilt or set --views",
            options->columns, options->rows, tiles, views);
    return LF_OK;
}

/* The options of a slideshow belong together. Sets the time of its entries. */
static lf_status check_playlist(lf_server_playlist *playlist, const char *scene, lf_error *err)
{
    const char *lone = playlist->seconds > 0     ? "--seconds"
                       : playlist->crossfade > 0 ? "--crossfade"
                                                 : NULL;
    if (playlist->folder && scene)
        return lf_error_set(err, LF_E_ARG, scene,
                            "a scene and --playlist exclude each other; give one of them");
    if (!playlist->folder && lone)
        return lf_error_set(err, LF_E_ARG, lone, "needs --playlist FOLDER");
    if (playlist->folder && playlist->folder[0] == '\0')
        return lf_error_set(err, LF_E_ARG, "--playlist", "the name of the folder is empty");
    if (!(playlist->seconds > 0))
        playlist->seconds = LF_PLAYLIST_SECONDS;
    return LF_OK;
}

int main(int argc, char *argv[])
{
    lf_server_config config = {.device = "auto", .web_port = LF_SERVER_WEB_PORT};
    const lf_options_part parts[] = {{lf_option_params, shared, &config.options},
                                     {lf_response_params, NULL, &config.response},
                                     {lf_alone_params, NULL, &config.options.alone},
                                     {lf_photo_params, NULL, &config.options.photo},
                                     {lf_picture_params, NULL, &config.options.photo},
                                     {lf_standing_params, NULL, &config.options.standing},
                                     {0}};
    const lf_options_rules rules = {.program = PROGRAM,
                                    .letters = ":",
                                    .parts = parts,
                                    .table = table,
                                    .print_help = print_help,
                                    .take = take,
                                    .context = &config,
                                    .words = words};
    lf_error err;
    bool done = false;
    lf_button_actions_default(&config.buttons);
    lf_param_defaults(lf_standing_params, &config.options.standing);
    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (lf_options_read(argc, argv, &rules, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_options_limit_import(&config.options);
    if (config.farms != 0 && !config.export_dir) {
        (void)lf_error_set(&err, LF_E_ARG, "--farm", "needs --export-dir DIR for jobs and outputs");
        return lf_usage_error(PROGRAM, &err);
    }
    if (check_tiles(&config.options, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    lf_codes codes;
    if (lf_response_codes(&config.response, &codes, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (argc - optind > 1) {
        (void)lf_error_set(&err, LF_E_ARG, argv[optind + 1],
                           "unexpected argument; give only one scene");
        return lf_usage_error(PROGRAM, &err);
    }
    /* An empty operand counts as none: a service's unset variable expands to it. */
    bool has_scene = optind < argc && argv[optind][0] != '\0';
    if (check_playlist(&config.playlist, has_scene ? argv[optind] : NULL, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    const char *shown = has_scene ? argv[optind] : config.playlist.folder;
    char *path = shown ? absolute(shown) : NULL;
    if (shown && !path) {
        lf_log(LF_LOG_ERROR, "%s: cannot find the current folder", shown);
        return LF_EXIT_FAILED;
    }
    config.scene = has_scene ? path : NULL;
    config.playlist.folder = has_scene ? NULL : path;
    config.calibration = config.options.calibration;
    int code = lf_server_run(&config);
    lf_free(path);
    return code;
}
