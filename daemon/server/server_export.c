/* What a call's words say about an export: a job, checked as far as it can be before anything is
 * written. */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/server/server_job.h"

#define MAX_JOBS 8
/* Of those that wait: of all, so that others are never kept out by them; without their clients; and
 * of one client. */
#define MOST_WAITING 6
#define MOST_DETACHED 4
#define MOST_OF_CLIENT 2
#define STATE_ENDING ".lfstate"

static const char *string_of(const json_t *params, const char *key)
{
    return json_string_value(json_object_get(params, key));
}

static double number_of(const json_t *params, const char *key, double absent)
{
    const json_t *value = json_object_get(params, key);
    return value ? json_number_value(value) : absent;
}

static lf_status take_panel_words(lf_job *job, const json_t *params, lf_error *err)
{
    const lf_calibration *calibration = lf_show_calibration(job->server->show);
    job->panel.response = job->server->response; /* what the panel gets, but for what is said */
    lf_status status = lf_param_from_json(lf_panel_params, params, &job->panel, "export", err);
    if (status == LF_OK)
        status =
            lf_param_from_json(lf_response_params, params, &job->panel.response, "export", err);
    if (status == LF_OK && !calibration)
        return lf_error_set(err, LF_E_NODEV, lf_show_spec(job->server->show),
                            "there is no panel whose calibration is known");
    if (status == LF_OK) {
        job->has_calibration = true;
        job->calibration = *calibration;
    }
    return status;
}

static lf_status take_print_words(lf_job *job, const json_t *params, lf_error *err)
{
    lf_print *print = &job->print;
    const char *missing = lf_param_missing(lf_print_params, params);
    if (missing)
        return lf_error_set(err, LF_E_ARG, "export", "%s needs %s; \"%s\" is missing",
                            job->kind->what, job->kind->asks, missing);
    lf_param_defaults(lf_print_params, print);
    print->photo = job->server->options.photo;
    lf_status status = lf_param_from_json(lf_print_params, params, print, "export", err);
    if (status == LF_OK)
        status = lf_param_from_json(lf_photo_params, params, &print->photo, "export", err);
    if (status == LF_OK && !job->kind->is_drawn)
        status = lf_print_choose_views(print, job->server->content->layout.n_views, "export",
                                       "/views", err);
    if (status == LF_OK && print->icc_path)
        status = lf_server_read_path(job->server, print->icc_path, &job->icc, err);
    print->icc_path = job->icc;
    print->icc_roots = &job->server->roots;
    if (status == LF_OK)
        status = job->kind->check_print(print, NULL, err);
    return status;
}

static lf_status take_rgbd_words(lf_job *job, const json_t *params, lf_error *err)
{
    lf_status status = lf_param_from_json(lf_rgbd_params, params, &job->rgbd, "export", err);
    return status == LF_OK ? lf_rgbd_check(&job->rgbd, "export", err) : status;
}

static lf_status take_fds(lf_job *job, lf_client *client, int n, lf_error *err)
{
    if (n == 0)
        return LF_OK;
    job->fds = lf_calloc((size_t)n, sizeof *job->fds);
    if (!job->fds)
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    if (!lf_client_take_fds(client, job->fds, n))
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/fds",
                               "fewer than %d descriptors came with the call", n);
    job->n_fds = n;
    return LF_OK;
}

static bool ends_with(const char *text, const char *ending)
{
    size_t n = strlen(text), m = strlen(ending);
    return n > m && strcmp(text + n - m, ending) == 0;
}

/* The name: beneath --export-dir, or with descriptors just a name, whose ending tells the format.
 */
static lf_status take_file(lf_job *job, const char *file, lf_error *err)
{
    if (!job->kind && !ends_with(file, STATE_ENDING))
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/file",
                               "a state's name must end in " STATE_ENDING);
    lf_status status = job->kind ? LF_OK : lf_check_stem(file, STATE_ENDING, err);
    if (status != LF_OK)
        return status;
    if (job->n_fds == 0) {
        lf_held_name held;
        status = lf_server_write_path(job->server, file, &held, err);
        if (status != LF_OK)
            return status;
        job->file = held.path;
        job->folder_fd = held.folder_fd;
    } else {
        job->file = lf_strdup(file);
    }
    if (!job->file)
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    if (!job->kind)
        return LF_OK;
    char *path = NULL;
    const lf_content *content = job->server->content;
    status = lf_output_path(job->kind, job->file, content ? &content->layout : NULL, &path, err);
    if (job->n_fds == 0)
        job->name = path;
    else
        lf_free(path);
    return status;
}

/* An accumulation is one from its first pass on; a picture, once it is coarse. */
static lf_level wait_of(const json_t *params, bool is_state)
{
    const char *name = string_of(params, "wait");
    for (lf_level level = LF_LEVEL_COARSE; name && level <= LF_LEVEL_CONVERGED; level++)
        if (strcmp(name, lf_level_name(level)) == 0)
            return level;
    return is_state ? LF_LEVEL_NONE : LF_LEVEL_COARSE;
}

/* auto: as shown; but of light the estimator's answer, unless the daemon was told on. */
static lf_status take_reconstruct(lf_job *job, const json_t *params, lf_error *err)
{
    const lf_engine_controls controls = lf_engine_get_controls(job->server->engine);
    const char *word;
    lf_status status = lf_denoise_word(params, "export", &word, err);
    if (status != LF_OK)
        return status;
    job->reconstruct = word ? LF_RECONSTRUCT_ON : LF_RECONSTRUCT_AUTO;
    while (job->reconstruct > LF_RECONSTRUCT_AUTO &&
           strcmp(word, lf_reconstruct_name((int)job->reconstruct)) != 0)
        job->reconstruct--;
    if (job->reconstruct == LF_RECONSTRUCT_AUTO && controls.reconstruct != LF_RECONSTRUCT_ON &&
        job->kind && lf_output_is_light(job->kind, job->file))
        job->reconstruct = LF_RECONSTRUCT_OFF;
    return LF_OK;
}

static lf_status take_words(lf_job *job, lf_call *call, lf_error *err)
{
    const lf_server *server = call->server;
    const json_t *params = call->params;
    const char *kind = string_of(params, "kind");
    const bool is_state = strcmp(kind, "state") == 0;
    job->overwrite = json_is_true(json_object_get(params, "overwrite"));
    job->asker.detached = json_is_true(json_object_get(params, "detach"));
    job->wait = wait_of(params, is_state);
    job->generation = server->generation;
    int n_fds = (int)number_of(params, "fds", 0);
    if (is_state && n_fds > 1)
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/fds",
                               "a state is one file: one descriptor, not %d", n_fds);
    lf_status status = take_fds(job, call->client, n_fds, err);
    if (status == LF_OK && !is_state)
        status = lf_output_kind_from_name(kind, &job->kind, err);
    if (status == LF_OK && !job_is_drawn(job) &&
        (!server->content || (is_state && !server->content->scene)))
        return lf_error_set(err, LF_E_STATE, "export", "there is no picture to export");
    if (status == LF_OK)
        status = take_file(job, string_of(params, "file"), err);
    if (status == LF_OK)
        status = take_reconstruct(job, params, err);
    if (status == LF_OK && job->kind && job->kind->needs_panel)
        status = take_panel_words(job, params, err);
    if (status == LF_OK && job->kind && job->kind->check_print)
        status = take_print_words(job, params, err);
    if (status == LF_OK && job->kind && job->kind->layers)
        status = take_rgbd_words(job, params, err);
    return status;
}

static int count_jobs(const lf_server *server)
{
    int n = 0;
    for (const lf_job *job = server->jobs; job; job = job->next)
        n++;
    return n;
}

/* A job that will wait is one of a few: of its client, of those that are detached, and of all. */
static lf_status check_waiting(const lf_job *job, lf_error *err)
{
    int waiting = 0, detached = 0, of_client = 0;
    for (const lf_job *other = job->server->jobs; other; other = other->next) {
        if (other->started)
            continue;
        waiting++;
        detached += other->asker.detached ? 1 : 0;
        of_client += other->asker.client == job->asker.client ? 1 : 0;
    }
    if (job_may_start(job))
        return LF_OK;
    if (of_client >= MOST_OF_CLIENT)
        return lf_error_set(err, LF_E_BUSY, "export",
                            "%d exports of this client are waiting already (job.cancel ends one)",
                            MOST_OF_CLIENT);
    if (job->asker.detached && detached >= MOST_DETACHED)
        return lf_error_set(err, LF_E_BUSY, "export",
                            "%d detached exports are waiting already (job.cancel ends one)",
                            MOST_DETACHED);
    if (waiting >= MOST_WAITING)
        return lf_error_set(err, LF_E_BUSY, "export", "%d exports are waiting already",
                            MOST_WAITING);
    return LF_OK;
}

/* A connection that is half-closed stays until its jobs have ended; a detached one needs none. */
static lf_status hold_client(lf_job *job, lf_client *client, lf_error *err)
{
    job->asker.holds = !job->asker.detached && lf_client_hold(client, &job->asker.bytes);
    return job->asker.holds || job->asker.detached
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, "export",
                              "too many calls of this client are waiting for an answer");
}

void lf_server_export(lf_call *call)
{
    lf_server *server = call->server;
    lf_error err;
    lf_job *job = count_jobs(server) < MAX_JOBS ? job_create(server) : NULL;
    if (!job) {
        (void)lf_error_set(&err, LF_E_BUSY, "export", "%d jobs are waiting or running", MAX_JOBS);
        lf_client_drop_fds(call->client);
        lf_fail(call, &err, false);
        return;
    }
    job->asker.client = lf_client_serial(call->client);
    lf_status status = take_words(job, call, &err);
    if (status == LF_OK)
        status = check_waiting(job, &err);
    if (status == LF_OK)
        status = hold_client(job, call->client, &err);
    if (status != LF_OK) {
        job_free(job);
        lf_client_drop_fds(call->client);
        lf_fail(call, &err, false);
        return;
    }
    lf_client_drop_fds(call->client); /* more came than were announced */
    job->id = ++server->n_jobs;
    job_list(job);
    lf_reply(call, json_pack("{s:I, s:o}", "job", (json_int_t)job->id, "file",
                             lf_rpc_text(job->name ? job->name : job->file)));
    lf_server_start_jobs(server);
}
