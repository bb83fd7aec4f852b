/* quiltrender: one scene or quilt to one picture, print or folder of views. See
 * docs/man/quiltrender.1. */
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/import/import.h"
#include "base/log.h"
#include "daemon/output/content.h"
#include "daemon/tools/render_arguments.h"

#define PROGRAM LF_RENDER_PROGRAM

/* ---------------------------------------------------------------------------------- progress -- */

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
        snprintf(left, sizeof left, ", about %.0f s left",
                 progress->seconds * (1 / progress->fraction - 1));
    snprintf(text, sizeof text, "rendering %3.0f %%, %.2f samples a view pixel, %.0f s%s",
             100 * progress->fraction, progress->passes / progress->n_views, progress->seconds,
             left);
    draw(context, text);
}

/* Of files that are read at once, whichever has been for longest says so first. */
static void show_reading(void *context, const lf_import_progress *progress)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    progress_line *line = context;
    char text[160];
    const char *slash = strrchr(progress->path, '/');
    if (!line->on || progress->ended || progress->seconds < 0.5)
        return;
    snprintf(text, sizeof text, "reading %.60s (%.1f MB), %.0f s",
             slash ? slash + 1 : progress->path, 1e-6 * (double)progress->bytes, progress->seconds);
    pthread_mutex_lock(&lock);
    draw(line, text);
    pthread_mutex_unlock(&lock);
}

static void show_writing(void *context, double fraction)
{
    char text[64];
    snprintf(text, sizeof text, "writing %3.0f %%", 100 * fraction);
    draw(context, text);
}

/* One job, half-built at any time. */
typedef struct job {
    const lf_render_arguments *arguments;
    progress_line line;
    lf_calibration calibration;
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_render_settings settings;
    lf_layout layout;
    lf_quilt_file quilt;
    bool is_quilt;
    float *film;   /* [row][view][column][3] */
    float *layers; /* [row][view][column][channels], NULL: none are wanted */
    lf_film_settings film_settings;
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
    lf_import_stop();
}

/* --------------------------------------------------------------------------------------- job -- */

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
        status = lf_error_set(err, LF_E_IO, path, "cannot write into the folder %s: %s", folder,
                              strerror(errno));
    lf_free(folder);
    lf_free(copy);
    return status;
}

static lf_status prepare_print(job *j, int n_views_most, lf_error *err)
{
    const char *warning = NULL;
    j->print = j->arguments->print;
    j->print.n_views = j->arguments->options.views;
    lf_status status = lf_print_choose_views(&j->print, n_views_most, "--views", NULL, err);
    if (status == LF_OK)
        status = j->arguments->kind->check_print(&j->print, &warning, err);
    if (status == LF_OK && warning)
        lf_log(LF_LOG_WARNING, "--views: %s", warning);
    return status;
}

/* How a finished light field is laid out anew: a folder has neither tiles nor an aspect but what
 * the options and the names say. */
static void lay_out_quilt(job *j)
{
    const lf_render_arguments *a = j->arguments;
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
    const lf_render_arguments *a = j->arguments;
    const lf_options *o = &a->options;
    if (o->preset || o->view_width > 0)
        return lf_error_set(
            err, LF_E_ARG, o->preset ? "--preset" : "--view-size",
            "does not go with a finished quilt (its name or --quilt says the layout)");
    if (a->kind->layers)
        return lf_error_set(err, LF_E_ARG, a->scene, "has no depth: --rgbd renders a scene");
    if (a->render_option) {
        char where[64];
        snprintf(where, sizeof where, "--%s", a->render_option);
        return lf_error_set(err, LF_E_ARG, where,
                            "does not go with a finished quilt: nothing is rendered");
    }
    lf_status status = lf_quilt_read(a->scene, NULL, o->columns, o->rows, &j->quilt, err);
    if (status != LF_OK)
        return status;
    j->is_quilt = true;
    if (a->kind->check_print)
        status = prepare_print(j, j->quilt.layout.n_views, err);
    else if (o->views > j->quilt.layout.n_views)
        status = lf_error_set(err, LF_E_ARG, "--views", "%d views asked for, but the quilt has %d",
                              o->views, j->quilt.layout.n_views);
    else if (o->views > 0)
        j->quilt.layout.n_views = j->quilt.views8.n_views = j->quilt.views32.n_views = o->views;
    if (status == LF_OK && o->has_exposure && !j->quilt.is_float)
        status = lf_error_set(err, LF_E_ARG, "--exposure",
                              "does not go with a finished picture of 8 bits (EXR has light)");
    if (status == LF_OK)
        lay_out_quilt(j);
    return status;
}

static lf_status open_scene(job *j, lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
    const lf_calibration *calibration = a->kind->needs_panel ? &j->calibration : NULL;
    if (a->kind->check_print &&
        (a->options.preset || a->options.columns > 0 || a->options.view_width > 0))
        return lf_error_set(err, LF_E_ARG, "--print",
                            "says what to render: no --preset, --quilt or --view-size");
    lf_status status = lf_scene_load(a->scene, NULL, NULL, &j->scene, err);
    clear_line(&j->line);
    if (status == LF_OK)
        lf_log_warnings(j->scene, NULL);
    if (status == LF_OK)
        status = lf_resolve_view(&a->options, lf_scene_camera(j->scene), calibration, &j->settings,
                                 &j->layout, err);
    if (status == LF_OK && a->kind->check_print) {
        status = prepare_print(j, LF_MAX_VIEWS, err);
        if (status == LF_OK)
            lf_output_print_view(&j->print, &j->settings);
        j->print.rolled = j->print.horizontal;
    }
    return status;
}

/* Files that are written beside and renamed would take the place of what they were made from.
 * Either may be NULL. */
static lf_status check_not_input(const char *path, const char *input, lf_error *err)
{
    struct stat out, in;
    if (path && input && stat(path, &out) == 0 && stat(input, &in) == 0 &&
        out.st_dev == in.st_dev && out.st_ino == in.st_ino)
        return lf_error_set(err, LF_E_ARG, path, "is what is being rendered: choose another name");
    return LF_OK;
}

/* The manifest of a print takes the place of another manifest, and of nothing else. */
static lf_status check_manifest(const lf_output_kind *kind, const char *print, const char *input,
                                lf_error *err)
{
    char *path = lf_output_file_name(kind, print, 1);
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, print, "out of memory");
    lf_status status = check_not_input(path, input, err);
    if (status == LF_OK && access(path, F_OK) == 0) {
        json_t *there = json_load_file(path, 0, NULL);
        if (!json_object_get(there, "quiltd_print"))
            status = lf_error_set(
                err, LF_E_ARG, path,
                "is there already and is no manifest of a print: choose another name for the TIFF");
        json_decref(there);
    }
    lf_free(path);
    return status;
}

static lf_status check_outputs(const job *j, lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
    lf_status status = check_not_input(j->path, a->scene, err);
    if (status == LF_OK && a->stats)
        status = check_not_input(a->stats, a->scene, err);
    if (status == LF_OK && a->kind->check_print)
        status = check_manifest(a->kind, j->path, a->scene, err);
    return status;
}

static lf_status open_input(job *j, lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
    lf_status status = check_folder_of(a->out, err);
    if (status == LF_OK && a->stats)
        status = check_folder_of(a->stats, err);
    if (status == LF_OK && a->kind->needs_panel)
        status = lf_calibration_load(a->options.calibration, &j->calibration, err);
    if (a->kind->is_drawn)
        j->print = a->print;
    else if (status == LF_OK)
        status = lf_is_quilt(a->scene, NULL) ? open_quilt(j, err) : open_scene(j, err);
    if (status == LF_OK)
        status = lf_output_path(a->kind, a->out, &j->layout, &j->path, err);
    if (status == LF_OK)
        status = check_outputs(j, err);
    if (status == LF_OK && lf_pool_create(a->options.threads, &j->pool) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "--threads", "cannot start the worker threads");
    return status;
}

/* A depth that is too much for the rig, in plain words. */
static void warn_of_depth(const job *j)
{
    lf_depth depth;
    char words[LF_DEPTH_WORDS];
    if (lf_scene_depth(j->scene, &j->settings, &depth) && depth.exceeded)
        lf_log(LF_LOG_WARNING, "%s: %s", j->arguments->scene,
               lf_depth_words(&depth, j->settings.width, words, sizeof words));
}

static lf_status render(job *j, lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
    lf_budget budget = a->budget;
    budget.reconstructed = a->options.reconstruct == LF_RECONSTRUCT_ON;
    size_t views = (size_t)j->settings.camera.n_views;
    lf_status status = lf_renderer_create(j->scene, &j->settings, j->pool, &j->renderer, err);
    if (status != LF_OK)
        return status;
    warn_of_depth(j);
    if (a->spp > 0)
        budget.passes = a->spp * j->settings.camera.n_views;
    j->film = lf_calloc((size_t)j->settings.height * views,
                        (size_t)j->settings.width * 3 * sizeof(float));
    if (!j->film)
        return lf_error_set(err, LF_E_NOMEM, a->out, "no memory for %zu views of %dx%d pixels",
                            views, j->settings.width, j->settings.height);
    status = lf_render_run(j->renderer, &budget, a->options.estimator, j->film, show_rendering,
                           &j->line, &cancel, &j->times);
    if (status == LF_E_CANCELLED)
        return lf_error_set(err, status, a->out, "interrupted: nothing was written");
    return status == LF_OK ? LF_OK : lf_error_set(err, status, a->out, "rendering failed");
}

/* What goes beside the colours, out of the renderer. */
static lf_status make_layers(job *j, unsigned layers, lf_layers32 *out,
                             const char *names[LF_MAX_LAYER_CHANNELS], lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
    size_t n = (size_t)lf_layer_channels(layers, names), width = (size_t)j->settings.width * n,
           row = width * (size_t)j->settings.camera.n_views;
    j->layers = lf_calloc((size_t)j->settings.height, row * sizeof *j->layers);
    if (!j->layers)
        return lf_error_set(err, LF_E_NOMEM, a->out, "no memory for %zu layers", n);
    *out = (lf_layers32){(int)n, names, width, row, j->layers};
    lf_status status =
        lf_renderer_layers(j->renderer, a->options.estimator, layers, j->layers, &cancel);
    if (status == LF_E_CANCELLED)
        return lf_error_set(err, status, a->out, "interrupted: nothing was written");
    return status == LF_OK ? LF_OK : lf_error_set(err, status, a->out, "no layers were made");
}

static json_t *make_record(const job *j)
{
    const lf_render_arguments *a = j->arguments;
    if (!a->scene)
        return json_object();
    if (j->is_quilt)
        return json_pack("{s:s, s:i, s:f}", "scene", a->scene, "views", j->layout.n_views, "aspect",
                         j->layout.aspect);
    return lf_output_settings(a->scene, &j->settings, a->kind->has_tiles ? &j->layout : NULL,
                              a->options.estimator, a->options.reconstruct == LF_RECONSTRUCT_ON,
                              (double)j->times.passes, &j->film_settings);
}

/* How bright the picture is shown; of what is drawn, not at all. */
static lf_status expose(job *j, const lf_output_source *source, lf_error *err)
{
    static const lf_film_settings plain = {.tonemap = "srgb"};
    const lf_options *o = &j->arguments->options;
    j->film_settings = j->scene ? *lf_scene_film_settings(j->scene) : plain;
    if (o->has_exposure)
        j->film_settings = lf_exposed_film(&j->film_settings, o->exposure);
    if (!j->film_settings.auto_exposure)
        return LF_OK;
    lf_meter *meter = lf_calloc(1, sizeof *meter);
    if (!meter)
        return lf_error_set(err, LF_E_NOMEM, j->path, "out of memory");
    lf_meter_add_views(meter, &source->views32);
    j->film_settings.exposure = lf_meter_exposure(meter);
    lf_free(meter);
    lf_log(LF_LOG_INFO, "exposure: %+.3f stops", j->film_settings.exposure);
    return LF_OK;
}

static lf_status write_output(job *j, lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
    lf_output_source source =
        j->is_quilt ? lf_output_from_quilt(&j->quilt) : lf_output_from_film(&j->settings, j->film);
    const char *names[LF_MAX_LAYER_CHANNELS];
    lf_layers32 layers;
    if (j->is_quilt)
        source.aspect = j->layout.aspect;
    lf_status status = expose(j, &source, err);
    if (status == LF_OK && a->options.layers) {
        status = make_layers(j, a->options.layers, &layers, names, err);
        source.views32.layers = &layers;
    }
    if (status != LF_OK)
        return status;
    j->record = make_record(j);
    if (!j->record)
        return lf_error_set(err, LF_E_NOMEM, a->out, "out of memory");
    const lf_output_request request = {
        .kind = a->kind,
        .path = j->path,
        .overwrite = true,
        .layout = j->layout,
        .calibration = &j->calibration,
        .panel = a->panel,
        .print = &j->print,
        .rgbd = a->rgbd,
        .exposure = j->film_settings.exposure,
        .tonemap = j->film_settings.tonemap,
        .settings = j->record,
        .pool = j->pool,
        .cancel = &cancel,
        .progress = show_writing,
        .context = &j->line,
    };
    status = lf_output_write(&request, &source, err);
    if (status == LF_E_CANCELLED)
        return lf_error_set(err, status, a->out, "interrupted: nothing was written");
    return status;
}

static lf_status write_stats(const job *j, lf_error *err)
{
    const lf_render_arguments *a = j->arguments;
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
    lf_free(j->layers);
    lf_free(j->path);
}

static int run(const lf_render_arguments *a)
{
    job j = {.arguments = a, .line = {.on = isatty(STDERR_FILENO) == 1}};
    lf_error err = {0};
    lf_import_watch(show_reading, &j.line);
    lf_status status = open_input(&j, &err);
    lf_import_watch(NULL, NULL);
    int code = LF_EXIT_OK;
    if (status == LF_E_ARG) {
        code = lf_usage_error(PROGRAM, &err);
        job_finish(&j);
        return code;
    }
    if (status == LF_OK && j.scene)
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
    lf_render_arguments a;
    lf_error err = {0};
    bool done = false;
    lf_log_init(PROGRAM, LF_LOG_INFO);
    if (lf_render_arguments_parse(argc, argv, &a, &done, &err) != LF_OK)
        return lf_usage_error(PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_options_limit_import(&a.options);
    catch_signals();
    return run(&a);
}
