#include "daemon/tools/rendering.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/blank.h"
#include "daemon/output/content.h"
#include "daemon/output/guides.h"
#include "daemon/tools/rendering_plate.h"

#define WITNESS_ROWS 32 /* of a print, to compare with the file */

int lf_rendering_camera_rows(const lf_rendering *r)
{
    return r->settings.camera.n_rows > 0 ? r->settings.camera.n_rows : 1;
}

/* ---------------------------------------------------------------------------------- progress -- */

static void seconds_left(double seconds, double fraction, char *out, size_t size)
{
    out[0] = '\0';
    if (fraction > 0.01)
        snprintf(out, size, ", about %.0f s left", seconds * (1 / fraction - 1));
}

void lf_rendering_show_frame(lf_rendering *r, double fraction)
{
    const lf_sequence_state *s = &r->sequence;
    char text[160], left[64];
    double whole = (s->n_done + fraction) / s->n_wanted;
    seconds_left(lf_time_now() - s->begun, whole, left, sizeof left);
    snprintf(text, sizeof text, "%s %d (%d of %d), %3.0f %%%s",
             r->arguments->frames.of_rows ? "row" : "frame", s->frame, s->n_done + 1, s->n_wanted,
             100 * whole, left);
    lf_progress_line_draw(&r->line, text);
}

void lf_rendering_show(void *context, const lf_render_progress *progress)
{
    lf_rendering *r = context;
    char text[160], left[64];
    const double fraction = (r->camera_row + progress->fraction) / lf_rendering_camera_rows(r),
                 seconds = r->times.seconds + progress->seconds;
    lf_rendering_state_look(r, progress);
    if (r->sequence.on) {
        lf_rendering_show_frame(r, fraction);
        return;
    }
    seconds_left(seconds, fraction, left, sizeof left);
    snprintf(text, sizeof text, "rendering %3.0f %%, %.2f samples per view pixel, %.0f s%s",
             100 * fraction, progress->passes / progress->n_views, seconds, left);
    lf_progress_line_draw(&r->line, text);
}

static void show_writing(void *context, double fraction)
{
    lf_rendering *r = context;
    char text[64];
    if (r->sequence.on) {
        lf_rendering_show_frame(r, 1);
        return;
    }
    snprintf(text, sizeof text, "writing %3.0f %%", 100 * fraction);
    lf_progress_line_draw(&r->line, text);
}

lf_status lf_rendering_interrupted(const lf_rendering *r, lf_error *err)
{
    const char *out = r->arguments->out;
    const bool goes_on = r->arguments->state.file;
    if (r->sequence.on && !r->video)
        return lf_error_set(err, LF_E_CANCELLED, out, "interrupted: %d of %d %s were written%s",
                            r->sequence.n_done, r->sequence.n_wanted,
                            lf_frames_noun(&r->arguments->frames),
                            goes_on ? "; run the same command to continue" : "");
    if (r->state.is_kept)
        return lf_error_set(
            err, LF_E_CANCELLED, out,
            "interrupted: the work is saved in %s; run the same command to continue",
            r->state.path);
    return lf_error_set(err, LF_E_CANCELLED, out, "interrupted: nothing was written%s",
                        goes_on                       ? "; run the same command again"
                        : !r->scene || r->sequence.on ? ""
                                                      : "; use --state FILE to keep the work");
}

/* --------------------------------------------------------------------------------- rendering -- */

/* Warns of a depth that exceeds the limit, and of guides without a limit. */
static void warn_of_depth(const lf_rendering *r)
{
    if (r->sequence.plate)
        return; /* it has its own limit */
    const lf_depth_place place = r->arguments->kind->check_print ? LF_DEPTH_PRINT : LF_DEPTH_FILE;
    const lf_render_settings settings = lf_rendering_in_lenses(r);
    lf_depth depth;
    char words[LF_DEPTH_WORDS];
    if (!lf_scene_depth(r->scene, &settings, &depth)) {
        if (r->arguments->options.guides)
            lf_log(LF_LOG_WARNING, "--guides: marks nothing; it needs objects in front of at least "
                                   "two views with the same window");
        return;
    }
    if (lf_depth_exceeds(&depth, &settings.camera, place))
        lf_log(LF_LOG_WARNING, "%s: %s", r->arguments->scene,
               lf_depth_words(&depth, settings.width, place, words, sizeof words));
}

/* Measures a scene's depth for the manifest of a print. */
static void measure_depth(lf_rendering *r)
{
    const lf_render_settings settings = lf_rendering_in_lenses(r);
    lf_depth depth;
    if (!r->scene)
        return;
    r->print.parallax_lenses = 0;
    if (r->arguments->kind->check_print && lf_scene_depth(r->scene, &settings, &depth) &&
        (lf_depth_shift(&depth) <= 1 || lf_depth_exceeds(&depth, &settings.camera, LF_DEPTH_PRINT)))
        r->print.parallax_lenses = fmin(lf_depth_shift(&depth), settings.width);
}

/* Warns once if the camera sees no object of the scene. */
static void warn_of_unseen(lf_rendering *r)
{
    if (r->told_of_blank || lf_scene_is_seen(r->scene, &r->settings))
        return;
    r->told_of_blank = true;
    lf_log(LF_LOG_WARNING, "%s: %s", r->arguments->scene, lf_unseen_words(false));
}

/* Warns once of a blank picture. */
static void warn_of_blank(lf_rendering *r, const lf_output_source *source)
{
    const char *words =
        r->told_of_blank || !r->scene
            ? NULL
            : lf_blank_words(lf_blank_of_views32(&source->views32, &r->film_settings), false);
    if (!words)
        return;
    r->told_of_blank = true;
    lf_log(LF_LOG_WARNING, "%s: %s", r->arguments->scene, words);
}

/* Creates the renderer of r->scene; the renderer of the previous frame or row is reused. */
static lf_status begin(lf_rendering *r, const lf_render_settings *settings, lf_error *err)
{
    warn_of_unseen(r);
    if (r->gathered) {
        if (r->sequence.n_done == 0)
            warn_of_depth(r);
        return LF_OK;
    }
    if (r->renderer)
        return lf_renderer_restart(r->renderer, r->scene, settings, err);
    lf_status status = lf_renderer_create(r->scene, settings, r->pool, &r->renderer, err);
    if (status == LF_OK)
        warn_of_depth(r);
    return status;
}

/* The layers requested in addition to the colours. */
static unsigned layers_of(const lf_rendering *r)
{
    return r->arguments->options.guides ? LF_GUIDE_LAYERS : r->arguments->options.layers;
}

/* Allocates a picture of this many views and channels, unless *picture exists. */
static lf_status make_room(const lf_rendering *r, int views, int channels, float **picture,
                           lf_error *err)
{
    if (!*picture && channels > 0)
        *picture = lf_pages((size_t)r->settings.height * (size_t)views,
                            (size_t)r->settings.width * (size_t)channels * sizeof **picture);
    if (*picture || channels == 0)
        return LF_OK;
    return lf_error_set(err, LF_E_NOMEM, r->arguments->out,
                        "out of memory for %d views of %dx%d pixels with %d channels", views,
                        r->settings.width, r->settings.height, channels);
}

/* Copies the views of the current camera row to their place among all views. */
static void place_row(const lf_rendering *r, int channels, const float *from, float *all)
{
    const size_t row = (size_t)r->settings.camera.n_views * (size_t)r->settings.width *
                       (size_t)channels,
                 rows = (size_t)lf_rendering_camera_rows(r), mine = (size_t)r->camera_row;
    assert(from);
    for (size_t y = 0; y < (size_t)r->settings.height; y++)
        memcpy(all + (y * rows + mine) * row, from + y * row, row * sizeof *all);
}

/* Renders colours and requested layers of the current camera row. */
static lf_status render_row(lf_rendering *r, const lf_budget *budget, float *film, float *layers)
{
    const lf_estimator estimator = r->arguments->options.estimator;
    lf_render_times times = {0};
    lf_status status = LF_OK;
    if (r->gathered)
        times = *r->gathered;
    else if (r->arguments->state.file)
        times = r->state.times;
    else
        status = lf_render_spend(r->renderer, budget, estimator, film, lf_rendering_show, r,
                                 r->cancel, &times);
    if (status == LF_OK)
        status = lf_render_answer(r->renderer, budget, estimator, film, r->cancel, &times);
    if (status == LF_OK)
        status = budget->reconstructed ? lf_renderer_catch_smoothly(r->renderer, film, r->cancel)
                                       : lf_renderer_catch(r->renderer, film, r->cancel);
    if (status == LF_OK && layers)
        status = lf_renderer_layers(r->renderer, estimator, layers_of(r), layers, r->cancel);
    if (status == LF_OK && !r->told_of_cut) {
        lf_render_stats stats;
        lf_renderer_stats(r->renderer, &stats);
        r->told_of_cut = lf_render_warn_of_cut(&stats, r->arguments->scene);
    }
    r->times.passes += times.passes;
    r->times.seconds += times.seconds;
    r->times.cpu_seconds += times.cpu_seconds;
    r->times.answer_cpu_seconds += times.answer_cpu_seconds;
    return status;
}

/* Spends the budget of the current camera row and keeps its state. */
static lf_status save_row(lf_rendering *r, const lf_budget *budget, float *film, lf_error *err)
{
    const lf_saved_field field = {r->renderer, -1, -1, lf_rendering_show, r};
    lf_status status = lf_rendering_state_spend(r, &field, budget, film, err);
    if (status != LF_OK || !lf_state_is_all(&r->arguments->state))
        return status;
    r->times.passes += r->state.times.passes;
    r->times.seconds += r->state.times.seconds;
    r->times.cpu_seconds += r->state.times.cpu_seconds;
    return LF_OK;
}

lf_render_settings lf_rendering_row_settings(const lf_rendering *r)
{
    lf_render_settings settings = r->settings;
    settings.camera = lf_camera_row(&r->settings.camera, r->camera_row);
    settings.seed = lf_rows_seed(r->settings.seed, r->camera_row);
    return settings;
}

/* Every row of a grid is a rig with a seed of its own. row_film, row_layers: buffers for one row;
 * NULL: only states are made. */
static lf_status run_rows(lf_rendering *r, const lf_budget *budget, float *row_film,
                          float *row_layers, lf_error *err)
{
    const char *out = r->arguments->out;
    const int channels = lf_layer_channels(layers_of(r), NULL);
    lf_status status = LF_OK;
    for (r->camera_row = 0; status == LF_OK && r->camera_row < lf_rendering_camera_rows(r);
         r->camera_row++) {
        const lf_render_settings settings = lf_rendering_row_settings(r);
        status = begin(r, &settings, err);
        if (status == LF_OK && r->arguments->state.file && !r->gathered)
            status = save_row(r, budget, row_film, err);
        if (status != LF_OK)
            return status;
        if (lf_state_is_all(&r->arguments->state))
            continue;
        status = render_row(r, budget, row_film, row_layers);
        if (row_film != r->film)
            place_row(r, 3, row_film, r->film);
        if (row_layers && row_layers != r->layers)
            place_row(r, channels, row_layers, r->layers);
    }
    if (status == LF_E_CANCELLED)
        return lf_rendering_interrupted(r, err);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, out, "rendering failed");
}

lf_budget lf_rendering_budget(const lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    lf_budget budget = a->budget;
    budget.reconstructed = r->reconstructs;
    budget.seconds /= lf_rendering_camera_rows(r);
    budget.cpu_seconds /= lf_rendering_camera_rows(r);
    if (a->n_budgets == 0 || a->spp > 0)
        budget.passes = (a->spp > 0 ? a->spp : LF_RENDER_DEFAULT_SPP) * r->settings.camera.n_views;
    if (a->n_budgets == 0 && r->reconstructs && budget.passes > LF_RENDER_DEFAULT_PASSES)
        budget.passes = LF_RENDER_DEFAULT_PASSES;
    return budget;
}

lf_status lf_rendering_run(lf_rendering *r, lf_error *err)
{
    const lf_budget budget = lf_rendering_budget(r);
    const lf_camera *camera = &r->settings.camera;
    const bool is_grid = camera->n_rows > 0;
    const int channels = lf_layer_channels(layers_of(r), NULL);
    float *film = NULL, *layers = NULL; /* of one row of a grid */
    r->times = (lf_render_times){0};
    if (lf_state_is_all(&r->arguments->state))
        return run_rows(r, &budget, NULL, NULL, err);
    lf_status status = make_room(r, lf_camera_views(camera), 3, &r->film, err);
    if (status == LF_OK)
        status = make_room(r, lf_camera_views(camera), channels, &r->layers, err);
    if (status == LF_OK && is_grid)
        status = make_room(r, camera->n_views, 3, &film, err);
    if (status == LF_OK && is_grid)
        status = make_room(r, camera->n_views, channels, &layers, err);
    if (status == LF_OK)
        status = run_rows(r, &budget, is_grid ? film : r->film, is_grid ? layers : r->layers, err);
    lf_pages_free(film);
    lf_pages_free(layers);
    if (status == LF_OK && !r->gathered && !r->sequence.on && !r->arguments->stats)
        lf_renderer_release(r->renderer); /* writing takes memory, too */
    return status;
}

/* Tints what the panel cannot show sharply. */
static void mark_depth(lf_rendering *r)
{
    lf_depth depth;
    if (!lf_scene_depth(r->scene, &r->settings, &depth))
        return;
    lf_log(LF_LOG_INFO,
           "guides: the panel shows distances from %.4g to %.4g along the view axis sharply",
           depth.sharp_from, depth.sharp_to);
    lf_guides_mark(&depth, r->film_settings.exposure, r->layers,
                   (size_t)r->settings.height * (size_t)lf_camera_views(&r->settings.camera) *
                       (size_t)r->settings.width,
                   r->film);
}

/* The settings of a finished picture: what it is, how it stands, and how deep it was drawn. */
static json_t *record_picture(const lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    const lf_standing *standing = &a->options.standing;
    static const char *const of_depth[] = {"rgbd_in", "depth_inversion", "chroma_depth",
                                           "depthiness", "depth_cutoff"};
    json_t *made = json_pack("{s:s, s:i, s:f}", "scene", lf_rendering_input(r), "views",
                             r->layout.n_views, "aspect", r->layout.aspect);
    const bool has_depth = r->rgbd.side != LF_RGBD_IN_AUTO;
    if (!has_depth && lf_standing_is_plain(standing))
        return made;
    lf_standing drawn = *standing;
    drawn.rgbd_in = r->rgbd.side;
    json_t *how = lf_param_json(lf_standing_params, &drawn);
    if (has_depth) {
        json_object_set_new(how, "geometry", json_string(r->rgbd.is_known ? "known" : "unknown"));
        json_object_set_new(how, "disparity", json_real(r->rgbd.disparity));
        json_object_set_new(how, "plane", json_real(r->rgbd.plane));
    }
    for (size_t i = 0; !has_depth && i < sizeof of_depth / sizeof *of_depth; i++)
        json_object_del(how, of_depth[i]);
    if (json_object_update(made, how) != 0) {
        json_decref(made);
        made = NULL;
    }
    json_decref(how);
    return made;
}

static json_t *make_record(const lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    const double rate = lf_rendering_rate(r);
    json_t *made;
    if (!a->scene)
        return json_object();
    if (r->is_quilt)
        made = record_picture(r);
    else
        made = lf_output_settings(
            a->scene, &r->settings, lf_rendering_kind(r)->has_tiles ? &r->layout : NULL,
            a->options.estimator, r->reconstructs,
            (double)r->times.passes / lf_rendering_camera_rows(r), &r->film_settings);
    if (made && rate > 0) /* for a video of these frames */
        json_object_set_new(made, "fps", json_real(rate));
    if (made && !r->is_quilt)
        lf_rendering_note_made(r, made);
    return made;
}

/* Determines the exposure of the picture; nothing for drawn outputs. */
static lf_status expose(lf_rendering *r, const lf_output_source *source, lf_error *err)
{
    static const lf_film_settings plain = {.tonemap = "srgb"};
    const lf_options *o = &r->arguments->options;
    r->film_settings = r->scene ? *lf_scene_film_settings(r->scene) : plain;
    if (o->has_exposure)
        r->film_settings = lf_exposed_film(&r->film_settings, o->exposure);
    if (!r->film_settings.auto_exposure)
        return LF_OK;
    lf_meter *meter = lf_calloc(1, sizeof *meter);
    if (!meter)
        return lf_error_set(err, LF_E_NOMEM, r->path, "out of memory");
    lf_meter_add_views(meter, &source->views32);
    r->film_settings.exposure = lf_meter_exposure(meter);
    lf_free(meter);
    if (!r->sequence.on)
        lf_log(LF_LOG_INFO, "exposure: %+.3f stops", r->film_settings.exposure);
    return LF_OK;
}

/* The layers in the arrangement of the colours. */
static lf_layers32 layers_laid_out(const lf_rendering *r, const char *names[LF_MAX_LAYER_CHANNELS])
{
    const int n = lf_layer_channels(r->arguments->options.layers, names);
    const size_t view = (size_t)r->settings.width * (size_t)n;
    return (lf_layers32){n, names, view, view * (size_t)lf_camera_views(&r->settings.camera),
                         r->layers};
}

static lf_status write_track(const lf_rendering *r, const lf_output_request *request,
                             const lf_output_source *source, lf_error *err)
{
    lf_status status = lf_video_add_views(r->video, request, source, err);
    return status == LF_OK ? lf_video_finish(r->video, err) : status;
}

/* A frame of the video: a quilt, or the middle view of finished pictures. */
static lf_status add_frame(const lf_rendering *r, const lf_output_request *request,
                           const lf_output_source *source, lf_error *err)
{
    const bool is_one = r->is_quilt && request->layout.n_views == 1;
    return is_one ? lf_video_add_views(r->video, request, source, err)
                  : lf_video_add(r->video, request, source, err);
}

static bool wants_check(const lf_rendering *r)
{
    return lf_rendering_kind(r)->check_print &&
           lf_print_check_wanted(&r->arguments->of_print.check, r->path);
}

/* Checks the print as it lies on the disk. LF_E_FORMAT: a point fails. */
static lf_status check_print(lf_rendering *r, const lf_print_witness *witness, lf_error *err)
{
    bool failed = false;
    lf_progress_line_clear(&r->line);
    const lf_status status = lf_print_check_written(r->path, witness, &failed, err);
    if (status != LF_OK || !failed)
        return status;
    return lf_error_set(err, LF_E_FORMAT, r->path,
                        "was written, but its checklist has failures; read the .check.txt beside "
                        "it");
}

lf_status lf_rendering_write(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_output_source source = r->is_quilt ? lf_output_from_quilt(&r->quilt, lf_rendering_input(r))
                                          : lf_output_from_film(&r->settings, r->film);
    const char *names[LF_MAX_LAYER_CHANNELS];
    lf_layers32 layers;
    lf_print_witness witness = {.n_rows = wants_check(r) ? WITNESS_ROWS : 0};
    source.reconstructed = !r->is_quilt && r->reconstructs;
    if (a->frames.of_rows) /* dithers a row as among all rows */
        source.first_view = r->sequence.frame * lf_camera_views(&r->settings.camera);
    if (r->is_quilt)
        source.aspect = r->layout.aspect;
    lf_status status = expose(r, &source, err);
    if (status != LF_OK)
        return status;
    warn_of_blank(r, &source);
    if (a->options.guides) {
        mark_depth(r);
    } else if (a->options.layers) {
        layers = layers_laid_out(r, names);
        source.views32.layers = &layers;
    }
    measure_depth(r);
    json_decref(r->record);
    r->record = make_record(r);
    if (!r->record)
        return lf_error_set(err, LF_E_NOMEM, a->out, "out of memory");
    const lf_output_request request = {
        .kind = lf_rendering_kind(r),
        .path = r->path,
        .overwrite = true,
        .layout = r->layout,
        .calibration = &r->calibration,
        .panel = a->panel,
        .print = &r->print,
        .witness = &witness,
        .rgbd = a->rgbd,
        .exposure = r->film_settings.exposure,
        .quality = a->options.file.quality,
        .tonemap = r->film_settings.tonemap,
        .settings = r->record,
        .pool = r->pool,
        .cancel = r->cancel,
        .progress = show_writing,
        .context = r,
    };
    if (lf_rendering_is_track(r))
        status = write_track(r, &request, &source, err);
    else if (r->sequence.plate)
        status = lf_rendering_plate_write(r, &request, &source, err);
    else
        status = r->video ? add_frame(r, &request, &source, err)
                          : lf_output_write(&request, &source, err);
    if (status == LF_OK && wants_check(r))
        status = check_print(r, &witness, err);
    else if (status == LF_OK && lf_rendering_kind(r)->check_print)
        lf_print_check_forget(r->path);
    lf_print_witness_finish(&witness);
    if (status == LF_E_CANCELLED)
        return lf_rendering_interrupted(r, err);
    return status;
}

/* "-" is standard output. */
static lf_status put_stats(const char *path, const json_t *object, lf_error *err)
{
    char *text = object ? json_dumps(object, JSON_INDENT(2)) : NULL, *lines = NULL;
    lf_status status = LF_OK;
    if (!text || asprintf(&lines, "%s\n", text) < 0) {
        free(text);
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    if (strcmp(path, "-") != 0)
        status = lf_outfile_text(path, lines, err);
    else if (fputs(lines, stdout) < 0 || fflush(stdout) != 0)
        status = lf_error_set(err, LF_E_IO, "--stats", "cannot write to standard output");
    free(lines);
    free(text);
    return status;
}

lf_status lf_rendering_write_stats(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_views32 *v32 = &r->quilt.views32;
    const lf_views8 *v8 = &r->quilt.views8;
    const lf_render_report report = {
        .scene = a->scene,
        .renderer = r->renderer,
        .estimator = a->options.estimator,
        .n_views = r->is_quilt ? r->layout.n_views : r->settings.camera.n_views,
        .width = !r->is_quilt        ? r->settings.width
                 : r->quilt.is_float ? v32->width
                                     : v8->width,
        .height = !r->is_quilt        ? r->settings.height
                  : r->quilt.is_float ? v32->height
                                      : v8->height,
        .threads = lf_pool_threads(r->pool),
        .times = r->times,
    };
    lf_progress_line_clear(&r->line);
    if (r->renderer)
        lf_progress_line_draw(&r->line, "measuring errors");
    json_t *object = lf_render_report_json(&report);
    lf_progress_line_clear(&r->line);
    const lf_status status = put_stats(a->stats, object, err);
    json_decref(object);
    return status;
}

void lf_rendering_finish(lf_rendering *r)
{
    lf_rendering_plate_close(r);
    lf_video_destroy(r->video);
    lf_renderer_destroy(r->renderer);
    lf_scene_unref(r->scene);
    lf_pool_destroy(r->pool);
    lf_quilt_finish(&r->quilt);
    json_decref(r->record);
    lf_profiles_finish(&r->profiles);
    lf_pages_free(r->film);
    lf_pages_free(r->layers);
    lf_free(r->path);
    lf_free(r->sequence.input);
    lf_free(r->state.path);
}
