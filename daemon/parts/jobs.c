#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/parts/jobs_internal.h"

#define PROGRESS_USEC 250000
#define MAX_JOBS 8
/* Limits of waiting jobs: in total, so that others are never kept out; detached; and per client. */
#define MOST_WAITING 6
#define MOST_DETACHED 4
#define MOST_OF_CLIENT 2

lf_status lf_jobs_create(const lf_jobs_home *home, const lf_jobs_events *events, void *context,
                         lf_jobs **out_jobs)
{
    lf_jobs *jobs = lf_calloc(1, sizeof *jobs);
    if (!jobs)
        return LF_E_NOMEM;
    *jobs = (lf_jobs){.home = *home, .events = *events, .context = context};
    *out_jobs = jobs;
    return LF_OK;
}

void lf_jobs_destroy(lf_jobs *jobs)
{
    lf_free(jobs);
}

void lf_export_finish(lf_export *what)
{
    for (int i = 0; i < what->n_fds; i++)
        close(what->fds[i]);
    if (what->folder_fd >= 0)
        close(what->folder_fd);
    lf_free(what->fds);
    lf_free(what->file);
    lf_free(what->name);
    lf_free(what->icc);
    lf_free(what->label);
    lf_free((char *)(uintptr_t)what->named.lens);
    lf_free((char *)(uintptr_t)what->named.printer);
}

bool lf_export_is_drawn(const lf_export *what)
{
    return what->kind && what->kind->is_drawn;
}

static void unlink_job(lf_job *job)
{
    lf_job **at = &job->jobs->first;
    while (*at != job)
        at = &(*at)->next;
    *at = job->next;
}

static void free_job(lf_job *job)
{
    sd_event_source_disable_unref(job->timer);
    lf_export_finish(&job->asked);
    lf_free(job->final);
    json_decref(job->account);
    lf_free(job);
}

/* -------------------------------------------------------------------------------------- told -- */

static const char *file_of(const lf_job *job)
{
    return job->asked.name ? job->asked.name : job->asked.file;
}

static lf_job_told job_told(const lf_job *job, lf_job_state state)
{
    return (lf_job_told){.id = job->id,
                         .asker = &job->asked.asker,
                         .kind = job->asked.kind ? job->asked.kind->name : "state",
                         .file = file_of(job),
                         .state = state,
                         .progress = state == LF_JOB_DONE ? 1 : job->told * 1e-3,
                         .err = state == LF_JOB_FAILED ? &job->err : NULL,
                         .account = state == LF_JOB_DONE ? job->account : NULL};
}

static void tell(const lf_job *job, lf_job_state state)
{
    const lf_job_told told = job_told(job, state);
    job->jobs->events.told(job->jobs->context, &told);
}

bool lf_jobs_at(const lf_jobs *jobs, int i, lf_job_told *out)
{
    const lf_job *job = jobs->first;
    while (job && i-- > 0)
        job = job->next;
    if (job)
        *out = job_told(job, job->started ? LF_JOB_RUNNING : LF_JOB_WAITING);
    return job;
}

/* Nobody else may hear about a detached job. */
static void log_lost(const lf_job *job)
{
    if (!job->asked.asker.detached || job->status == LF_OK)
        return;
    lf_log(LF_LOG_WARNING, "%s: the detached export (job %lld) was not written: %s", file_of(job),
           (long long)job->id, job->status == LF_E_CANCELLED ? "cancelled" : job->err.what);
}

/* ---------------------------------------------------------------------------------- the ends -- */

/* Ends a job, whatever its outcome. */
static void end_job(lf_job *job)
{
    lf_jobs *jobs = job->jobs;
    const lf_asker asker = job->asked.asker;
    unlink_job(job);
    if (job->final) {
        lf_free(job->asked.name);
        job->asked.name = job->final;
        job->final = NULL;
    }
    tell(job, job->status == LF_OK            ? LF_JOB_DONE
              : job->status == LF_E_CANCELLED ? LF_JOB_CANCELLED
                                              : LF_JOB_FAILED);
    log_lost(job);
    free_job(job);
    jobs->events.ended(jobs->context, &asker);
}

static void cancel(lf_job *job)
{
    atomic_store_explicit(&job->cancel, 1, memory_order_relaxed);
    if (!job->started) {
        job->status = LF_E_CANCELLED;
        end_job(job);
    }
}

lf_status lf_jobs_cancel(lf_jobs *jobs, int64_t id, lf_error *err)
{
    for (lf_job *job = jobs->first; job; job = job->next) {
        if (job->id == id) {
            cancel(job);
            return LF_OK;
        }
    }
    return lf_error_set_at(err, LF_E_ARG, "job.cancel", 0, "/job",
                           "there is no job %lld; status lists the jobs", (long long)id);
}

/* An export by name that has begun ends soon; its client may have left because it knows this. */
static bool ends_with_client(const lf_job *job)
{
    return !job->asked.asker.detached && (!job->started || job->asked.folder_fd < 0);
}

void lf_jobs_end_of(lf_jobs *jobs, uint64_t client)
{
    for (lf_job *job = jobs->first, *next; job; job = next) {
        next = job->next;
        if (job->asked.asker.client == client && ends_with_client(job))
            cancel(job);
    }
}

void lf_jobs_end(lf_jobs *jobs)
{
    for (lf_job *job = jobs->first, *next; job; job = next) {
        next = job->next;
        atomic_store_explicit(&job->cancel, 1, memory_order_relaxed);
        if (!job->started) {
            job->status = LF_E_CANCELLED;
            log_lost(job);
            unlink_job(job);
            free_job(job);
        }
    }
}

/* ----------------------------------------------------------------------------------- running -- */

static void *job_main(void *context)
{
    lf_job *job = context;
    lf_job_write(job);
    lf_inbox_post(job->jobs->home.inbox, &job->task);
    return NULL;
}

static void on_job_done(void *reader, lf_task *task)
{
    lf_job *job = (lf_job *)(void *)task;
    (void)reader;
    pthread_join(job->thread, NULL);
    end_job(job);
}

static int on_progress_timer(sd_event_source *source, uint64_t usec, void *context)
{
    lf_job *job = context;
    int permille = atomic_load_explicit(&job->permille, memory_order_relaxed);
    if (permille != job->told) {
        job->told = permille;
        tell(job, LF_JOB_RUNNING);
    }
    (void)sd_event_source_set_time(source, usec + PROGRESS_USEC);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

static void start(lf_job *job)
{
    job->started = true;
    job->task.done = on_job_done;
    (void)sd_event_add_time_relative(job->jobs->home.event, &job->timer, CLOCK_MONOTONIC,
                                     PROGRESS_USEC, 0, on_progress_timer, job);
    tell(job, LF_JOB_RUNNING);
    if (lf_thread_start("lf-export", job_main, job, &job->thread) != LF_OK) {
        job->status = lf_error_set(&job->err, LF_E_NOMEM, job->asked.file, "cannot start a thread");
        end_job(job);
    }
}

/* True if the picture has the level that the export waits for. */
static bool may_start(const lf_jobs *jobs, const lf_export *what)
{
    lf_engine_status now;
    if (lf_export_is_drawn(what))
        return true;
    lf_engine_get_status(jobs->home.engine, &now);
    /* If the scene has changed meanwhile, waits for the new generation. */
    return now.generation >= what->generation && now.level >= what->wait;
}

void lf_jobs_start(lf_jobs *jobs)
{
    for (lf_job *job = jobs->first, *next; job; job = next) {
        next = job->next;
        if (!job->started && may_start(jobs, &job->asked))
            start(job);
    }
}

/* ------------------------------------------------------------------------------------ adding -- */

lf_status lf_jobs_check_room(const lf_jobs *jobs, int others, lf_error *err)
{
    int n = others;
    for (const lf_job *job = jobs->first; job; job = job->next)
        n++;
    return n < MAX_JOBS
               ? LF_OK
               : lf_error_set(
                     err, LF_E_BUSY, "export",
                     "%d jobs are waiting or running already; try again when one has ended",
                     MAX_JOBS);
}

lf_status lf_jobs_check_wait(const lf_jobs *jobs, const lf_export *what, lf_error *err)
{
    int waiting = 0, detached = 0, of_client = 0;
    for (const lf_job *other = jobs->first; other; other = other->next) {
        if (other->started)
            continue;
        waiting++;
        detached += other->asked.asker.detached ? 1 : 0;
        of_client += other->asked.asker.client == what->asker.client ? 1 : 0;
    }
    if (may_start(jobs, what))
        return LF_OK;
    if (of_client >= MOST_OF_CLIENT)
        return lf_error_set(
            err, LF_E_BUSY, "export",
            "%d exports of this client are waiting already; end one with job.cancel",
            MOST_OF_CLIENT);
    if (what->asker.detached && detached >= MOST_DETACHED)
        return lf_error_set(err, LF_E_BUSY, "export",
                            "%d detached exports are waiting already; end one with job.cancel",
                            MOST_DETACHED);
    if (waiting >= MOST_WAITING)
        return lf_error_set(err, LF_E_BUSY, "export",
                            "%d exports are waiting already; try again when one has ended",
                            MOST_WAITING);
    return LF_OK;
}

lf_status lf_jobs_add(lf_jobs *jobs, int64_t id, const lf_export *what, lf_error *err)
{
    lf_job *job = lf_calloc(1, sizeof *job);
    if (!job)
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    job->jobs = jobs;
    job->id = id;
    job->asked = *what;
    job->next = jobs->first;
    jobs->first = job;
    return LF_OK;
}
