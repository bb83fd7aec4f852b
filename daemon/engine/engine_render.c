#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/engine/engine_internal.h"
#include "daemon/output/render_job.h"

/* Duration of a batch in seconds: short until the picture is complete, then longer, since every
 * frame costs the same. Not so long that a moving picture appears to stand still. */
#define BATCH_SECONDS 0.12
#define BATCH_SECONDS_COMPLETE 0.2
/* While a crossfade runs, whose frames come between the batches. */
#define BATCH_SECONDS_FADE 0.012
/* Shortest interval between frames, while the picture is incomplete and later; small pictures have
 * short batches. */
#define FRAME_SECONDS 0.03
#define FRAME_SECONDS_COMPLETE 0.1
/* Largest share of the time for composing frames, except the first coarse and the first complete
 * one. */
#define FRAME_SHARE 0.2
/* Largest share of the time for the error estimate, which reads the whole film. */
#define STATS_SHARE 0.05
#define MAX_SPP 65536
/* The reconstruction is fitted again, and all rows shown with it, when the number of passes has
 * grown by this factor since the last fit: while rows are missing, and later. The third value is
 * the largest share of the time. */
#define FIT_GROWTH_INCOMPLETE 3.0
#define FIT_GROWTH 1.3
#define FIT_SHARE 0.3

bool engine_has_work(const lf_engine *engine)
{
    return engine->renderer && !engine->now.controls.paused && !engine->converged;
}

static double batch_seconds(const lf_engine *engine)
{
    if (engine->frames.fade.runs)
        return BATCH_SECONDS_FADE;
    return engine->level < LF_LEVEL_COMPLETE ? BATCH_SECONDS : BATCH_SECONDS_COMPLETE;
}

static void look_at_shown(lf_engine *engine)
{
    engine->look.shown_error = engine->look.shown_bound = -1;
    if (engine->fit.passes > 0)
        engine->look.shown_bound = lf_renderer_shown_error(
            engine->renderer, LF_ERROR_ALPHA, &engine->look.shown_error, &engine->cancel);
}

static void update_stats(lf_engine *engine, bool now)
{
    double start = lf_time_now();
    if (!engine->renderer || (!now && (start - engine->look.at) * STATS_SHARE < engine->look.cost))
        return;
    if (engine->picture.reconstructs)
        lf_picture_estimate(&engine->picture, engine->pool, &engine->cancel);
    lf_renderer_stats(engine->renderer, &engine->look.stats);
    if (engine->picture.reconstructs && atomic_load_explicit(&engine->cancel, memory_order_relaxed))
        engine->look.stats.rel_mse_estimate = -1; /* some rows were not updated */
    if (!engine->look.told_of_cut && engine->level >= LF_LEVEL_COMPLETE)
        engine->look.told_of_cut =
            lf_render_warn_of_cut(&engine->look.stats, engine->content->file);
    look_at_shown(engine);
    engine->look.at = lf_time_now();
    engine->look.cost = engine->look.at - start;
}

/* Checks the bound, which costs as much as two resolves, only if the estimate is low enough. Checks
 * are at least a tenth of the passes apart. */
static bool reached_target(lf_engine *engine)
{
    double target = engine->now.controls.target_error;
    if (!(engine->look.stats.rel_mse_estimate >= 0 && engine->look.stats.rel_mse_estimate < target))
        return false;
    if (engine->spent.passes >= 1.1 * engine->look.bound_passes) {
        engine->look.error_bound = lf_renderer_error_bound(
            engine->renderer, engine->picture.estimator, LF_ERROR_ALPHA, NULL);
        engine->look.bound_passes = engine->spent.passes;
    }
    return engine->look.error_bound >= 0 && engine->look.error_bound < target;
}

static void check_converged(lf_engine *engine)
{
    bool enough = engine->spent.passes >= (double)MAX_SPP * engine->schedule.n_views;
    if (lf_schedule_has_halves(&engine->schedule) && engine->level >= LF_LEVEL_COARSE &&
        lf_picture_caught(&engine->picture) && (enough || reached_target(engine))) {
        engine->converged = true;
        engine->owed = true;
    }
}

/* ------------------------------------------------------------------------------------ frames -- */

lf_views8 engine_views_now(lf_engine *engine, int64_t *out_blank)
{
    *out_blank = 0;
    if (!engine->content->scene && !engine->content->quilt.is_float) {
        engine->level = LF_LEVEL_CONVERGED;
        return engine->content->player ? engine->movie.views : engine->content->quilt.views8;
    }
    int64_t unfilled;
    lf_views8 views = lf_picture_views(&engine->picture, engine->pool, &unfilled, out_blank);
    bool final = engine->converged || !engine->content->scene;
    if (unfilled > 0) {
        lf_log(LF_LOG_DEBUG,
               "%.2f passes: %lld view pixels have no sample, %lld of them cannot be filled",
               engine->spent.passes, (long long)lf_picture_missing(&engine->picture),
               (long long)unfilled);
        engine->level = LF_LEVEL_NONE;
    } else if (final) {
        engine->level = LF_LEVEL_CONVERGED;
    } else {
        engine->level =
            lf_picture_missing(&engine->picture) > 0 ? LF_LEVEL_COARSE : LF_LEVEL_COMPLETE;
    }
    return views;
}

/* Adds the CPU time since *from, and sets *from to now. */
static void take_time(double *sum, double *from)
{
    const double now = lf_time_cpu();
    *sum += now - *from;
    *from = now;
}

/* True if a new fit is due before the next frame. The first frame waits for a fit, because noise
 * before it would flicker. The first complete frame also waits: a fit of some rows knows little
 * about the others. */
static bool fit_is_due(const lf_engine *engine, bool final)
{
    const engine_fit *fit = &engine->fit;
    const double growth =
        lf_picture_missing(&engine->picture) > 0 ? FIT_GROWTH_INCOMPLETE : FIT_GROWTH;
    if (!engine->renderer || !engine->picture.reconstructs || fit->passes == engine->spent.passes)
        return false;
    const bool first = fit->passes <= 0,
               completes = !fit->is_whole && lf_picture_missing(&engine->picture) == 0;
    return final || first || completes ||
           (fit->passes > 0 && engine->spent.passes >= growth * fit->passes &&
            (lf_time_now() - fit->at) * FIT_SHARE >= fit->cost);
}

/* Makes a new fit and shows all rows with it. */
static lf_status fit(lf_engine *engine, bool final)
{
    lf_frame_cost *cost = &engine->spent.budget.now;
    double start = lf_time_now(), cpu = lf_time_cpu();
    lf_status status = lf_renderer_pass_fans(engine->renderer, &engine->cancel);
    take_time(&cost->fans, &cpu);
    if (status == LF_OK)
        status = lf_renderer_fit(engine->renderer, &engine->cancel);
    take_time(&cost->fit, &cpu);
    engine->fit.passes = status == LF_OK ? engine->spent.passes : 0;
    if (status != LF_OK && status != LF_E_CANCELLED) {
        lf_log(LF_LOG_ERROR, "out of memory for denoising; the image is shown unfiltered");
        engine->picture.reconstructs = false;
        lf_picture_forget(&engine->picture);
        status = LF_OK;
    }
    if (status == LF_OK)
        status = lf_picture_fitted(&engine->picture, engine->pool, &engine->cancel);
    take_time(&cost->answer, &cpu);
    if (status == LF_OK && final)
        look_at_shown(engine);
    engine->fit.is_whole = status == LF_OK && lf_picture_missing(&engine->picture) == 0;
    engine->fit.at = lf_time_now();
    engine->fit.cost = engine->fit.at - start;
    lf_log(LF_LOG_DEBUG, "%.2f passes: denoised in %.3f s", engine->spent.passes, engine->fit.cost);
    return status;
}

/* Checks whether a scene's frame is blank. Objects outside the camera's view were reported at
 * loading. */
static void look_for_blank(lf_engine *engine, const lf_views8 *views)
{
    const lf_blank before = engine->look.blank;
    engine->look.blank = engine->content->scene && !engine->content->is_unseen
                             ? lf_blank_of_views8(views)
                             : LF_BLANK_NOT;
    const char *words = lf_blank_words(engine->look.blank, true);
    if (words && before == LF_BLANK_NOT && !engine->content->is_frame)
        lf_log(LF_LOG_WARNING, "%s: %s", engine->content->file, words);
}

/* Records the cost until coarse and complete, once per picture, unless it came from a saved
 * state. */
static void note_cost(lf_engine *engine)
{
    engine_budget *budget = &engine->spent.budget;
    if (!engine->renderer || !(budget->now.paths > 0))
        return;
    if (!budget->was_coarse && engine->level >= LF_LEVEL_COARSE)
        budget->coarse = budget->now;
    if (!budget->was_complete && engine->level >= LF_LEVEL_COMPLETE)
        budget->complete = budget->now;
    budget->was_coarse |= engine->level >= LF_LEVEL_COARSE;
    budget->was_complete |= engine->level >= LF_LEVEL_COMPLETE;
}

void engine_post_frame(lf_engine *engine, bool final)
{
    const bool fits = fit_is_due(engine, final);
    engine->frames.fade.defers = engine->owed =
        fits && engine->fit.passes > 0 && engine->frames.fade.runs;
    if (engine->frames.fade.defers)
        return;
    engine->frames.again_ns = 0;
    if (fits && fit(engine, final) != LF_OK)
        return;
    engine->frames.at = lf_time_now();
    double cpu = lf_time_cpu();
    int64_t blank;
    lf_views8 views = engine_views_now(engine, &blank);
    if (blank > 0 || (!final && engine_fade_waits(engine)))
        return;
    if (lf_picture_expose(&engine->picture, engine->pool))
        views = engine_views_now(engine, &blank);
    look_for_blank(engine, &views);
    engine->frames.shows = !engine_post_dark_card(engine, &views);
    if (!engine->frames.shows)
        return;
    const lf_interlacer *interlacer = engine_interlacer_now(engine);
    lf_frame *frame = engine_begin_frame(engine, interlacer);
    if (!frame)
        return;
    frame->columns = engine->content->layout.columns;
    frame->rows = engine->content->layout.rows;
    if (interlacer)
        lf_interlace(interlacer, &views, &frame->image, engine->pool);
    engine->frames.has_picture = true;
    take_time(&engine->spent.budget.now.compose, &cpu);
    note_cost(engine);
    engine_end_frame(engine, frame, &views, final);
}

/* True if a frame was posted just now, or the last one is still waiting and is as good as a new
 * one, which would not be worth its interlacing. The new frame stays owed. */
static bool frame_can_wait(lf_engine *engine)
{
    bool complete = lf_picture_missing(&engine->picture) == 0;
    bool news = (engine->level < LF_LEVEL_COMPLETE && complete) ||
                engine->frames.n == engine->frames.n_before;
    double apart = engine->level < LF_LEVEL_COMPLETE ? FRAME_SECONDS : FRAME_SECONDS_COMPLETE;
    if (engine->level > LF_LEVEL_NONE && apart < engine->frames.cost / FRAME_SHARE)
        apart = engine->frames.cost / FRAME_SHARE;
    if (!news && lf_time_now() - engine->frames.at < apart)
        return true;
    const lf_frame *ready = lf_mailbox_waiting(engine->mailbox);
    return ready && ready->generation == engine->generation &&
           ready->panel == engine->now.panel.number && ready->level == engine->level &&
           (ready->level >= LF_LEVEL_COMPLETE || !complete) && ready->level != LF_LEVEL_NONE;
}

/* Native samples fill pixels that no shared path has reached: first as many as a coarse frame
 * needs, then all, until the picture is complete. A fit needs none. */
static int hole_reach(const lf_engine *engine, const lf_batch *batch)
{
    if (engine->level >= LF_LEVEL_COMPLETE)
        return -1;
    if (engine->picture.reconstructs)
        return -1;
    return batch->coarse ? LF_COARSE_REACH : 0;
}

static lf_status render(lf_engine *engine, const lf_batch *batch)
{
    const lf_part part = {.first_row = batch->first, .row_step = batch->step};
    const int reach = hole_reach(engine, batch);
    if (batch->coarse)
        return lf_renderer_pass_coarse(engine->renderer, &part, reach,
                                       engine->picture.reconstructs ? lf_picture_row_later
                                                                    : lf_picture_row,
                                       &engine->picture, &engine->cancel);
    return lf_renderer_pass_filling(engine->renderer, &part, batch->subsets, reach, lf_picture_row,
                                    &engine->picture, &engine->cancel);
}

void engine_batch(lf_engine *engine)
{
    lf_batch batch = lf_schedule_next(&engine->schedule, batch_seconds(engine));
    double start = lf_time_now();
    double cpu = lf_time_cpu();
    lf_status status = LF_OK;
    engine->picture.sampled = engine->spent.passes >= engine->schedule.n_views;
    if (batch.n_rows > 0)
        status = render(engine, &batch);
    if (status != LF_OK) {
        engine->spoiled = true;
        return;
    }
    double seconds = lf_time_now() - start;
    engine->spent.seconds += seconds;
    take_time(&engine->spent.budget.now.paths, &cpu);
    engine->spent.passes += (double)batch.n_rows * batch.subsets / engine->schedule.height;
    engine->owed = true;
    bool swept = lf_schedule_done(&engine->schedule, &batch, seconds);
    /* the error of such a picture cannot be estimated */
    if (!batch.coarse || !engine->picture.reconstructs)
        update_stats(engine, swept && engine->schedule.sweep <= 4);
    check_converged(engine);
    if (engine->converged || (lf_schedule_covers(&engine->schedule) && !frame_can_wait(engine)))
        engine_post_frame(engine, engine->converged);
}

void engine_settle(lf_engine *engine)
{
    if (!engine->content) {
        bool again = engine->frames.again_ns > 0;
        engine->owed = false;
        engine->frames.again_ns = 0;
        if (again)
            engine_post_waiting_card(engine);
    }
    if (engine->owed)
        update_stats(engine, true);
    if (engine->owed || engine->frames.again_ns > 0)
        engine_post_frame(engine, true);
}

/* ----------------------------------------------------------------------------------- changes -- */

static lf_film_settings film_now(const lf_engine *engine, const lf_content *content)
{
    const lf_engine_controls *controls = &engine->now.controls;
    return lf_exposed_film(&content->film,
                           controls->has_exposure ? controls->exposure : -(double)INFINITY);
}

static bool is_toned(const lf_content *content)
{
    return content && (content->scene || content->quilt.is_float);
}

/* Changes the exposure; the accumulation continues. */
static void retone(lf_engine *engine)
{
    lf_film_settings film = film_now(engine, engine->content);
    lf_error err;
    lf_status status =
        engine->renderer
            ? lf_picture_retone(&engine->picture, &film, engine->pool, &err)
            : lf_picture_shape(&engine->picture, engine->picture.n_views, engine->picture.width,
                               engine->picture.height, engine->picture.n_threads, &film, &err);
    if (status != LF_OK)
        lf_log_error(&err);
    if (!engine->renderer)
        lf_picture_take(&engine->picture, &engine->content->quilt.views32);
    engine->owed = true;
}

/* Enables guides if they are requested and the picture has a depth. */
static void guide(lf_engine *engine, const lf_content *content)
{
    const bool on = engine->now.controls.guides && engine->renderer && content->scene &&
                    content->has_depth && content->settings.features;
    if (lf_picture_guide(&engine->picture, on ? &content->depth : NULL) != LF_OK)
        lf_log(LF_LOG_ERROR, "out of memory for the guides; the image is shown without them");
}

static bool reconstructs(const lf_engine_controls *controls, const lf_content *content)
{
    bool wanted = controls->denoise == LF_DENOISE_ON || (controls->denoise == LF_DENOISE_AUTO &&
                                                         controls->estimator == LF_ESTIMATOR_MWIS);
    return wanted && content && content->scene && content->settings.features;
}

/* Shows rows with the current estimator or fit. Searches again for missing pixels of an unfiltered
 * picture: while it was reconstructed nothing was filled, after a move not even for a coarse
 * frame. */
static void show_anew(lf_engine *engine)
{
    const lf_part coarse = {.first_row = LF_COARSE_ROW, .row_step = LF_COARSE_STEP};
    engine->fit.passes = 0;
    look_at_shown(engine);
    if (engine->picture.reconstructs)
        return;
    if (engine->level == LF_LEVEL_COARSE &&
        lf_renderer_fill_holes(engine->renderer, &coarse, &engine->cancel) != LF_OK)
        engine->spoiled = true;
    lf_picture_forget(&engine->picture);
    (void)!lf_picture_resolve(&engine->picture, engine->pool, NULL);
    engine->level = engine->level < LF_LEVEL_COMPLETE ? engine->level : LF_LEVEL_COARSE;
}

void engine_take_controls(lf_engine *engine, const lf_engine_controls *controls)
{
    const bool shows = engine->content && reconstructs(controls, engine->content),
               turns = shows != engine->picture.reconstructs;
    bool resolve = turns || controls->estimator != engine->now.controls.estimator;
    bool expose = controls->has_exposure != engine->now.controls.has_exposure ||
                  controls->exposure > engine->now.controls.exposure ||
                  controls->exposure < engine->now.controls.exposure;
    if (controls->target_error < engine->now.controls.target_error || resolve)
        engine->converged = false;
    const bool mark = controls->guides != engine->now.controls.guides;
    bool recode =
        controls->has_codes != engine->now.controls.has_codes ||
        memcmp(&controls->codes, &engine->now.controls.codes, sizeof controls->codes) != 0;
    engine->owed = engine->owed || resolve || mark || recode ||
                   controls->paused != engine->now.controls.paused;
    engine->now.controls = *controls;
    engine->picture.estimator = controls->estimator;
    engine->picture.reconstructs = shows;
    if (engine->content && mark)
        guide(engine, engine->content);
    if (engine->renderer && turns)
        show_anew(engine);
    else if (engine->renderer && (resolve || mark))
        (void)!lf_picture_resolve(&engine->picture, engine->pool, NULL);
    if (expose && is_toned(engine->content))
        retone(engine);
    if (engine->renderer && !engine->converged)
        check_converged(engine);
}

void engine_take_panel(lf_engine *engine, const engine_panel *panel)
{
    if (panel->number != engine->now.panel.number) {
        engine->now.panel = *panel;
        engine_fade_end(engine);
        engine->owed = true;
        engine_drop_interlacer(engine);
        engine_post_waiting_card(engine);
    }
}

/* Restores the saved state of this picture. */
static void restore(lf_engine *engine, engine_request *request)
{
    if (!lf_states_restore(engine->states, engine->renderer, request->tells))
        return;
    update_stats(engine, true);
    request->restored = engine->spent.passes = engine->look.stats.passes;
    engine->picture.sampled = engine->spent.passes >= request->content->layout.n_views;
    (void)!lf_picture_resolve(&engine->picture, engine->pool, NULL);
    engine->owed = true;
}

static lf_status change_threads(lf_engine *engine, lf_error *err)
{
    int wanted = engine->now.controls.threads != 0 ? engine->now.controls.threads : lf_cpu_count();
    if (wanted == lf_pool_threads(engine->pool))
        return LF_OK;
    lf_pool *pool;
    lf_status status = lf_pool_create(wanted, &pool);
    if (status != LF_OK)
        return lf_error_set(err, status, "threads", "cannot start %d threads", wanted);
    lf_renderer_destroy(engine->renderer);
    engine->renderer = NULL;
    lf_pool_destroy(engine->pool);
    engine->pool = pool;
    return LF_OK;
}

/* Creates film and picture for a content. */
static lf_status set_up(lf_engine *engine, lf_content *content, lf_error *err)
{
    lf_status status;
    if (!content->scene) {
        lf_renderer_destroy(engine->renderer);
        engine->renderer = NULL;
    } else if (engine->renderer) {
        status = lf_renderer_restart(engine->renderer, content->scene, &content->settings, err);
        if (status != LF_OK)
            return status;
    } else {
        status = lf_renderer_create(content->scene, &content->settings, engine->pool,
                                    &engine->renderer, err);
        if (status != LF_OK)
            return status;
    }
    if (!is_toned(content))
        return engine_prepare_movie(engine, content, err);
    const lf_layout *layout = &content->layout;
    const lf_film_settings film = film_now(engine, content);
    status = lf_picture_shape(&engine->picture, layout->n_views, layout->view_width,
                              layout->view_height, lf_pool_threads(engine->pool), &film, err);
    if (status != LF_OK)
        return status;
    if (lf_picture_follow(&engine->picture, engine->renderer) != LF_OK)
        lf_log(LF_LOG_ERROR,
               "out of memory for shadow catchers; the image is shown without their shadows");
    guide(engine, content);
    engine->picture.estimator = engine->now.controls.estimator;
    engine->picture.reconstructs = reconstructs(&engine->now.controls, content);
    if (!content->scene)
        lf_picture_take(&engine->picture, &content->quilt.views32);
    return LF_OK;
}

static void start_over(lf_engine *engine)
{
    engine->spoiled = engine->converged = engine->frames.fade.defers = false;
    engine->owed = engine->content && !engine->content->scene;
    engine->level = LF_LEVEL_NONE;
    engine->spent.passes = engine->spent.seconds = 0;
    engine->look.stats = (lf_render_stats){.rel_mse_estimate = -1};
    engine->look.error_bound = engine->look.shown_error = engine->look.shown_bound = -1;
    engine->look.bound_passes = 0;
    engine->look.at = 0;
    engine->fit = (engine_fit){0};
    engine->frames.n_before = engine->frames.n;
    engine->frames.shows = false;
    engine->spent.budget.now = (lf_frame_cost){0};
    engine->spent.budget.was_coarse = engine->spent.budget.was_complete = false;
}

static void start_schedule(lf_engine *engine)
{
    const lf_layout *layout = &engine->content->layout;
    lf_schedule_start(&engine->schedule, layout->view_height, layout->n_views,
                      engine->picture.reconstructs, engine->spent.passes);
}

/* Restores the old content after a new one could not be set up. */
static void recover(lf_engine *engine)
{
    if (!engine->content || set_up(engine, engine->content, NULL) != LF_OK) {
        engine_end_movie(engine);
        lf_renderer_destroy(engine->renderer);
        engine->renderer = NULL;
        lf_content_unref(engine->content);
        engine->content = NULL;
    }
    start_over(engine);
    if (engine->content) {
        engine_keep_movie(engine);
        start_schedule(engine);
    }
}

lf_status engine_run_commit(lf_engine *engine, engine_request *request)
{
    pthread_mutex_lock(&engine->lock);
    engine->now.controls = engine->wanted.controls;
    pthread_mutex_unlock(&engine->lock);
    lf_content *content = request->content;
    lf_status status = change_threads(engine, request->err);
    if (status == LF_OK)
        status = set_up(engine, content, request->err);
    if (status != LF_OK) {
        recover(engine);
        return status;
    }
    lf_content *before = engine->content;
    engine->look.told_of_cut &= before && strcmp(before->file, content->file) == 0;
    engine_end_movie(engine);
    engine->content = lf_content_ref(content);
    engine_fade_commit(engine, before, content);
    start_over(engine);
    lf_content_unref(before);
    request->generation = ++engine->generation;
    engine_begin_movie(engine);
    if (content->scene && engine->states)
        restore(engine, request);
    start_schedule(engine);
    if (request->restored > 0) {
        engine_post_frame(engine, true);
        check_converged(engine);
    }
    return LF_OK;
}

lf_status engine_run_show_as(lf_engine *engine, engine_request *request)
{
    if (!engine->renderer || !engine->content || engine->spoiled)
        return engine_run_commit(engine, request);
    lf_content *before = engine->content;
    engine->content = lf_content_ref(request->content);
    lf_content_unref(before);
    request->generation = ++engine->generation;
    retone(engine);
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- exports -- */

/* auto: as shown, or as controls that are not yet in force will show it. */
static bool is_reconstructed(lf_engine *engine, lf_denoise asked)
{
    const lf_engine_controls wanted = lf_engine_get_controls(engine);
    return asked == LF_DENOISE_AUTO ? reconstructs(&wanted, engine->content)
                                    : asked == LF_DENOISE_ON;
}

static lf_status take_film(lf_engine *engine, lf_snapshot *out, lf_error *err)
{
    if (out->reconstructed && !engine->content->settings.features)
        return lf_error_set(
            err, LF_E_STATE, "denoise",
            "the current image was started with denoise off; use render.set denoise=on");
    lf_status status =
        lf_picture_film(&engine->picture, out->reconstructed, engine->pool, out->film);
    if (status == LF_E_STATE)
        return lf_error_set(err, status, "",
                            "nothing has been rendered yet; use wait for=coarse first");
    return status == LF_OK ? LF_OK : lf_error_set(err, status, "", "out of memory for the views");
}

/* Adds the layers of the source. */
static lf_status take_layers(lf_engine *engine, unsigned layers, lf_snapshot *out, lf_error *err)
{
    const lf_content *content = engine->content;
    const size_t n = (size_t)lf_layer_channels(layers, out->names),
                 width = (size_t)content->layout.view_width * n,
                 row = width * (size_t)content->layout.n_views;
    if (!content->settings.features)
        return lf_error_set(err, LF_E_STATE, "export",
                            "the current image was started with denoise off and has no depth; use "
                            "render.set denoise=on");
    out->beside = lf_calloc((size_t)content->layout.view_height, row * sizeof *out->beside);
    if (!out->beside)
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory for the layers");
    out->layers = (lf_layers32){(int)n, out->names, width, row, out->beside};
    out->source.views32.layers = &out->layers;
    lf_status status = lf_renderer_layers(engine->renderer, engine->now.controls.estimator, layers,
                                          out->beside, NULL);
    return status == LF_OK ? LF_OK
                           : lf_error_set(err, status, "", "the layers could not be computed");
}

lf_status engine_run_snapshot(lf_engine *engine, engine_request *request)
{
    lf_content *content = engine->content;
    lf_snapshot *out = request->snapshot;
    if (!content || engine->spoiled)
        return lf_error_set(request->err, LF_E_STATE, "",
                            "there is no image to export; load a scene first");
    if (request->layers && !content->scene)
        return lf_error_set(request->err, LF_E_STATE, "export",
                            "a finished image has no depth; load a scene first");
    if (content->scene) {
        const lf_layout *layout = &content->layout;
        size_t pixels =
            (size_t)layout->n_views * (size_t)layout->view_width * (size_t)layout->view_height;
        out->film = lf_calloc(pixels, 3 * sizeof *out->film);
        if (!out->film)
            return lf_error_set(request->err, LF_E_NOMEM, "", "out of memory for the views");
        out->reconstructed = is_reconstructed(engine, request->denoise);
        lf_status status = take_film(engine, out, request->err);
        out->source = lf_output_from_film(&content->settings, out->film);
        out->source.reconstructed = out->reconstructed;
        if (status == LF_OK && request->layers)
            status = take_layers(engine, request->layers, out, request->err);
        if (status != LF_OK) {
            lf_snapshot_finish(out);
            return status;
        }
        update_stats(engine, true);
    } else {
        out->source = lf_output_from_quilt(&content->quilt, content->file);
        lf_status status =
            content->player ? engine_snapshot_movie(engine, out, request->err) : LF_OK;
        if (status != LF_OK)
            return status;
    }
    out->shown_as = is_toned(content) ? engine->picture.film : content->film;
    out->content = lf_content_ref(content);
    out->estimator = engine->now.controls.estimator;
    out->stats = engine->look.stats;
    out->generation = engine->generation;
    return LF_OK;
}

lf_status engine_run_save(lf_engine *engine, engine_request *request)
{
    if (!engine->renderer || engine->spoiled)
        return lf_error_set(request->err, LF_E_STATE, "",
                            "there is no rendering to save; load a scene first");
    lf_status status = request->keeps ? lf_states_begin(engine->states, engine->renderer,
                                                        request->file, request->err)
                                      : LF_OK;
    if (status != LF_OK)
        return status;
    return lf_renderer_save(engine->renderer, request->file,
                            request->yields ? &engine->cancel : NULL, request->err);
}
