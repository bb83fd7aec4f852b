/* Exports: checks the parameters of a call as far as possible before anything is written, and
 * reports jobs to clients (daemon/parts/jobs.h). */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/server/server_internal.h"

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

static lf_status take_panel_words(const lf_server *server, lf_export *what, const json_t *params,
                                  lf_error *err)
{
    const lf_calibration *calibration = lf_show_calibration(server->show);
    what->panel.response = server->response; /* defaults of the panel, overridden by the call */
    lf_status status = lf_param_from_json(lf_panel_params, params, &what->panel, "export", err);
    if (status == LF_OK)
        status =
            lf_param_from_json(lf_response_params, params, &what->panel.response, "export", err);
    if (status == LF_OK && !calibration)
        return lf_error_set(err, LF_E_NODEV, lf_show_spec(server->show),
                            "no panel with a known calibration is open; open one with device.set "
                            "or start quiltd with --calibration");
    if (status == LF_OK) {
        what->has_calibration = true;
        what->calibration = *calibration;
    }
    return status;
}

/* The warnings of an answer: the scene may be too deep for the sheet. */
static json_t *warnings_of(const lf_server *server, const lf_export *what)
{
    char words[LF_DEPTH_WORDS];
    json_t *lines = json_array();
    lf_depth depth;
    int lenses;
    if (what->kind && what->kind->check_print && !what->kind->is_drawn &&
        lf_content_depth_on_print(server->content, &what->print, &depth, &lenses))
        (void)json_array_append_new(
            lines,
            json_string(lf_depth_words(&depth, lenses, LF_DEPTH_PRINT, words, sizeof words)));
    return lines;
}

/* The name of a profile, or its path, which must be readable. Caller frees. */
static lf_status take_profile(const lf_server *server, const char *name, const char **out,
                              lf_error *err)
{
    char *path = NULL;
    lf_status status = LF_OK;
    if (!name)
        return LF_OK;
    if (lf_profile_is_path(name))
        status = lf_server_read_path(server, name, &path, err);
    else
        path = lf_strdup(name);
    *out = path;
    return status == LF_OK && !path ? lf_error_set(err, LF_E_NOMEM, name, "out of memory") : status;
}

static lf_status take_profiles(const lf_server *server, lf_export *what, const json_t *params,
                               lf_error *err)
{
    lf_status status = take_profile(server, string_of(params, "lens"), &what->named.lens, err);
    if (status == LF_OK)
        status = take_profile(server, string_of(params, "printer"), &what->named.printer, err);
    what->given = lf_print_given_in(params);
    return status;
}

static lf_status take_print_words(const lf_server *server, lf_export *what, const json_t *params,
                                  lf_error *err)
{
    lf_print *print = &what->print;
    const json_t *lens = json_object_get(params, "lens");
    const char *missing = lf_param_missing(lf_print_params, params);
    if (missing && lens && strcmp(missing, "lpi") == 0) /* a profile has it */
        missing = lf_param_missing(lf_param_next(lf_print_params), params);
    if (missing)
        return lf_error_set(err, LF_E_ARG, "export", "%s needs %s; \"%s\" is missing",
                            what->kind->what, what->kind->asks, missing);
    lf_param_defaults(lf_print_params, print);
    print->photo = server->options.photo;
    lf_status status = lf_param_from_json(lf_print_params, params, print, "export", err);
    if (status == LF_OK)
        status = lf_param_from_json(lf_photo_params, params, &print->photo, "export", err);
    if (status == LF_OK && print->icc_path)
        status = lf_server_read_path(server, print->icc_path, &what->icc, err);
    print->icc_path = what->icc;
    if (print->sheet.label && !(what->label = lf_strdup(print->sheet.label)))
        status = lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    print->sheet.label = what->label;
    print->icc_roots = &server->roots;
    if (status == LF_OK)
        status = take_profiles(server, what, params, err);
    if (status == LF_OK)
        status = lf_output_check_given(what->kind->what, what->kind->reads, &what->given, false,
                                       "export", err);
    if (status != LF_OK || what->named.lens || what->named.printer)
        return status; /* the job reads them, and checks the rest */
    return lf_export_check_print(what, print, server->content, err);
}

static lf_status take_rgbd_words(lf_export *what, const json_t *params, lf_error *err)
{
    lf_status status = lf_param_from_json(lf_rgbd_params, params, &what->rgbd, "export", err);
    return status == LF_OK ? lf_rgbd_check(&what->rgbd, "export", err) : status;
}

static lf_status take_fds(lf_export *what, lf_client *client, int n, lf_error *err)
{
    if (n == 0)
        return LF_OK;
    what->fds = lf_calloc((size_t)n, sizeof *what->fds);
    if (!what->fds)
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    if (!lf_client_take_fds(client, what->fds, n))
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/fds",
                               "expects %d file descriptors, but fewer came with the call", n);
    what->n_fds = n;
    return LF_OK;
}

static bool ends_with(const char *text, const char *ending)
{
    size_t n = strlen(text), m = strlen(ending);
    return n > m && strcmp(text + n - m, ending) == 0;
}

/* Checks the name: inside --export-dir, or with descriptors only a name, whose ending selects the
 * format. */
static lf_status take_file(const lf_server *server, lf_export *what, const char *file,
                           lf_error *err)
{
    if (!what->kind && !ends_with(file, STATE_ENDING))
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/file",
                               "the name of a state must end in " STATE_ENDING);
    lf_status status = what->kind ? LF_OK : lf_check_stem(file, STATE_ENDING, err);
    if (status != LF_OK)
        return status;
    if (what->n_fds == 0) {
        lf_held_name held;
        status = lf_server_write_path(server, file, &held, err);
        if (status != LF_OK)
            return status;
        what->file = held.path;
        what->folder_fd = held.folder_fd;
    } else {
        what->file = lf_strdup(file);
    }
    if (!what->file)
        return lf_error_set(err, LF_E_NOMEM, "export", "out of memory");
    if (!what->kind)
        return LF_OK;
    const lf_content *content = server->content;
    return lf_output_path(what->kind, what->file, content ? &content->layout : NULL, &what->name,
                          err);
}

/* A state can be saved from the first pass on, a picture once it is coarse. */
static lf_level wait_of(const json_t *params, bool is_state)
{
    const char *name = string_of(params, "wait");
    for (lf_level level = LF_LEVEL_COARSE; name && level <= LF_LEVEL_CONVERGED; level++)
        if (strcmp(name, lf_level_name(level)) == 0)
            return level;
    return is_state ? LF_LEVEL_NONE : LF_LEVEL_COARSE;
}

/* auto: as shown, but files of linear light get the estimator's answer unless the daemon was
 * started with `on`. */
static void take_denoise(const lf_server *server, lf_export *what, const json_t *params)
{
    const lf_engine_controls controls = lf_engine_get_controls(server->engine);
    const char *word = json_string_value(lf_param_or_former(params, "denoise", "reconstruct"));
    what->denoise = word ? LF_DENOISE_ON : LF_DENOISE_AUTO;
    while (what->denoise > LF_DENOISE_AUTO &&
           strcmp(word, lf_denoise_name((int)what->denoise)) != 0)
        what->denoise--;
    if (what->denoise == LF_DENOISE_AUTO && controls.denoise != LF_DENOISE_ON && what->kind &&
        lf_output_is_light(what->kind, what->file))
        what->denoise = LF_DENOISE_OFF;
}

static lf_status take_words(lf_export *what, lf_call *call, lf_error *err)
{
    const lf_server *server = call->server;
    const json_t *params = call->params;
    const char *kind = string_of(params, "kind");
    const bool is_state = strcmp(kind, "state") == 0;
    what->overwrite = json_is_true(json_object_get(params, "overwrite"));
    what->asker.detached = json_is_true(json_object_get(params, "detach"));
    what->wait = wait_of(params, is_state);
    what->generation = server->generation;
    int n_fds = (int)number_of(params, "fds", 0);
    if (is_state && n_fds > 1)
        return lf_error_set_at(err, LF_E_ARG, "export", 0, "/fds",
                               "a state is one file; pass one descriptor, not %d", n_fds);
    lf_status status = take_fds(what, call->client, n_fds, err);
    if (status == LF_OK && !is_state)
        status = lf_output_kind_from_name(kind, &what->kind, err);
    if (status == LF_OK && !lf_export_is_drawn(what) &&
        (!server->content || (is_state && !server->content->scene)))
        return lf_error_set(err, LF_E_STATE, "export",
                            "there is no image to export; call scene.load first");
    if (status == LF_OK)
        status = take_file(server, what, string_of(params, "file"), err);
    if (status == LF_OK)
        take_denoise(server, what, params);
    if (status == LF_OK && what->kind && what->kind->needs_panel)
        status = take_panel_words(server, what, params, err);
    if (status == LF_OK && what->kind && what->kind->check_print)
        status = take_print_words(server, what, params, err);
    if (status == LF_OK && what->kind && what->kind->layers)
        status = take_rgbd_words(what, params, err);
    return status;
}

/* A half-closed connection stays open until its jobs have ended; a detached job needs none. */
static lf_status hold_client(lf_export *what, lf_client *client, lf_error *err)
{
    what->asker.holds = !what->asker.detached && lf_client_hold(client, &what->asker.bytes);
    return what->asker.holds || what->asker.detached
               ? LF_OK
               : lf_error_set(err, LF_E_BUSY, "export",
                              "too many calls of this client are waiting for an answer; wait for "
                              "some of them");
}

static void release_client(lf_server *server, const lf_asker *asker)
{
    if (asker->holds)
        lf_clients_release(server->clients, asker->client, asker->bytes);
}

/* Fills out from the call; finish it also after a failure. */
static lf_status take_export(lf_call *call, lf_export *out, lf_error *err)
{
    lf_status status = take_words(out, call, err);
    if (status == LF_OK && json_object_get(call->params, "farm"))
        return LF_OK; /* it waits for nothing, and outlives its client */
    if (status == LF_OK)
        status = lf_jobs_check_wait(call->server->jobs, out, err);
    return status == LF_OK ? hold_client(out, call->client, err) : status;
}

void lf_server_export(lf_call *call)
{
    lf_server *server = call->server;
    lf_error err;
    lf_export what = {.asker.client = lf_client_serial(call->client), .folder_fd = -1};
    const bool is_farmed = json_object_get(call->params, "farm");
    lf_status status =
        lf_jobs_check_room(server->jobs, lf_saver_is_busy(server->saver) ? 1 : 0, &err);
    if (status == LF_OK)
        status = lf_server_farm_check(server, call->params, &err);
    if (status == LF_OK)
        status = take_export(call, &what, &err);
    if (status == LF_OK && is_farmed) {
        lf_server_farm(call, &what);
        lf_export_finish(&what);
        return;
    }
    if (status == LF_OK)
        status = lf_jobs_add(server->jobs, server->n_jobs + 1, &what, &err);
    if (status != LF_OK) {
        release_client(server, &what.asker);
        lf_export_finish(&what);
        lf_fail(call, &err, false);
        return;
    }
    lf_reply(call, json_pack("{s:I, s:o, s:o}", "job", (json_int_t)++server->n_jobs, "file",
                             lf_rpc_text(what.name ? what.name : what.file), "warnings",
                             warnings_of(server, &what)));
    lf_jobs_start(server->jobs);
}

/* -------------------------------------------------------------------------------------- told -- */

static json_t *job_json(const lf_job_told *job)
{
    static const char *const states[] = {[LF_JOB_WAITING] = "waiting",
                                         [LF_JOB_RUNNING] = "running",
                                         [LF_JOB_DONE] = "done",
                                         [LF_JOB_CANCELLED] = "cancelled",
                                         [LF_JOB_FAILED] = "failed"};
    json_t *told = json_pack("{s:I, s:s, s:o, s:s, s:f}", "job", (json_int_t)job->id, "kind",
                             job->kind, "file", lf_rpc_text(job->file), "state", states[job->state],
                             "progress", job->progress);
    if (job->err) {
        json_t *answer = lf_rpc_error_of(NULL, job->err, false);
        json_object_set(told, "error", json_object_get(answer, "error"));
        json_decref(answer);
    }
    if (job->account) {
        json_object_set(told, "used", json_object_get(job->account, "used"));
        json_object_set(told, "warnings", json_object_get(job->account, "warnings"));
    }
    return told;
}

json_t *lf_server_jobs_json(const lf_server *server)
{
    json_t *list = json_array();
    lf_job_told job;
    for (int i = 0; lf_jobs_at(server->jobs, i, &job); i++)
        json_array_append_new(list, job_json(&job));
    lf_server_farm_json(server, list);
    return list;
}

static void on_told(void *context, const lf_job_told *job)
{
    lf_server_tell_export(context, job->asker->client, job_json(job));
}

static void on_ended(void *context, const lf_asker *asker)
{
    lf_server *server = context;
    release_client(server, asker);
    if (lf_server_is_stopping(server))
        lf_server_shutdown(server);
}

lf_status lf_server_make_jobs(lf_server *server)
{
    static const lf_jobs_events events = {.told = on_told, .ended = on_ended};
    const lf_jobs_home home = {
        .event = server->event, .inbox = &server->inbox, .engine = server->engine};
    return lf_jobs_create(&home, &events, server, &server->jobs);
}
