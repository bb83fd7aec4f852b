#include <sys/resource.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "base/wakeup.h"
#include "daemon/engine/engine_internal.h"

enum { NICER = 5 };

/* -------------------------------------------------------------------------------- the thread -- */

typedef enum next_step {
    NEXT_STOP,
    NEXT_REQUEST,
    NEXT_CHANGES,
    NEXT_FADE,
    NEXT_MOVIE,
    NEXT_RENDER,
    NEXT_SETTLE
} next_step;

/* The link to the first request that may run; NULL in it: none. */
static engine_request **next_request(lf_engine *engine)
{
    engine_request **at = &engine->first;
    while (*at && (*at)->may_run && !(*at)->may_run(engine, *at))
        at = &(*at)->next;
    return at;
}

/* A time of lf_time_now_ns; 0: none. */
static bool has_come(uint64_t ns)
{
    return ns > 0 && lf_time_now_ns() >= ns;
}

static next_step next_todo(lf_engine *engine)
{
    if (engine->life.stop)
        return NEXT_STOP;
    if (*next_request(engine))
        return NEXT_REQUEST;
    const engine_news *news = &engine->news;
    if (news->controls || news->panel || news->card || news->fade)
        return NEXT_CHANGES;
    if (has_come(engine_fade_due_ns(engine)))
        return NEXT_FADE;
    if (news->movie)
        return NEXT_MOVIE;
    return engine_has_work(engine) ? NEXT_RENDER : NEXT_SETTLE;
}

/* True if a frame is to be posted now. */
static bool is_to_settle(const lf_engine *engine)
{
    return !engine->frames.fade.defers && (engine->owed || has_come(engine->frames.again_ns));
}

static void sleep_now(lf_engine *engine)
{
    const uint64_t again = engine->frames.fade.defers ? 0 : engine->frames.again_ns,
                   fade = engine_fade_due_ns(engine);
    const uint64_t until = again > 0 && (fade == 0 || again < fade) ? again : fade;
    if (until > 0)
        (void)lf_cond_wait_until(&engine->wake, &engine->lock, until);
    else
        pthread_cond_wait(&engine->wake, &engine->lock);
}

/* Sleeps while there is no work. Copies changed orders under the lock. */
static next_step wait_for_work(lf_engine *engine, engine_request **out_request,
                               engine_orders *orders)
{
    pthread_mutex_lock(&engine->lock);
    next_step what = next_todo(engine);
    while (what == NEXT_SETTLE && !is_to_settle(engine)) {
        sleep_now(engine);
        what = next_todo(engine);
    }
    if (what == NEXT_REQUEST) {
        engine_request **at = next_request(engine);
        *out_request = *at;
        *at = (*at)->next;
        atomic_store_explicit(&engine->cancel, 0, memory_order_relaxed);
    } else if (what == NEXT_CHANGES) {
        orders->controls = engine->wanted.controls;
        engine->news.controls = false;
    } else if (what == NEXT_MOVIE) {
        engine->news.movie = false;
    }
    if (what == NEXT_REQUEST || what == NEXT_CHANGES) {
        orders->panel = engine->wanted.panel;
        orders->card = engine->wanted.card;
        orders->fade = engine->wanted.fade;
        engine->news.panel = engine->news.card = engine->news.fade = false;
    }
    pthread_mutex_unlock(&engine->lock);
    return what;
}

static void answer(lf_engine *engine, engine_request *request, lf_status status)
{
    pthread_mutex_lock(&engine->lock);
    request->status = status;
    request->done = true;
    pthread_cond_broadcast(&engine->answered);
    pthread_mutex_unlock(&engine->lock);
}

static void end(lf_engine *engine)
{
    if (!engine->spoiled)
        engine_settle(engine);
    engine_end_movie(engine);
    engine_publish(engine);
    pthread_mutex_lock(&engine->lock);
    engine->life.ended = true;
    for (engine_request *r = engine->first; r; r = r->next) {
        r->status = lf_error_set(r->err, LF_E_CANCELLED, "", "the daemon is shutting down");
        r->done = true;
    }
    engine->first = NULL;
    pthread_cond_broadcast(&engine->answered);
    pthread_mutex_unlock(&engine->lock);
    lf_wakeup_signal(engine->event_fd);
}

/* Rendering uses all processors while there is work, so everything else in the daemon gets priority
 * over it (commands, pushes, a panel that returns). Threads inherit the nice value, so the pool is
 * created here. */
static lf_status begin(lf_engine *engine)
{
    /* A failure only makes other work slower. */
    (void)setpriority(PRIO_PROCESS, (id_t)gettid(), getpriority(PRIO_PROCESS, 0) + NICER);
    lf_status status = lf_pool_create(engine->now.controls.threads, &engine->pool);
    pthread_mutex_lock(&engine->lock);
    engine->life.begun = true;
    engine->life.status = status;
    engine->life.ended = status != LF_OK;
    pthread_cond_broadcast(&engine->answered);
    pthread_mutex_unlock(&engine->lock);
    return status;
}

static void *engine_main(void *context)
{
    lf_engine *engine = context;
    if (begin(engine) != LF_OK)
        return NULL;
    for (;;) {
        engine_request *request = NULL;
        engine_orders orders;
        switch (wait_for_work(engine, &request, &orders)) {
        case NEXT_STOP:
            end(engine);
            return NULL;
        case NEXT_REQUEST: {
            /* a request's picture is for the current panel */
            engine_take_panel(engine, &orders.panel);
            engine_take_card(engine, &orders.card);
            engine_take_fade(engine, orders.fade);
            lf_status status = request->run(engine, request);
            engine_publish(engine); /* before the answer, because the caller may query the status
                                     * next */
            answer(engine, request, status);
            break;
        }
        case NEXT_CHANGES:
            engine_take_controls(engine, &orders.controls);
            engine_take_panel(engine, &orders.panel);
            engine_take_card(engine, &orders.card);
            engine_take_fade(engine, orders.fade);
            break;
        case NEXT_FADE:
            engine_fade_step(engine);
            break;
        case NEXT_MOVIE:
            engine_take_movie(engine);
            break;
        case NEXT_RENDER:
            engine_batch(engine);
            break;
        case NEXT_SETTLE:
            engine_settle(engine);
            break;
        }
        engine_publish(engine);
    }
}

/* By the bound at its last check; before the first one by the estimate. */
static double seconds_left(const lf_engine *engine)
{
    const engine_look *look = &engine->look;
    const bool bound = look->error_bound >= 0;
    return lf_schedule_seconds_left(&engine->schedule, engine->spent.passes,
                                    bound ? look->error_bound : look->stats.rel_mse_estimate,
                                    bound ? look->bound_passes : look->stats.passes,
                                    engine->now.controls.target_error);
}

void engine_publish(lf_engine *engine)
{
    lf_engine_status now = {
        .generation = engine->generation,
        .level = engine->level,
        .passes = engine->spent.passes,
        .seconds = engine->spent.seconds,
        .cpu_seconds = engine->spent.budget.now.paths,
        .spp = engine->content && engine->renderer
                   ? engine->spent.passes / engine->content->layout.n_views
                   : -1,
        .error_estimate = engine->look.stats.rel_mse_estimate,
        .error_bound = engine->look.error_bound,
        .shown_error = engine->look.shown_error,
        .shown_error_bound = engine->look.shown_bound,
        .seconds_left = -1,
        .missing = engine->renderer ? lf_picture_missing(&engine->picture) : 0,
        .threads = lf_pool_threads(engine->pool),
        .coarse_cost = engine->spent.budget.coarse,
        .complete_cost = engine->spent.budget.complete,
        .frames = engine->frames.n,
        .reconstructed = engine->renderer && engine->picture.reconstructs,
        .blank = engine->look.blank,
    };
    if (engine->content && (engine->content->scene || engine->content->quilt.is_float))
        now.film = engine->picture.film;
    if (!engine->renderer)
        now.state = LF_STATE_IDLE;
    else if (engine->converged)
        now.state = LF_STATE_CONVERGED;
    else
        now.state = engine->now.controls.paused ? LF_STATE_PAUSED : LF_STATE_RENDERING;
    if (now.state == LF_STATE_CONVERGED)
        now.seconds_left = 0;
    else if (now.state == LF_STATE_RENDERING)
        now.seconds_left = seconds_left(engine);
    pthread_mutex_lock(&engine->lock);
    engine->movie.told_lost = engine->movie.lost;
    bool changed = now.state != engine->status.state ||
                   now.generation != engine->status.generation ||
                   now.level != engine->status.level || now.frames != engine->status.frames;
    engine->status = now;
    pthread_mutex_unlock(&engine->lock);
    if (changed)
        lf_wakeup_signal(engine->event_fd);
}

/* ---------------------------------------------------------------------------- for the others -- */

static lf_status start_thread(lf_engine *engine)
{
    lf_status status = lf_thread_start("lf-engine", engine_main, engine, &engine->life.thread);
    engine->life.started = status == LF_OK;
    pthread_mutex_lock(&engine->lock);
    while (engine->life.started && !engine->life.begun)
        pthread_cond_wait(&engine->answered, &engine->lock);
    status = engine->life.started ? engine->life.status : status;
    pthread_mutex_unlock(&engine->lock);
    return status;
}

lf_status lf_engine_create(const lf_engine_controls *controls, int event_fd, lf_engine **out_engine,
                           lf_error *err)
{
    lf_engine *engine = lf_calloc(1, sizeof *engine);
    if (!engine)
        return lf_error_set(err, LF_E_NOMEM, "engine", "out of memory");
    engine->event_fd = event_fd;
    engine->wanted.controls = engine->now.controls = *controls;
    engine->look.stats = (lf_render_stats){.rel_mse_estimate = -1};
    engine->look.error_bound = engine->look.shown_error = engine->look.shown_bound = -1;
    engine->spent.budget.coarse.paths = engine->spent.budget.complete.paths = -1;
    pthread_mutex_init(&engine->lock, NULL);
    pthread_cond_init(&engine->answered, NULL);
    lf_status status = lf_cond_init(&engine->wake);
    if (status == LF_OK)
        status = lf_mailbox_create(event_fd, &engine->mailbox);
    if (status == LF_OK)
        status = start_thread(engine);
    if (status != LF_OK) {
        lf_engine_destroy(engine);
        return lf_error_set(err, status, "engine", "cannot start the engine's threads");
    }
    *out_engine = engine;
    return LF_OK;
}

void lf_engine_stop(lf_engine *engine, bool cancel)
{
    pthread_mutex_lock(&engine->lock);
    engine->life.stop = true;
    if (cancel)
        atomic_store_explicit(&engine->cancel, 1, memory_order_relaxed);
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}

bool lf_engine_stopped(lf_engine *engine)
{
    pthread_mutex_lock(&engine->lock);
    bool ended = engine->life.ended;
    pthread_mutex_unlock(&engine->lock);
    return ended;
}

void lf_engine_abandon(lf_engine *engine)
{
    pthread_detach(engine->life.thread);
}

void lf_engine_destroy(lf_engine *engine)
{
    if (!engine)
        return;
    lf_engine_stop(engine, true);
    if (engine->life.started)
        pthread_join(engine->life.thread, NULL);
    lf_interlacer_destroy(engine->lens.interlacer);
    lf_image8_finish(&engine->lens.card.image);
    lf_image8_finish(&engine->frames.fade.from);
    lf_image8_finish(&engine->frames.fade.to);
    lf_renderer_destroy(engine->renderer);
    lf_picture_finish(&engine->picture);
    lf_content_unref(engine->content);
    lf_pool_destroy(engine->pool);
    lf_mailbox_destroy(engine->mailbox);
    pthread_cond_destroy(&engine->answered);
    pthread_cond_destroy(&engine->wake);
    pthread_mutex_destroy(&engine->lock);
    lf_free(engine);
}

/* Waits until the thread has run the request. A commit goes first: it makes the state that other
 * requests want obsolete, and it cancels the pass they would wait for. */
static lf_status call(lf_engine *engine, engine_request *request, bool urgent)
{
    pthread_mutex_lock(&engine->lock);
    if (engine->life.stop) {
        pthread_mutex_unlock(&engine->lock);
        return lf_error_set(request->err, LF_E_CANCELLED, "", "the daemon is shutting down");
    }
    engine_request **at = &engine->first;
    while (*at && !urgent)
        at = &(*at)->next;
    request->next = *at;
    *at = request;
    if (urgent)
        atomic_store_explicit(&engine->cancel, 1, memory_order_relaxed);
    pthread_cond_broadcast(&engine->wake);
    while (!request->done)
        pthread_cond_wait(&engine->answered, &engine->lock);
    pthread_mutex_unlock(&engine->lock);
    return request->status;
}

lf_status lf_engine_commit(lf_engine *engine, lf_content *content, bool tells,
                           int64_t *out_generation, double *out_restored, lf_error *err)
{
    engine_request request = {
        .run = engine_run_commit, .err = err, .content = content, .tells = tells};
    lf_status status = call(engine, &request, true);
    if (status == LF_OK) {
        *out_generation = request.generation;
        if (out_restored)
            *out_restored = request.restored;
    }
    return status;
}

lf_status lf_engine_show_as(lf_engine *engine, lf_content *content, int64_t *out_generation,
                            lf_error *err)
{
    engine_request request = {.run = engine_run_show_as, .err = err, .content = content};
    lf_status status = call(engine, &request, false);
    if (status == LF_OK)
        *out_generation = request.generation;
    return status;
}

lf_status lf_engine_snapshot(lf_engine *engine, lf_denoise denoise, unsigned layers,
                             lf_snapshot *out, lf_error *err)
{
    engine_request request = {.run = engine_run_snapshot,
                              .err = err,
                              .denoise = denoise,
                              .layers = layers,
                              .snapshot = out};
    *out = (lf_snapshot){0};
    return call(engine, &request, false);
}

lf_status lf_engine_shown(lf_engine *engine, int n, const lf_cancel *cancel, lf_shown_views *out,
                          lf_error *err)
{
    engine_request request = {.run = engine_run_shown,
                              .may_run = engine_may_run_shown,
                              .err = err,
                              .n_views = n,
                              .cancel = cancel,
                              .shown = out};
    *out = (lf_shown_views){0};
    return call(engine, &request, false);
}

static lf_status save(lf_engine *engine, engine_request *request)
{
    if (lf_engine_stopped(engine))
        return engine_run_save(engine, request);
    request->yields = request->keeps;
    return call(engine, request, false);
}

lf_status lf_engine_save(lf_engine *engine, lf_outfile *file, lf_error *err)
{
    engine_request request = {.run = engine_run_save, .err = err, .file = file};
    return save(engine, &request);
}

lf_status lf_engine_keep(lf_engine *engine, lf_error *err)
{
    lf_outfile file = {.fd = -1};
    engine_request request = {.run = engine_run_save, .err = err, .file = &file, .keeps = true};
    lf_status status = save(engine, &request);
    if (status == LF_OK)
        status = lf_outfile_commit(&file, true, err);
    else
        lf_outfile_abandon(&file);
    if (status == LF_OK)
        lf_states_trim(engine->states);
    return status;
}

void lf_engine_keep_states(lf_engine *engine, lf_states *states)
{
    engine->states = states;
}

void lf_snapshot_finish(lf_snapshot *snapshot)
{
    lf_content_unref(snapshot->content);
    lf_free(snapshot->film);
    lf_free(snapshot->frame);
    lf_free(snapshot->beside);
    *snapshot = (lf_snapshot){0};
}

void lf_engine_set_controls(lf_engine *engine, const lf_engine_controls *controls)
{
    pthread_mutex_lock(&engine->lock);
    engine->wanted.controls = *controls;
    engine->news.controls = true;
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}

lf_engine_controls lf_engine_get_controls(lf_engine *engine)
{
    pthread_mutex_lock(&engine->lock);
    lf_engine_controls controls = engine->wanted.controls;
    pthread_mutex_unlock(&engine->lock);
    return controls;
}

void lf_engine_set_panel(lf_engine *engine, const lf_calibration *calibration, uint64_t panel,
                         bool views)
{
    pthread_mutex_lock(&engine->lock);
    engine->wanted.panel = (engine_panel){.present = calibration, .views = views, .number = panel};
    if (calibration)
        engine->wanted.panel.calibration = *calibration;
    engine->news.panel = true;
    pthread_cond_broadcast(&engine->wake);
    pthread_mutex_unlock(&engine->lock);
}

void lf_engine_get_status(lf_engine *engine, lf_engine_status *out)
{
    pthread_mutex_lock(&engine->lock);
    *out = engine->status;
    pthread_mutex_unlock(&engine->lock);
}

lf_mailbox *lf_engine_mailbox(lf_engine *engine)
{
    return engine->mailbox;
}
