#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/parts/farmed_internal.h"

lf_status lf_farmed_create(const lf_farmed_home *home, const lf_farmed_events *events,
                           void *context, lf_farmed **out_farmed)
{
    lf_farmed *farmed = lf_calloc(1, sizeof *farmed);
    if (!farmed)
        return LF_E_NOMEM;
    *farmed = (lf_farmed){.home = *home, .events = *events, .context = context};
    *out_farmed = farmed;
    return LF_OK;
}

void lf_farmed_destroy(lf_farmed *farmed)
{
    lf_free(farmed);
}

void lf_farmed_order_finish(lf_farmed_order *order)
{
    lf_free(order->file);
    lf_held_name_finish(&order->folder);
    lf_content_unref(order->content);
    json_decref(order->camera);
    lf_render_words_finish(&order->words);
    order->content = NULL;
    order->camera = NULL;
}

static void free_job(lf_farmed_job *job)
{
    pthread_mutex_destroy(&job->lock);
    pthread_cond_destroy(&job->wake);
    lf_farmed_order_finish(&job->order);
    lf_free(job->record);
    lf_free(job);
}

/* -------------------------------------------------------------------------------------- told -- */

static lf_farmed_told told_of(const lf_farmed_job *job, lf_farmed_state state)
{
    const lf_farmed_look *look = &job->seen;
    const double share = look->total > 0 ? (double)look->complete / (double)look->total : 0;
    return (lf_farmed_told){.id = job->id,
                            .client = job->order.client,
                            .engine = job->order.engine,
                            .kind = job->order.kind,
                            .file = job->order.file,
                            .folder = job->order.folder.path,
                            .state = state,
                            .progress = state == LF_FARMED_DONE ? 1
                                        : share < 1             ? share
                                                                : 1,
                            .look = look,
                            .err = state == LF_FARMED_FAILED ? &job->err : NULL};
}

static void tell(const lf_farmed_job *job, lf_farmed_state state)
{
    const lf_farmed_told told = told_of(job, state);
    job->farmed->events.told(job->farmed->context, &told);
}

bool lf_farmed_at(const lf_farmed *farmed, int i, lf_farmed_told *out)
{
    const lf_farmed_job *job = farmed->first;
    while (job && i-- > 0)
        job = job->next;
    if (job)
        *out = told_of(job, LF_FARMED_RUNNING);
    return job;
}

/* The client may have left long ago. */
static void log_end(const lf_farmed_job *job)
{
    char text[sizeof job->err + 32];
    if (job->status == LF_OK)
        lf_log(LF_LOG_INFO, "%s: the farm has rendered it (job %lld)", job->order.file,
               (long long)job->id);
    else if (job->status == LF_E_CANCELLED)
        lf_log(LF_LOG_INFO, "%s: the farm job %lld was cancelled", job->order.file,
               (long long)job->id);
    else
        lf_log(LF_LOG_WARNING, "%s: the farm job %lld has failed: %s", job->order.file,
               (long long)job->id, lf_error_format(&job->err, text, sizeof text));
}

static void end_job(lf_farmed_job *job)
{
    lf_farmed *farmed = job->farmed;
    lf_farmed_job **at = &farmed->first;
    pthread_join(job->thread, NULL);
    while (*at != job)
        at = &(*at)->next;
    *at = job->next;
    if (!atomic_load(&job->leave)) {
        log_end(job);
        tell(job, job->status == LF_OK            ? LF_FARMED_DONE
                  : job->status == LF_E_CANCELLED ? LF_FARMED_CANCELLED
                                                  : LF_FARMED_FAILED);
    }
    free_job(job);
    farmed->events.ended(farmed->context);
}

static void on_news(void *reader, lf_task *task)
{
    lf_farmed_job *job = (lf_farmed_job *)(void *)task;
    (void)reader;
    pthread_mutex_lock(&job->lock);
    job->posted = false;
    job->seen = job->look;
    const bool has_ended = job->has_ended;
    pthread_mutex_unlock(&job->lock);
    if (has_ended)
        end_job(job);
    else
        tell(job, LF_FARMED_RUNNING);
}

/* ------------------------------------------------------------------------------------ adding -- */

static void *job_main(void *context)
{
    lf_farmed_job *job = context;
    lf_farmed_run(job);
    return NULL;
}

/* NULL: out of memory. */
static lf_farmed_job *make_job(lf_farmed *farmed, int64_t id)
{
    lf_farmed_job *job = lf_calloc(1, sizeof *job);
    if (job && lf_cond_init(&job->wake) != LF_OK) {
        lf_free(job);
        return NULL;
    }
    if (!job)
        return NULL;
    pthread_mutex_init(&job->lock, NULL);
    job->farmed = farmed;
    job->id = id;
    job->news = (lf_task){.done = on_news};
    job->order.folder.folder_fd = -1;
    job->look =
        (lf_farmed_look){.state = "planning", .planned = -1, .spent = -1, .seconds_left = -1};
    job->seen = job->look;
    return job;
}

/* The order is the job's on LF_OK. */
static lf_status start(lf_farmed_job *job, const lf_farmed_order *order, lf_error *err)
{
    lf_farmed *farmed = job->farmed;
    job->order = *order;
    if (!job->record)
        job->record = lf_farmed_record_path(farmed, order->folder.path);
    if (lf_thread_start("lf-farmed", job_main, job, &job->thread) != LF_OK) {
        job->order = (lf_farmed_order){.folder.folder_fd = -1};
        free_job(job);
        return lf_error_set(err, LF_E_NOMEM, "export", "cannot start a thread");
    }
    job->next = farmed->first;
    farmed->first = job;
    return LF_OK;
}

lf_status lf_farmed_add(lf_farmed *farmed, int64_t id, const lf_farmed_order *order, lf_error *err)
{
    int n = 0;
    for (const lf_farmed_job *other = farmed->first; other; other = other->next)
        n++;
    if (n >= LF_FARMED_MOST)
        return lf_error_set(err, LF_E_BUSY, "export",
                            "%d farm jobs are running already; end one with job.cancel",
                            LF_FARMED_MOST);
    lf_farmed_job *job = make_job(farmed, id);
    return job ? start(job, order, err) : lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
}

/* ------------------------------------------------------------------------------------ an end -- */

static void stop(lf_farmed_job *job, lf_cancel *how)
{
    pthread_mutex_lock(&job->lock);
    atomic_store(how, 1);
    pthread_cond_broadcast(&job->wake);
    pthread_mutex_unlock(&job->lock);
}

bool lf_farmed_cancel(lf_farmed *farmed, int64_t id)
{
    lf_farmed_job *job = farmed->first;
    while (job && job->id != id)
        job = job->next;
    if (job)
        stop(job, &job->cancel);
    return job;
}

void lf_farmed_leave(lf_farmed *farmed)
{
    for (lf_farmed_job *job = farmed->first; job; job = job->next)
        stop(job, &job->leave);
}

/* --------------------------------------------------------------------------------- taking up -- */

static bool is_allowed(const char *engine, unsigned bits)
{
    int i = 0;
    while (lf_farmed_engine_at(i) && strcmp(lf_farmed_engine_at(i), engine) != 0)
        i++;
    return bits >> i & 1;
}

static void take_up(lf_farmed *farmed, const char *path, unsigned bits, int64_t *id)
{
    lf_farmed_order order = {.folder.folder_fd = -1};
    lf_error err;
    lf_status status = lf_farmed_record_read(&farmed->home, path, &order, &err);
    lf_farmed_job *job = NULL;
    if (status == LF_OK && !is_allowed(order.engine, bits))
        status = lf_error_set(&err, LF_E_STATE, order.folder.path,
                              "quiltd no longer follows this job; start it with --farm %s",
                              order.engine);
    if (status == LF_OK && !(job = make_job(farmed, *id + 1)))
        status = lf_error_set(&err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK) {
        job->is_submitted = true;
        job->record = lf_strdup(path);
        status = start(job, &order, &err);
    }
    if (status == LF_OK) {
        ++*id;
        lf_log(LF_LOG_INFO, "%s: follows this job of the farm again", order.folder.path);
        return;
    }
    lf_log_error(&err);
    lf_farmed_order_finish(&order);
}

void lf_farmed_take_up(lf_farmed *farmed, unsigned engines, int64_t *id)
{
    const char *folder = farmed->home.state_dir;
    DIR *dir = folder && farmed->home.export_root ? opendir(folder) : NULL;
    const struct dirent *entry;
    for (int n = 0; dir && n < LF_FARMED_MOST && (entry = readdir(dir));) {
        if (!lf_farmed_is_record(entry->d_name))
            continue;
        char *path = lf_path_join(folder, entry->d_name);
        if (path)
            take_up(farmed, path, engines, id);
        lf_free(path);
        n++;
    }
    if (dir)
        closedir(dir);
}
