#include "daemon/output/options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/sandbox/import.h"

#define DEFAULT_VIEWS 45
#define DEFAULT_VIEW_HEIGHT 560
#define STILL_HEIGHT 1080

static const char *preset_at(int index)
{
    return lf_preset_at(index) ? lf_preset_at(index)->name : NULL;
}

static const char *integrator_at(int index)
{
    return lf_integrator_at(index) ? lf_integrator_at(index)->name : NULL;
}

static const char *skip_at(int index)
{
    return lf_skip_at(index) ? lf_skip_at(index)->name : NULL;
}

static const char *layer_at(int index)
{
    return lf_layer_at(index) ? lf_layer_at(index)->name : NULL;
}

const char *lf_denoise_name(int index)
{
    static const char *const words[] = {"auto", "off", "on"};
    return index <= LF_DENOISE_ON ? words[index] : NULL;
}

static const char *const exposures[] = {"auto", "scene", NULL};
static const char *const light_paths[] = {"auto", "none", NULL};
static const char *const suffixes[] = {"auto", "1", "2", "4", "8"};

static const char *suffixes_at(int index)
{
    return index < (int)(sizeof suffixes / sizeof *suffixes) ? suffixes[index] : NULL;
}

/* Of reference modes --help has only the names. */
static const char *sharing_at(int index)
{
    const lf_integrator_entry *entry = lf_integrator_at(index);
    for (int i = 0; lf_integrator_reference(i); i++)
        if (strcmp(entry->name, lf_integrator_reference(i)) == 0)
            return "";
    return entry->what;
}

#define PLACE(field) .place = offsetof(lf_options, field)

/* clang-format off */
const lf_param lf_option_params[] = {
    {.option = "preset", .argument = "NAME", PLACE(preset),
     .type = LF_PARAM_NAME, .word_at = preset_at, .initial = -1,
     .help = "layout, view size and aspect of a panel"},
    {.option = "views", .argument = "N", PLACE(views),
     .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEWS,
     .help = "number of views (scene's, else 45)"},
    {.option = "quilt", .joined = "x", .argument = "C", PLACE(columns),
     .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_TILES,
     .help = "tiles of the quilt, columns x rows (preset's; 5x9 for 45 views; else nearly square)"},
    {.option = "quilt", .argument = "R", PLACE(rows),
     .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_TILES},
    {.option = "view-size", .joined = "x", .argument = "W", PLACE(view_width),
     .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEW_SIDE,
     .help = "pixels of one view (those of preset or panel, else 560 high)"},
    {.option = "view-size", .argument = "H", PLACE(view_height),
     .type = LF_PARAM_WHOLE, .low = 1, .high = LF_MAX_VIEW_SIDE},
    {.option = "panel", .argument = "FILE", PLACE(calibration), .type = LF_PARAM_TEXT,
     .help = "interlace for the panel with calibration FILE; writes OUT.png"},
    {.option = "calibration", .argument = "FILE", PLACE(calibration), .type = LF_PARAM_TEXT,
     .help = "the panel's lens calibration"},
    {.name = "integrator", .option = "integrator", .argument = "NAME", PLACE(integrator),
     .type = LF_PARAM_NAME, .word_at = integrator_at, .what_at = sharing_at,
     .refused_at = lf_integrator_reference,
     .refusal = "is a reference mode; use it with quiltrender or quiltbench",
     .about = "how views share light paths; another one starts the image again"},
    {.name = "estimator", .option = "estimator", .argument = "NAME", PLACE(estimator),
     .has = offsetof(lf_options, has_estimator),
     .type = LF_PARAM_WORD, .word_at = lf_estimator_name,
     .about = "how samples become the image; mwis has the least noise, mis and cv are unbiased"},
    {.option = "sampler", .argument = "NAME", PLACE(sampler),
     .type = LF_PARAM_WORD, .word_at = lf_sampler_name,
     .help = "owen: scrambled Sobol points; independent: random numbers"},
    {.option = "max-depth", .argument = "N", PLACE(max_depth),
     .type = LF_PARAM_WHOLE, .low = 1, .high = 65536,
     .help = "longest path, in vertices after the camera (scene's)"},
    {.option = "light-paths", .argument = "auto|none|N", PLACE(tracing.light_paths),
     .has = offsetof(lf_options, tracing.has_light_paths), .low = 1, .high = LF_LIGHT_PATHS_MOST,
     .words = light_paths,
     .help = "paths traced from lights, for each pass; auto: as the scene needs (auto)"},
    {.option = "suffixes", .argument = "auto|1|2|4|8", PLACE(tracing.suffixes),
     .type = LF_PARAM_WORD, .word_at = suffixes_at,
     .help = "paths per point of a diffuse surface; auto: as needed"},
    {.option = "skip", .argument = "all|none|LIST", PLACE(tracing.skip),
     .has = offsetof(lf_options, tracing.has_skip), .type = LF_PARAM_LIST, .word_at = skip_at,
     .help = "optimisations to use where the scene allows them (all)"},
    {.option = "aov", .argument = "all|none|LIST", PLACE(layers), .type = LF_PARAM_LIST,
     .word_at = layer_at, .help = "extra layers of EXR files (none)"},
    {.option = "fit", .argument = "NAME", PLACE(fit.name), .has = offsetof(lf_options, fit.on),
     .type = LF_PARAM_TEXT, .optional = true,
     .help = "move the camera so that the scene, or mesh or volume NAME, fills the views"},
    {.name = "png", .option = "png", PLACE(file.png), .type = LF_PARAM_SWITCH,
     .help = "write the views of OUT/ as 8-bit PNG instead of EXR",
     .about = "no effect in quiltd"},
    {.option = "still", PLACE(file.still), .type = LF_PARAM_SWITCH,
     .help = "render one plain view, 1080 pixels high; of a finished quilt take the middle view"},
    {.option = "quality", .argument = "N", PLACE(file.quality), .type = LF_PARAM_WHOLE, .low = 1,
     .high = 100, .help = "quality of OUT.jpg, 1 to 100 (92)"},
    {.name = "guides", .option = "guides", PLACE(guides), .type = LF_PARAM_SWITCH,
     .help = "tint what is too near (red) or too far (blue) for the panel to show sharply"},
    {.name = "threads", .option = "threads", .argument = "N", PLACE(threads),
     .type = LF_PARAM_WHOLE, .low = 0, .high = 256, .unit = "threads",
     .help = "worker threads; 0: all CPUs",
     .about = "worker threads; 0: all CPUs; another number starts the image again"},
    {.option = "seed", .argument = "S", PLACE(seed), .type = LF_PARAM_SEED,
     .help = "random seed (0)"},
    {.name = "exposure", .option = "exposure", .argument = "auto|scene|STOPS", PLACE(exposure),
     .has = offsetof(lf_options, has_exposure), .low = -32, .high = 32, .words = exposures,
     .help = "exposure in stops; auto: as bright as the screen allows (scene)",
     .about = "stops; auto: measured; scene: the scene's own"},
    {.name = "target_error", .option = "target-error", .argument = "RELMSE", PLACE(target_error),
     .low = 1e-12, .high = 1e6,
     .help = "render until the estimated relative mean squared error is below RELMSE",
     .about = "rendering rests when the bound of the error is below this relative mean squared "
              "error"},
    {.option = "target-denoised-error", .argument = "RELMSE", PLACE(target_denoised_error),
     .low = 1e-12, .high = 1e6,
     .help = "render until the error of the denoised image is below RELMSE"},
    {.option = "target-shown-error", .former = "target-denoised-error", .argument = "RELMSE",
     PLACE(target_denoised_error), .low = 1e-12, .high = 1e6},
    {.name = "denoise", .option = "denoise", .argument = "auto|off|on", PLACE(denoise),
     .type = LF_PARAM_WORD, .word_at = lf_denoise_name,
     .help = "denoise; auto: off for EXR files and with --estimator, else on",
     .about = "show the denoised image; auto: if the estimator is mwis"},
    {.name = "reconstruct", .option = "reconstruct", .former = "denoise",
     .argument = "auto|off|on", PLACE(denoise), .type = LF_PARAM_WORD, .word_at = lf_denoise_name,
     .about = "former name of denoise"},
    {.option = "import-memory", .argument = "GIB", PLACE(import.memory), .low = 0.125,
     .high = 65536,
     .help = "memory limit for reading files, in GiB; below 0.1875 counts as 0.1875 "
             "(half of the RAM)"},
    {.option = "import-time", .argument = "SECONDS", PLACE(import.time), .type = LF_PARAM_WHOLE,
     .low = 1, .high = 86400, .initial = LF_IMPORT_SECONDS,
     .help = "time limit for reading all files of a scene"},
    {0},
};
/* clang-format on */

void lf_options_limit_import(const lf_options *options)
{
    lf_import_limit((uint64_t)(options->import.memory * 0x1p30),
                    options->import.time > 0 ? options->import.time : LF_IMPORT_SECONDS);
}

/* -------------------------------------------------------------------------------- resolution -- */

lf_film_settings lf_exposed_film(const lf_film_settings *film, double exposure)
{
    lf_film_settings exposed = *film;
    if (isinf(exposure) && exposure < 0)
        return exposed;
    exposed.auto_exposure = isinf(exposure);
    exposed.exposure = exposed.auto_exposure ? 0 : exposure;
    return exposed;
}

lf_status lf_options_check_integrator(const lf_options *options, lf_error *err)
{
    const lf_integrator_entry *entry = lf_integrator_named(options->integrator);
    const lf_param *unfit = entry ? lf_choices_unfit(&options->choices, entry) : NULL;
    char where[64];
    if (!unfit)
        return LF_OK; /* other code reports a missing entry */
    snprintf(where, sizeof where, "--%s", unfit->option);
    return lf_error_set(
        err, LF_E_ARG, where,
        "is not supported by the integrator %s; remove it or choose another --integrator",
        entry->name);
}

const lf_preset *lf_options_preset(const lf_options *options)
{
    const lf_preset *preset = NULL;
    if (!options->preset || lf_preset_find(options->preset, &preset, NULL) != LF_OK)
        return NULL;
    return preset;
}

/* The panel's default quilt, if it has one and no other is given. */
static bool panel_quilt(const lf_options *options, const lf_calibration *calibration,
                        lf_layout *out)
{
    const int tiles = options->columns * options->rows;
    if (options->preset || !calibration || calibration->quilt_columns == 0 ||
        (tiles > 0 && tiles < calibration->quilt_columns * calibration->quilt_rows))
        return false;
    *out =
        (lf_layout){.columns = calibration->quilt_columns,
                    .rows = calibration->quilt_rows,
                    .n_views = calibration->quilt_columns * calibration->quilt_rows,
                    .view_width = calibration->quilt_width / calibration->quilt_columns,
                    .view_height = calibration->quilt_height / calibration->quilt_rows,
                    .aspect = (double)calibration->screen_width_px / calibration->screen_height_px};
    return true;
}

bool lf_options_preset_differs(const lf_options *options, const lf_calibration *calibration,
                               char *words, size_t size)
{
    const lf_preset *preset = lf_options_preset(options);
    if (!preset || !calibration || calibration->quilt_columns == 0 ||
        (preset->layout.columns == calibration->quilt_columns &&
         preset->layout.rows == calibration->quilt_rows))
        return false;
    (void)snprintf(words, size,
                   "the preset %s has %dx%d tiles, but the calibration has %dx%d tiles in %dx%d "
                   "pixels; omit --preset to use those",
                   preset->name, preset->layout.columns, preset->layout.rows,
                   calibration->quilt_columns, calibration->quilt_rows, calibration->quilt_width,
                   calibration->quilt_height);
    return true;
}

/* The preset's quilt, otherwise the panel's; false: neither. */
static bool quilt_of(const lf_options *options, const lf_calibration *calibration, lf_layout *out)
{
    const lf_preset *preset = lf_options_preset(options);
    if (!preset)
        return panel_quilt(options, calibration, out);
    *out = preset->layout;
    return true;
}

static void resolve_camera(const lf_options *options, const lf_camera *camera,
                           const lf_calibration *calibration, lf_camera *out)
{
    lf_layout quilt;
    const bool has_quilt = quilt_of(options, calibration, &quilt);
    *out = *camera;
    if (options->view_width > 0 && !camera->has_aspect)
        out->aspect = (double)options->view_width / options->view_height;
    if (!camera->has_views)
        out->n_views = DEFAULT_VIEWS;
    if ((calibration || has_quilt) && out->track > 0.0) {
        out->track = 0.0;
        out->n_rows = 0;
        out->n_views = DEFAULT_VIEWS;
    }
    if (calibration) {
        out->aspect = (double)calibration->screen_width_px / calibration->screen_height_px;
        if (calibration->view_cone_deg > 0)
            out->cone = calibration->view_cone_deg * (M_PI / 180.0);
    }
    if (has_quilt) {
        out->aspect = quilt.aspect;
        out->n_views = quilt.n_views;
    }
    if (options->views > 0)
        out->n_views = options->views;
    lf_camera_deepen(out);
}

static void resolve_view_size(const lf_options *options, const lf_calibration *calibration,
                              double aspect, lf_layout *layout)
{
    lf_layout quilt;
    const int height = options->file.still ? STILL_HEIGHT : DEFAULT_VIEW_HEIGHT;
    double width = round(aspect * height);
    layout->view_width = (int)fmax(1.0, fmin(width, LF_MAX_VIEW_SIDE));
    layout->view_height = height;
    if (quilt_of(options, calibration, &quilt)) {
        layout->view_width = quilt.view_width;
        layout->view_height = quilt.view_height;
    }
    if (options->view_width > 0) {
        layout->view_width = options->view_width;
        layout->view_height = options->view_height;
    }
}

static lf_status resolve_tiles(const lf_options *options, const lf_calibration *calibration,
                               const lf_camera *camera, lf_layout *layout, lf_error *err)
{
    lf_layout quilt;
    const bool has_quilt = quilt_of(options, calibration, &quilt);
    if (options->columns > 0) {
        if (options->columns * options->rows < layout->n_views)
            return lf_error_set(
                err, LF_E_ARG, "--quilt",
                "%dx%d has %d tiles, but there are %d views; use a larger --quilt or set --views",
                options->columns, options->rows, options->columns * options->rows, layout->n_views);
        layout->columns = options->columns;
        layout->rows = options->rows;
    } else if (has_quilt && quilt.n_views == layout->n_views) {
        layout->columns = quilt.columns;
        layout->rows = quilt.rows;
    } else if (camera->n_rows > 0 && !camera->has_parts && camera->n_views <= LF_MAX_TILES &&
               camera->n_rows <= LF_MAX_TILES) {
        layout->columns = camera->n_views;
        layout->rows = camera->n_rows;
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
    lf_camera rig = *camera;
    rig.n_rows = 0;
    if (camera->list)
        return lf_error_set(err, LF_E_ARG, "camera.views",
                            "quiltd, panels, prints and --rgbd need an arc, a track or a grid of "
                            "cameras; use quiltrender for other outputs");
    return lf_resolve_rows(options, &rig, calibration, out_settings, out_layout, err);
}

/* Refuses options that need a rig, for cameras listed one by one. */
static lf_status check_list(const lf_options *options, lf_error *err)
{
    const struct {
        bool given;
        const char *option;
    } refused[] = {{options->preset, "--preset"},
                   {options->views > 0, "--views"},
                   {options->denoise == LF_DENOISE_ON, "--denoise on"},
                   {options->target_denoised_error > 0, "--target-denoised-error"},
                   {options->layers, "--aov"},
                   {options->guides, "--guides"}};
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
        if (refused[i].given)
            return lf_error_set(err, LF_E_ARG, refused[i].option,
                                "is not supported with a list, path or circle of cameras");
    return LF_OK;
}

/* lf_render_settings.light_paths. */
static int light_paths_of(const lf_options *options)
{
    if (!options->tracing.has_light_paths)
        return options->tracing.offline ? LF_LIGHT_PATHS_AUTO : 0;
    if (isinf(options->tracing.light_paths))
        return options->tracing.light_paths > 0.0 ? LF_LIGHT_PATHS_AUTO : 0;
    return (int)lround(options->tracing.light_paths);
}

/* lf_render_settings.suffixes. */
static int suffixes_of(const lf_options *options)
{
    const int word = options->tracing.suffixes;
    if (word == 0)
        return options->tracing.offline ? LF_SUFFIXES_AUTO : 0;
    return word > 1 ? 1 << (word - 1) : 0;
}

int lf_suffixes_word(int n)
{
    for (int word = 2; word < (int)(sizeof suffixes / sizeof *suffixes); word++)
        if (n == 1 << (word - 1))
            return word;
    return n == LF_SUFFIXES_AUTO ? 0 : 1;
}

lf_status lf_resolve_rows(const lf_options *options, const lf_camera *camera,
                          const lf_calibration *calibration, lf_render_settings *out_settings,
                          lf_layout *out_layout, lf_error *err)
{
    lf_render_settings settings = {
        .integrator = options->integrator,
        .sampler = options->sampler,
        .choices = options->choices,
        .seed = options->seed,
        .max_depth = options->max_depth,
        .light_paths = light_paths_of(options),
        .suffixes = suffixes_of(options),
        .one_light = suffixes_of(options) > 1,
        .skip = options->tracing.has_skip ? options->tracing.skip : LF_SKIP_ALL,
        .features = options->denoise == LF_DENOISE_ON || options->layers & LF_LAYER_DEPTH ||
                    options->guides,
    };
    lf_layout layout = {0};
    resolve_camera(options, camera, calibration, &settings.camera);
    if (settings.camera.n_rows > 0 && options->views > 0)
        return lf_error_set(
            err, LF_E_ARG, "--views",
            "cannot change the number of views; the scene has a %s of %d x %d cameras",
            camera->has_parts ? "track" : "grid", camera->n_views, camera->n_rows);
    if (camera->list && check_list(options, err) != LF_OK)
        return LF_E_ARG;
    layout.n_views = lf_camera_views(&settings.camera);
    layout.aspect = settings.camera.aspect;
    resolve_view_size(options, calibration, layout.aspect, &layout);
    lf_status status = resolve_tiles(options, calibration, &settings.camera, &layout, err);
    if (status != LF_OK)
        return status;
    settings.width = layout.view_width;
    settings.height = layout.view_height;
    *out_settings = settings;
    *out_layout = layout;
    return LF_OK;
}
