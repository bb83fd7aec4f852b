/* Exports. A job waits (on the event thread) until the picture is as good as was asked for, then
 * runs on a thread of its own: it takes a snapshot from the engine between two batches and writes
 * it while rendering goes on. */
#include "daemon/server/server_job.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"

#define PROGRESS_USEC 250000

void job_free(lf_job *job)
{
    for (int i = 0; i < job->n_fds; i++)
        close(job->fds[i]);
    if (job->folder_fd >= 0)
        close(job->folder_fd);
    sd_event_source_disable_unref(job->timer);
    lf_free(job->fds);
    lf_free(job->file);
    lf_free(job->name);
    lf_free(job->final);
    lf_free(job->icc);
    lf_free(job);
}

lf_job *job_create(lf_server *server)
{
    lf_job *job = lf_calloc(1, sizeof *job);
    if (job) {
        job->server = server;
        job->folder_fd = -1;
    }
    return job;
}

void job_list(lf_job *job)
{
    job->next = job->server->jobs;
    job->server->jobs = job;
}

/* ----------------------------------------------------------------------------- on its thread -- */

static void on_progress(void *context, double fraction)
{
    lf_job *job = context;
    atomic_store_explicit(&job->permille, (int)(fraction * 1000), memory_order_relaxed);
}

/* The last part of a path, without slashes at its end. Caller frees; NULL = out of memory. */
static char *last_part(const char *path)
{
    size_t n = strlen(path);
    while (n > 1 && path[n - 1] == '/')
        n--;
    size_t at = n;
    while (at > 0 && path[at - 1] != '/')
        at--;
    char *part = lf_calloc(n - at + 1, 1);
    return part ? memcpy(part, path + at, n - at) : NULL;
}

/* Where it is written: the folder's name, and that of a folder of views, may lead elsewhere by
 * now. */
typedef struct destination {
    char *path;       /* to be written */
    const char *told; /* what errors call it */
    char *name;       /* in the folder that is held */
    int views_fd;
    bool made; /* the folder of views */
} destination;

static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* Errors name the folder that was asked for, not the one that is held. */
static void tell_asked_for(lf_error *err, const char *held, const char *asked)
{
    size_t n = folder_length(held);
    char where[sizeof err->where];
    if (strncmp(err->where, held, n) != 0)
        return;
    if (snprintf(where, sizeof where, "%.*s%s", (int)folder_length(asked), asked, err->where + n) >
        0)
        memcpy(err->where, where, sizeof where);
}

static void destination_finish(lf_job *job, destination *d, lf_status status)
{
    if (d->path && status != LF_OK)
        tell_asked_for(&job->err, d->path, d->told);
    if (d->views_fd >= 0)
        close(d->views_fd);
    if (d->made && d->name && status != LF_OK)
        unlinkat(job->folder_fd, d->name, AT_REMOVEDIR);
    lf_free(d->path);
    lf_free(d->name);
}

static lf_status destination_init(lf_job *job, const char *path, destination *out)
{
    destination d = {.told = path, .name = last_part(path), .views_fd = -1};
    bool views = path[0] != '\0' && path[strlen(path) - 1] == '/';
    lf_status status = LF_OK;
    if (d.name && job->folder_fd >= 0 && views)
        status = lf_held_folder(job->folder_fd, d.name, &d.views_fd, &d.made, &job->err);
    if (d.name && status == LF_OK) {
        d.path = job->folder_fd < 0 ? lf_strdup(path)
                 : views            ? lf_held_path(d.views_fd, "")
                                    : lf_held_path(job->folder_fd, d.name);
    }
    if (status == LF_OK && !d.path)
        status = lf_error_set(&job->err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK)
        *out = d;
    else
        destination_finish(job, &d, status);
    return status;
}

/* snapshot NULL: of a kind that is drawn. */
static lf_status write_snapshot(lf_job *job, const lf_snapshot *snapshot)
{
    static const lf_content nothing;
    const lf_content *content = snapshot ? snapshot->content : &nothing;
    /* The picture may have changed since the call: the name is settled again. */
    lf_status status =
        lf_output_path(job->kind, job->file, &content->layout, &job->final, &job->err);
    if (status != LF_OK)
        return status;
    destination to;
    status = destination_init(job, job->final, &to);
    if (status != LF_OK)
        return status;
    json_t *settings = NULL;
    if (snapshot && content->scene)
        settings = lf_output_settings(content->file, &content->settings, &content->layout,
                                      snapshot->estimator, snapshot->reconstructed,
                                      snapshot->stats.passes, &snapshot->shown_as);
    lf_output_request request = {
        .kind = job->kind,
        .path = to.path,
        .overwrite = job->overwrite,
        .fds = job->fds,
        .n_fds = job->n_fds,
        .layout = content->layout,
        .calibration = job->has_calibration ? &job->calibration : NULL,
        .panel = job->panel,
        .print = &job->print,
        .rgbd = job->rgbd,
        .exposure = snapshot ? snapshot->shown_as.exposure : 0,
        .tonemap = snapshot ? snapshot->shown_as.tonemap : NULL,
        .settings = settings,
        .cancel = &job->cancel,
        .progress = on_progress,
        .context = job,
    };
    job->n_fds = 0; /* taken over whatever comes of it */
    status = lf_output_write(&request, snapshot ? &snapshot->source : NULL, &job->err);
    json_decref(settings);
    destination_finish(job, &to, status);
    return status;
}

static lf_status write_state(lf_job *job)
{
    lf_outfile file = {.fd = -1};
    destination to = {.views_fd = -1};
    lf_status status;
    if (job->n_fds > 0) {
        status = lf_outfile_adopt(&file, job->fds[0], &job->err);
        job->n_fds = status == LF_OK ? 0 : job->n_fds;
    } else {
        status = destination_init(job, job->file, &to);
        if (status == LF_OK)
            status = lf_outfile_open(&file, to.path, job->overwrite, &job->err);
    }
    if (status == LF_OK) {
        status = lf_engine_save(job->server->engine, &file, &job->err);
        if (status == LF_OK)
            status = lf_outfile_commit(&file, job->overwrite, &job->err);
        else
            lf_outfile_abandon(&file);
    }
    destination_finish(job, &to, status);
    return status;
}

/* Errors of descriptors name the file that the client means by them. */
static void tell_meant(lf_job *job)
{
    if (strcmp(job->err.where, "descriptor") == 0)
        (void)snprintf(job->err.where, sizeof job->err.where, "%s", job->file);
}

static void *job_main(void *context)
{
    lf_job *job = context;
    bool has_fds = job->n_fds > 0;
    if (job->asker.client == 0) {
        job->status = lf_engine_keep(job->server->engine, &job->err);
    } else if (!job->kind) {
        job->status = write_state(job);
    } else if (job_is_drawn(job)) {
        job->status = write_snapshot(job, NULL);
    } else {
        lf_snapshot snapshot;
        job->status = lf_engine_snapshot(job->server->engine, job->reconstruct, job->kind->layers,
                                         &snapshot, &job->err);
        if (job->status == LF_OK)
            job->status = write_snapshot(job, &snapshot);
        lf_snapshot_finish(&snapshot);
    }
    if (has_fds && job->status != LF_OK)
        tell_meant(job);
    lf_inbox_post(&job->server->inbox, &job->task);
    return NULL;
}

/* ----------------------------------------------------------------------- on the event thread -- */

static const char *kind_name(const lf_job *job)
{
    return job->kind ? job->kind->name : "state";
}

static json_t *job_json(const lf_job *job, const char *state)
{
    return json_pack("{s:I, s:s, s:o, s:s, s:f}", "job", (json_int_t)job->id, "kind",
                     kind_name(job), "file", lf_rpc_text(job->name ? job->name : job->file),
                     "state", state, "progress",
                     strcmp(state, "done") == 0 ? 1.0 : job->told * 1e-3);
}

/* Tells the one who asked and those who subscribed; params are taken over. */
static void tell(const lf_job *job, json_t *params)
{
    lf_server *server = job->server;
    lf_client *client =
        job->asker.client != 0 ? lf_clients_find(server->clients, job->asker.client) : NULL;
    if (client && (*lf_client_flags(client) & LF_EVENT_EXPORT) == 0)
        lf_client_send(client, lf_rpc_notification("export", json_incref(params)));
    lf_server_notify(server, LF_EVENT_EXPORT, "export", params);
}

static void unlink_job(lf_job *job)
{
    lf_job **at = &job->server->jobs;
    while (*at != job)
        at = &(*at)->next;
    *at = job->next;
}

static void release_client(lf_job *job)
{
    if (job->asker.holds)
        lf_clients_release(job->server->clients, job->asker.client, job->asker.bytes);
}

/* Of a detached job nobody else may hear. */
static void log_lost(const lf_job *job)
{
    if (!job->asker.detached || job->status == LF_OK)
        return;
    lf_log(LF_LOG_WARNING, "%s: the detached export (job %lld) was not written: %s",
           job->name ? job->name : job->file, (long long)job->id,
           job->status == LF_E_CANCELLED ? "cancelled" : job->err.what);
}

/* The job's end, whichever way it came. */
static void end_job(lf_job *job)
{
    lf_server *server = job->server;
    unlink_job(job);
    if (job->final) {
        lf_free(job->name);
        job->name = job->final;
        job->final = NULL;
    }
    if (job->asker.client != 0) {
        const char *state = job->status == LF_OK            ? "done"
                            : job->status == LF_E_CANCELLED ? "cancelled"
                                                            : "failed";
        json_t *params = job_json(job, state);
        if (job->status != LF_OK && job->status != LF_E_CANCELLED) {
            json_t *answer = lf_rpc_error_of(NULL, &job->err, false);
            json_object_set(params, "error", json_object_get(answer, "error"));
            json_decref(answer);
        }
        tell(job, params);
        log_lost(job);
        release_client(job);
    } else {
        lf_server_state_saved(server, job->status);
        if (job->status != LF_OK && job->status != LF_E_CANCELLED && job->status != LF_E_STATE)
            lf_log_error(&job->err);
    }
    job_free(job);
    if (lf_server_is_stopping(server))
        lf_server_shutdown(server);
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
        tell(job, job_json(job, "running"));
    }
    (void)sd_event_source_set_time(source, usec + PROGRESS_USEC);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

void job_start(lf_job *job)
{
    job->started = true;
    job->task.done = on_job_done;
    if (job->asker.client != 0) {
        (void)sd_event_add_time_relative(job->server->event, &job->timer, CLOCK_MONOTONIC,
                                         PROGRESS_USEC, 0, on_progress_timer, job);
        tell(job, job_json(job, "running"));
    }
    if (lf_thread_start("lf-export", job_main, job, &job->thread) != LF_OK) {
        job->status = lf_error_set(&job->err, LF_E_NOMEM, job->file, "cannot start a thread");
        end_job(job);
    }
}

bool job_may_start(const lf_job *job)
{
    lf_engine_status now;
    if (job_is_drawn(job))
        return true;
    lf_engine_get_status(job->server->engine, &now);
    /* A scene that moves meanwhile is waited for again. */
    return now.generation >= job->generation && now.level >= job->wait;
}

void lf_server_start_jobs(lf_server *server)
{
    for (lf_job *job = server->jobs, *next; job; job = next) {
        next = job->next;
        if (!job->started && job_may_start(job))
            job_start(job);
    }
}

static void cancel(lf_job *job)
{
    atomic_store_explicit(&job->cancel, 1, memory_order_relaxed);
    if (!job->started) {
        job->status = LF_E_CANCELLED;
        end_job(job);
    }
}

lf_status lf_server_cancel_job(lf_server *server, int64_t id, lf_error *err)
{
    for (lf_job *job = server->jobs; job; job = job->next) {
        if (job->id == id && job->asker.client != 0) {
            cancel(job);
            return LF_OK;
        }
    }
    return lf_error_set_at(err, LF_E_ARG, "job.cancel", 0, "/job", "there is no job %lld",
                           (long long)id);
}

/* What is written by name has begun, and ends soon: the client may have left because it knows. */
static bool ends_with_client(const lf_job *job)
{
    return !job->asker.detached && (!job->started || job->folder_fd < 0);
}

void lf_server_end_jobs_of(lf_server *server, uint64_t client)
{
    for (lf_job *job = server->jobs, *next; job; job = next) {
        next = job->next;
        if (job->asker.client == client && ends_with_client(job))
            cancel(job);
    }
}

bool lf_server_end_jobs(lf_server *server)
{
    for (lf_job *job = server->jobs, *next; job; job = next) {
        next = job->next;
        atomic_store_explicit(&job->cancel, 1, memory_order_relaxed);
        if (!job->started) {
            job->status = LF_E_CANCELLED;
            log_lost(job);
            unlink_job(job);
            job_free(job);
        }
    }
    return !server->jobs;
}

json_t *lf_server_jobs_json(const lf_server *server)
{
    json_t *list = json_array();
    for (const lf_job *job = server->jobs; job; job = job->next)
        if (job->asker.client != 0)
            json_array_append_new(list, job_json(job, job->started ? "running" : "waiting"));
    return list;
}
