/* Exports. A job waits (on the event thread) until the picture is as good as was asked for, then runs on a thread of its own: it
 * takes a snapshot from the engine between two batches and writes it while rendering goes on. */
#include "daemon/server_job.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"

#define PROGRESS_USEC 250000

void job_free(lf_job *job)
{
    for (int i = 0; i < job->n_fds; i++) {
        close(job->fds[i]);
    }
    if (job->folder_fd >= 0) {
        close(job->folder_fd);
    }
    sd_event_source_disable_unref(job->timer);
    lf_free(job->fds);
    lf_free(job->file);
    lf_free(job->final);
    lf_free(job->icc);
    lf_free(job);
}

lf_job *job_create(lf_server *server)
{
    lf_job *job = lf_calloc(1, sizeof *job);
    if (job != NULL) {
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

/* --------------------------------------------------------------------------------------------------- on its thread -- */

static void on_progress(void *context, double fraction)
{
    lf_job *job = context;
    atomic_store_explicit(&job->permille, (int)(fraction * 1000), memory_order_relaxed);
}

/* path by way of the folder that is held: the folder's name may lead elsewhere by now. Caller frees; NULL = out of memory. */
static char *held_path(const lf_job *job, const char *path)
{
    size_t n = strlen(path);
    while (n > 1 && path[n - 1] == '/') {
        n--;
    }
    while (n > 0 && path[n - 1] != '/') {
        n--;
    }
    char folder[64];
    snprintf(folder, sizeof folder, "/proc/self/fd/%d", job->folder_fd);
    return job->folder_fd >= 0 ? lf_path_join(folder, path + n) : lf_strdup(path);
}

static lf_status write_snapshot(lf_job *job, const lf_snapshot *snapshot)
{
    const lf_stage *stage = snapshot->stage;
    /* The picture may have changed since the call: the name is settled again. */
    lf_status status = lf_output_path(job->kind, job->file, &stage->layout, &job->final, &job->err);
    if (status != LF_OK) {
        return status;
    }
    char *path = held_path(job, job->final);
    if (path == NULL) {
        return lf_error_set(&job->err, LF_E_NOMEM, job->final, "out of memory");
    }
    json_t *settings = NULL;
    if (stage->scene != NULL) {
        settings = lf_output_settings(stage->file, &stage->settings, &stage->layout, snapshot->estimator, snapshot->stats.passes,
                                      &stage->film);
    }
    lf_output_request request = {
        .kind = job->kind,
        .path = path,
        .overwrite = job->overwrite,
        .fds = job->fds,
        .n_fds = job->n_fds,
        .layout = stage->layout,
        .calibration = job->has_calibration ? &job->calibration : NULL,
        .filter = job->filter,
        .invert = job->invert,
        .print = &job->print,
        .exposure = stage->film.exposure,
        .tonemap = stage->film.tonemap,
        .settings = settings,
        .cancel = &job->cancel,
        .progress = on_progress,
        .context = job,
    };
    job->n_fds = 0; /* taken over whatever comes of it */
    status = lf_output_write(&request, &snapshot->source, &job->err);
    json_decref(settings);
    if (status != LF_OK && strncmp(job->err.where, path, strlen(path)) == 0) {
        snprintf(job->err.where, sizeof job->err.where, "%s", job->final);
    }
    lf_free(path);
    return status;
}

static lf_status write_state(lf_job *job)
{
    lf_outfile file = {.fd = -1};
    lf_status status;
    if (job->n_fds > 0) {
        status = lf_outfile_adopt(&file, job->fds[0], &job->err);
        job->n_fds = status == LF_OK ? 0 : job->n_fds;
    } else {
        char *path = held_path(job, job->file);
        status = path != NULL ? lf_outfile_open(&file, path, job->overwrite, &job->err)
                              : lf_error_set(&job->err, LF_E_NOMEM, job->file, "out of memory");
        lf_free(path);
    }
    if (status == LF_OK) {
        status = lf_engine_save(job->server->engine, &file, job->client == 0, &job->err);
        if (status == LF_OK) {
            status = lf_outfile_commit(&file, job->overwrite, &job->err);
        } else {
            lf_outfile_abandon(&file);
        }
    }
    return status;
}

static void *job_main(void *context)
{
    lf_job *job = context;
    if (job->is_state) {
        job->status = write_state(job);
    } else {
        lf_snapshot snapshot;
        job->status = lf_engine_snapshot(job->server->engine, &snapshot, &job->err);
        if (job->status == LF_OK) {
            job->status = write_snapshot(job, &snapshot);
        }
        lf_snapshot_finish(&snapshot);
    }
    lf_inbox_post(&job->server->inbox, &job->letter);
    return NULL;
}

/* ----------------------------------------------------------------------------------------------- on the event thread -- */

static const char *kind_name(const lf_job *job)
{
    return job->is_state ? "state" : lf_output_kind_name(job->kind);
}

static json_t *job_json(const lf_job *job, const char *state)
{
    return json_pack("{s:I, s:s, s:o, s:s, s:f}", "job", (json_int_t)job->id, "kind", kind_name(job), "file",
                     lf_rpc_text(job->file), "state", state, "progress", strcmp(state, "done") == 0 ? 1.0 : job->told * 1e-3);
}

/* Tells the one who asked and those who subscribed; params are taken over. */
static void tell(const lf_job *job, json_t *params)
{
    lf_server *server = job->server;
    lf_client *client = job->client != 0 ? lf_clients_find(server->clients, job->client) : NULL;
    if (client != NULL && (*lf_client_flags(client) & LF_EVENT_EXPORT) == 0) {
        lf_client_send(client, lf_rpc_notification("export", json_incref(params)));
    }
    lf_server_notify(server, LF_EVENT_EXPORT, "export", params);
}

static void unlink_job(lf_job *job)
{
    lf_job **at = &job->server->jobs;
    while (*at != job) {
        at = &(*at)->next;
    }
    *at = job->next;
}

/* The job's end, whichever way it came. */
static void end_job(lf_job *job)
{
    lf_server *server = job->server;
    unlink_job(job);
    if (job->final != NULL) {
        lf_free(job->file);
        job->file = job->final;
        job->final = NULL;
    }
    if (job->client != 0) {
        const char *state = job->status == LF_OK ? "done" : job->status == LF_E_CANCELLED ? "cancelled" : "failed";
        json_t *params = job_json(job, state);
        if (job->status != LF_OK && job->status != LF_E_CANCELLED) {
            json_t *answer = lf_rpc_error_of(NULL, &job->err, false);
            json_object_set(params, "error", json_object_get(answer, "error"));
            json_decref(answer);
        }
        tell(job, params);
    } else {
        server->saving = false;
        server->saved_passes = job->status == LF_OK ? server->saved_passes : 0;
        if (job->status != LF_OK && job->status != LF_E_CANCELLED && job->status != LF_E_STATE) {
            lf_log_error(&job->err);
        }
    }
    job_free(job);
    if (server->stopping) {
        lf_server_shutdown(server);
    }
}

static void on_job_done(void *reader, lf_letter *letter)
{
    lf_job *job = (lf_job *)(void *)letter;
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
    job->letter.open = on_job_done;
    if (job->client != 0) {
        (void)sd_event_add_time_relative(job->server->event, &job->timer, CLOCK_MONOTONIC, PROGRESS_USEC, 0, on_progress_timer,
                                         job);
        tell(job, job_json(job, "running"));
    }
    if (lf_thread_start("lf-export", job_main, job, &job->thread) != LF_OK) {
        job->status = lf_error_set(&job->err, LF_E_NOMEM, job->file, "cannot start a thread");
        end_job(job);
    }
}

static bool may_start(const lf_server *server, const lf_job *job)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    /* A scene that moves meanwhile is waited for again. */
    return now.generation >= job->generation && now.level >= job->wait;
}

void lf_server_start_jobs(lf_server *server)
{
    for (lf_job *job = server->jobs, *next; job != NULL; job = next) {
        next = job->next;
        if (!job->started && may_start(server, job)) {
            job_start(job);
        }
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
    for (lf_job *job = server->jobs; job != NULL; job = job->next) {
        if (job->id == id && job->client != 0) {
            cancel(job);
            return LF_OK;
        }
    }
    return lf_error_set_at(err, LF_E_ARG, "job.cancel", 0, "/job", "there is no job %lld", (long long)id);
}

bool lf_server_end_jobs(lf_server *server)
{
    for (lf_job *job = server->jobs, *next; job != NULL; job = next) {
        next = job->next;
        atomic_store_explicit(&job->cancel, 1, memory_order_relaxed);
        if (!job->started) {
            unlink_job(job);
            job_free(job);
        }
    }
    return server->jobs == NULL;
}

json_t *lf_server_jobs_json(const lf_server *server)
{
    json_t *list = json_array();
    for (const lf_job *job = server->jobs; job != NULL; job = job->next) {
        if (job->client != 0) {
            json_array_append_new(list, job_json(job, job->started ? "running" : "waiting"));
        }
    }
    return list;
}
