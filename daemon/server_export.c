/* What a call's words say about an export: a job, checked as far as it can be before anything is written. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/openat2.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/server_job.h"

#define MAX_JOBS 8
#define STATE_ENDING ".lfstate"

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
    lf_job *job = count_jobs(server) < MAX_JOBS ? job_create(server) : NULL;
    if (job == NULL) {
        (void)lf_error_set(&err, LF_E_BUSY, "export", "%d jobs are waiting or running", MAX_JOBS);
        lf_client_drop_fds(call->client);
        lf_fail(call, &err, false);
        return;
    }
    job->client = lf_client_serial(call->client);
    lf_status status = take_words(job, call, &err);
    if (status != LF_OK) {
        job_free(job);
        lf_client_drop_fds(call->client);
        lf_fail(call, &err, false);
        return;
    }
    lf_client_drop_fds(call->client); /* more came than were announced */
    job->id = ++server->n_jobs;
    job_list(job);
    lf_reply(call, json_pack("{s:I, s:s}", "job", (json_int_t)job->id, "file", job->file));
    lf_server_start_jobs(server);
}
