/* Exports. A job waits (on the event thread) until the picture is as good as was asked for, then runs on a thread of its own: it
 * takes a snapshot from the engine between two slices and writes it while rendering goes on. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/syscall.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server.h"

#define MAX_JOBS 8
#define PROGRESS_USEC 250000
#define STATE_NAME "film.lfstate"
#define STATE_ENDING ".lfstate"
/* How long systemd is asked to wait for the last save. */
#define SAVE_MORE_USEC 30000000

struct lf_job {
    lf_letter letter;
    lf_job *next;
    lf_server *server;
    int64_t id;
    uint64_t client; /* who asked; hears of it without subscribing. 0 = the daemon itself */
    bool is_state;   /* kind "state" */
    lf_output_kind kind;
    char *file;    /* as asked for, canonical */
    char *final;   /* name written; the thread's until it has ended */
    int folder_fd; /* of file: what was checked is what is written to; -1 = none */
    bool overwrite;
    int64_t generation; /* what to wait for … */
    lf_level wait;
    bool started;
    lf_cancel cancel;
    pthread_t thread;
    lf_filter filter;
    lf_invert invert;
    bool has_calibration;
    lf_calibration calibration;
    lf_print print;
    char *icc;
    int *fds;
    int n_fds;
    atomic_int permille;
    int told; /* progress told last, in permille */
    lf_status status;
    lf_error err;
    sd_event_source *timer;
};

static void free_job(lf_job *job)
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
        status = lf_engine_save(job->server->engine, &file, &job->err);
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
    pthread_setname_np(pthread_self(), "lf-export");
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
    free_job(job);
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

static void start(lf_job *job)
{
    sigset_t all, before;
    sigfillset(&all);
    job->started = true;
    job->letter.open = on_job_done;
    if (job->client != 0) {
        (void)sd_event_add_time_relative(job->server->event, &job->timer, CLOCK_MONOTONIC, PROGRESS_USEC, 0, on_progress_timer,
                                         job);
        tell(job, job_json(job, "running"));
    }
    pthread_sigmask(SIG_BLOCK, &all, &before);
    bool ok = pthread_create(&job->thread, NULL, job_main, job) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!ok) {
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
            start(job);
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
            free_job(job);
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

/* ----------------------------------------------------------------------------------------------- from a call's words -- */

static const char *string_of(const json_t *params, const char *key)
{
    return json_string_value(json_object_get(params, key));
}

static double number_of(const json_t *params, const char *key, double absent)
{
    const json_t *value = json_object_get(params, key);
    return value != NULL ? json_number_value(value) : absent;
}

static lf_status take_panel_words(lf_job *job, const json_t *params, lf_error *err)
{
    const lf_panel *panel = &job->server->panel;
    const char *filter = string_of(params, "filter"), *invert = string_of(params, "invert");
    lf_status status = filter != NULL ? lf_filter_from_name(filter, &job->filter, err) : LF_OK;
    if (status == LF_OK && invert != NULL) {
        status = lf_invert_from_name(invert, &job->invert, err);
    }
    if (status == LF_OK && !panel->has_calibration) {
        return lf_error_set(err, LF_E_NODEV, panel->spec, "there is no panel whose calibration is known");
    }
    job->has_calibration = true;
    job->calibration = panel->calibration;
    return status;
}

static lf_status take_print_names(lf_job *job, const json_t *params, lf_error *err)
{
    lf_print *print = &job->print;
    const char *stripes = string_of(params, "stripes"), *compress = string_of(params, "compress");
    const char *icc = string_of(params, "icc"), *orientation = string_of(params, "orientation");
    lf_status status = stripes != NULL ? lf_stripes_from_name(stripes, &print->stripes, err) : LF_OK;
    if (status == LF_OK && compress != NULL) {
        status = lf_compress_from_name(compress, &print->compress, err);
    }
    if (status == LF_OK && icc != NULL) {
        status = lf_server_read_path(job->server, icc, &job->icc, err);
    }
    print->horizontal = orientation != NULL && strcmp(orientation, "horizontal") == 0;
    print->icc_path = job->icc;
    print->icc_roots = &job->server->roots;
    return status;
}

static lf_status take_print_words(lf_job *job, const json_t *params, lf_error *err)
{
    static const char *const needed[] = {"lpi", "width", "height"};
    for (int i = 0; i < 3; i++) {
        if (json_object_get(params, needed[i]) == NULL) {
            return lf_error_set(err, LF_E_ARG, "export", "a print needs lpi, width and height (mm); \"%s\" is missing", needed[i]);
        }
    }
    lf_print *print = &job->print;
    *print = (lf_print){
        .lpi = number_of(params, "lpi", 0),
        .dpi = (int)number_of(params, "dpi", 600),
        .width_mm = number_of(params, "width", 0),
        .height_mm = number_of(params, "height", 0),
        .bleed_mm = number_of(params, "bleed", 0),
        .phase_mm = number_of(params, "phase", 0),
        .bits = (int)number_of(params, "bits", 8),
        .reverse = json_is_true(json_object_get(params, "reverse")),
        .mirror = json_is_true(json_object_get(params, "mirror")),
    };
    int most = job->server->stage->layout.n_views;
    print->n_views = (int)fmax(1, fmin(floor(print->dpi / print->lpi + 1e-9), most));
    print->n_views = (int)number_of(params, "views", print->n_views);
    if (print->n_views > most) {
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/views", "there are only %d views", most);
    }
    lf_status status = take_print_names(job, params, err);
    return status == LF_OK ? lf_print_check(print, NULL, err) : status;
}

static lf_status take_fds(lf_job *job, lf_client *client, int n, lf_error *err)
{
    if (n == 0) {
        return LF_OK;
    }
    job->fds = lf_calloc((size_t)n, sizeof *job->fds);
    if (job->fds == NULL) {
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    }
    if (!lf_client_take_fds(client, job->fds, n)) {
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/fds", "fewer than %d descriptors came with the call", n);
    }
    job->n_fds = n;
    return LF_OK;
}

static bool ends_with(const char *text, const char *ending)
{
    size_t n = strlen(text), m = strlen(ending);
    return n > m && strcmp(text + n - m, ending) == 0;
}

/* The folder of a name that lies beneath --export-dir, without following a link that was put there since. */
static lf_status hold_folder(lf_job *job, lf_error *err)
{
    const char *root = job->server->export_root;
    char folder[PATH_MAX];
    size_t n = strlen(job->file);
    snprintf(folder, sizeof folder, "%s", job->file);
    while (n > 1 && n < sizeof folder && folder[n - 1] == '/') {
        folder[--n] = '\0';
    }
    char *slash = strrchr(folder, '/');
    slash[slash == folder ? 1 : 0] = '\0';
    const char *relative = folder + strlen(root);
    relative += strspn(relative, "/");
    struct open_how how = {.flags = O_PATH | O_DIRECTORY | O_CLOEXEC, .resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS};
    int root_fd = open(root, O_PATH | O_DIRECTORY | O_CLOEXEC);
    job->folder_fd = (int)syscall(SYS_openat2, root_fd, relative[0] != '\0' ? relative : ".", &how, sizeof how);
    if (job->folder_fd < 0 && (errno == ENOSYS || errno == EPERM)) {
        job->folder_fd = open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
    }
    if (root_fd >= 0) {
        close(root_fd);
    }
    return job->folder_fd >= 0 ? LF_OK : lf_error_set(err, LF_E_PATH, job->file, "its folder cannot be opened beneath %s", root);
}

/* The name: beneath --export-dir, or with descriptors just a name, whose ending tells the format. */
static lf_status take_file(lf_job *job, const char *file, lf_error *err)
{
    if (job->is_state && !ends_with(file, STATE_ENDING)) {
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/file", "a state's name must end in " STATE_ENDING);
    }
    if (job->n_fds == 0) {
        lf_status status = lf_server_write_path(job->server, file, &job->file, err);
        status = status == LF_OK ? hold_folder(job, err) : status;
        if (status != LF_OK) {
            return status;
        }
    } else {
        job->file = lf_strdup(file);
    }
    if (job->file == NULL) {
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    }
    if (job->is_state) {
        return LF_OK;
    }
    char *path = NULL;
    lf_status status = lf_output_path(job->kind, job->file, &job->server->stage->layout, &path, err);
    lf_free(path);
    return status;
}

/* An accumulation is one from its first pass on; a picture, once it is coarse. */
static lf_level wait_of(const json_t *params, bool is_state)
{
    const char *name = string_of(params, "wait");
    for (lf_level level = LF_LEVEL_COARSE; name != NULL && level <= LF_LEVEL_CONVERGED; level++) {
        if (strcmp(name, lf_level_name(level)) == 0) {
            return level;
        }
    }
    return is_state ? LF_LEVEL_NONE : LF_LEVEL_COARSE;
}

static lf_status take_words(lf_job *job, lf_call *call, lf_error *err)
{
    const lf_server *server = call->server;
    const json_t *params = call->params;
    const char *kind = string_of(params, "kind");
    job->is_state = strcmp(kind, "state") == 0;
    job->overwrite = json_is_true(json_object_get(params, "overwrite"));
    job->wait = wait_of(params, job->is_state);
    job->generation = server->generation;
    int n_fds = (int)number_of(params, "fds", 0);
    if (job->is_state && n_fds > 1) {
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/fds", "a state is one file: one descriptor, not %d", n_fds);
    }
    lf_status status = take_fds(job, call->client, n_fds, err);
    if (status == LF_OK && (server->stage == NULL || (job->is_state && server->stage->scene == NULL))) {
        return lf_error_set(err, LF_E_STATE, "export", "there is no picture to export");
    }
    if (status == LF_OK && !job->is_state) {
        status = lf_output_kind_from_name(kind, &job->kind, err);
    }
    if (status == LF_OK) {
        status = take_file(job, string_of(params, "file"), err);
    }
    if (status == LF_OK && !job->is_state && job->kind == LF_OUTPUT_PANEL) {
        status = take_panel_words(job, params, err);
    }
    if (status == LF_OK && !job->is_state && job->kind == LF_OUTPUT_PRINT) {
        status = take_print_words(job, params, err);
    }
    return status;
}

static int count_jobs(const lf_server *server)
{
    int n = 0;
    for (const lf_job *job = server->jobs; job != NULL; job = job->next) {
        n++;
    }
    return n;
}

void lf_server_export(lf_call *call)
{
    lf_server *server = call->server;
    lf_error err;
    lf_job *job = count_jobs(server) < MAX_JOBS ? lf_calloc(1, sizeof *job) : NULL;
    if (job == NULL) {
        (void)lf_error_set(&err, LF_E_BUSY, "export", "%d jobs are waiting or running", MAX_JOBS);
        lf_client_drop_fds(call->client);
        lf_fail(call, &err, false);
        return;
    }
    job->server = server;
    job->folder_fd = -1;
    job->client = lf_client_serial(call->client);
    lf_status status = take_words(job, call, &err);
    if (status != LF_OK) {
        free_job(job);
        lf_client_drop_fds(call->client);
        lf_fail(call, &err, false);
        return;
    }
    lf_client_drop_fds(call->client); /* more came than were announced */
    job->id = ++server->n_jobs;
    job->next = server->jobs;
    server->jobs = job;
    lf_reply(call, json_pack("{s:I, s:s}", "job", (json_int_t)job->id, "file", job->file));
    lf_server_start_jobs(server);
}

/* ------------------------------------------------------------------------------------------------------------ state -- */

static char *state_path(const lf_server *server)
{
    return lf_path_join(server->config.state_dir, STATE_NAME);
}

int lf_server_open_state(const lf_server *server)
{
    char *path = server->config.state_dir != NULL ? state_path(server) : NULL;
    int fd = -1;
    lf_error err;
    if (path != NULL && access(path, F_OK) == 0 && lf_file_open(path, NULL, UINT64_MAX, &fd, NULL, &err) != LF_OK) {
        lf_log(LF_LOG_INFO, "the saved state is left aside: %s", err.what);
        fd = -1;
    }
    lf_free(path);
    return fd;
}

void lf_server_save_state(lf_server *server)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    bool news = now.generation != server->saved_generation || now.passes > server->saved_passes;
    if (server->saving || server->stopping || server->stage == NULL || server->stage->scene == NULL || !news) {
        return;
    }
    lf_job *job = lf_calloc(1, sizeof *job);
    if (job == NULL) {
        return;
    }
    job->server = server;
    job->folder_fd = -1;
    job->is_state = job->overwrite = true;
    job->file = state_path(server);
    if (job->file == NULL) {
        free_job(job);
        return;
    }
    job->next = server->jobs;
    server->jobs = job;
    server->saving = true;
    server->saved_generation = now.generation;
    server->saved_passes = now.passes;
    start(job);
}

void lf_server_save_state_now(lf_server *server)
{
    char *path = server->config.state_dir != NULL ? state_path(server) : NULL;
    lf_outfile file = {.fd = -1};
    lf_error err;
    if (path == NULL || server->stage == NULL || server->stage->scene == NULL) {
        lf_free(path);
        return;
    }
    sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d\nSTATUS=saving the accumulation", SAVE_MORE_USEC);
    lf_status status = lf_outfile_open(&file, path, true, &err);
    if (status == LF_OK) {
        status = lf_engine_save(server->engine, &file, &err);
    }
    if (status == LF_OK) {
        status = lf_outfile_commit(&file, true, &err);
    } else {
        lf_outfile_abandon(&file);
    }
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    if (status != LF_OK && (status != LF_E_STATE || now.passes > 0)) {
        lf_log(LF_LOG_ERROR, "the accumulation is not saved: %s", err.what);
    }
    lf_free(path);
}
