#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/parts/jobs_internal.h"

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

/* The destination through held descriptors, because the names of its folders may lead elsewhere by
 * now. */
typedef struct destination {
    char *path;       /* to be written */
    const char *told; /* name for errors */
    char *name;       /* name inside the held folder */
    int views_fd;
    bool made; /* the folder of views */
} destination;

static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* Replaces the held folder's path in an error by the requested one. */
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
        unlinkat(job->asked.folder_fd, d->name, AT_REMOVEDIR);
    lf_free(d->path);
    lf_free(d->name);
}

static lf_status destination_init(lf_job *job, const char *path, destination *out)
{
    destination d = {.told = path, .name = last_part(path), .views_fd = -1};
    bool views = path[0] != '\0' && path[strlen(path) - 1] == '/';
    lf_status status = LF_OK;
    if (d.name && job->asked.folder_fd >= 0 && views)
        status = lf_held_folder(job->asked.folder_fd, d.name, &d.views_fd, &d.made, &job->err);
    if (d.name && status == LF_OK) {
        d.path = job->asked.folder_fd < 0 ? lf_strdup(path)
                 : views                  ? lf_held_path(d.views_fd, "")
                                          : lf_held_path(job->asked.folder_fd, d.name);
    }
    if (status == LF_OK && !d.path)
        status = lf_error_set(&job->err, LF_E_NOMEM, path, "out of memory");
    if (status == LF_OK)
        *out = d;
    else
        destination_finish(job, &d, status);
    return status;
}

lf_status lf_export_check_print(const lf_export *what, lf_print *print, const lf_content *content,
                                lf_error *err)
{
    lf_depth depth;
    int lenses;
    lf_status status = LF_OK;
    if (!what->kind->is_drawn)
        status = lf_print_choose_views(print, content->layout.n_views, "export", "/views", err);
    if (status == LF_OK)
        status = what->kind->check_print(print, NULL, err);
    if (status == LF_OK && !what->kind->is_drawn &&
        lf_content_depth_on_print(content, print, &depth, &lenses))
        print->parallax_lenses = fmin(lf_depth_shift(&depth), lenses); /* for the manifest */
    return status;
}

/* Fills the print from its profiles, which are files, and checks it. */
static lf_status open_profiles(lf_job *job, const lf_content *content, lf_print *print,
                               lf_profiles *profiles)
{
    const lf_export *asked = &job->asked;
    if (!asked->named.lens && !asked->named.printer)
        return LF_OK;
    lf_status status = lf_profiles_open(&asked->named, print->icc_roots, &asked->given, print,
                                        profiles, &job->err);
    return status == LF_OK ? lf_export_check_print(asked, print, content, &job->err) : status;
}

/* snapshot NULL: for a kind that is drawn. */
static lf_status write_picture(lf_job *job, const lf_snapshot *snapshot, const lf_print *print)
{
    static const lf_content nothing;
    const lf_content *content = snapshot ? snapshot->content : &nothing;
    /* The picture may have changed since the call, so the name is determined again. */
    lf_status status =
        lf_output_path(job->asked.kind, job->asked.file, &content->layout, &job->final, &job->err);
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
        .kind = job->asked.kind,
        .path = to.path,
        .overwrite = job->asked.overwrite,
        .fds = job->asked.fds,
        .n_fds = job->asked.n_fds,
        .layout = content->layout,
        .calibration = job->asked.has_calibration ? &job->asked.calibration : NULL,
        .panel = job->asked.panel,
        .print = print,
        .rgbd = job->asked.rgbd,
        .exposure = snapshot ? snapshot->shown_as.exposure : 0,
        .tonemap = snapshot ? snapshot->shown_as.tonemap : NULL,
        .settings = settings,
        .cancel = &job->cancel,
        .progress = on_progress,
        .context = job,
    };
    job->asked.n_fds = 0; /* ownership was taken, also on failure */
    status = lf_output_write(&request, snapshot ? &snapshot->source : NULL, &job->err);
    json_decref(settings);
    destination_finish(job, &to, status);
    return status;
}

/* snapshot NULL: for a kind that is drawn. */
static lf_status write_snapshot(lf_job *job, const lf_snapshot *snapshot)
{
    lf_print print = job->asked.print;
    lf_profiles *profiles = lf_calloc(1, sizeof *profiles);
    if (!profiles)
        return lf_error_set(&job->err, LF_E_NOMEM, "profiles", "out of memory");
    lf_status status = open_profiles(job, snapshot ? snapshot->content : NULL, &print, profiles);
    if (status == LF_OK)
        status = write_picture(job, snapshot, &print);
    job->account = json_incref(profiles->account);
    lf_profiles_finish(profiles);
    lf_free(profiles);
    return status;
}

static lf_status write_state(lf_job *job)
{
    lf_outfile file = {.fd = -1};
    destination to = {.views_fd = -1};
    lf_status status;
    if (job->asked.n_fds > 0) {
        status = lf_outfile_adopt(&file, job->asked.fds[0], &job->err);
        job->asked.n_fds = status == LF_OK ? 0 : job->asked.n_fds;
    } else {
        status = destination_init(job, job->asked.file, &to);
        if (status == LF_OK)
            status = lf_outfile_open(&file, to.path, job->asked.overwrite, &job->err);
    }
    if (status == LF_OK) {
        status = lf_engine_save(job->jobs->home.engine, &file, &job->err);
        if (status == LF_OK)
            status = lf_outfile_commit(&file, job->asked.overwrite, &job->err);
        else
            lf_outfile_abandon(&file);
    }
    destination_finish(job, &to, status);
    return status;
}

/* Errors about descriptors get the name of the client's file. */
static void tell_meant(lf_job *job)
{
    if (strcmp(job->err.where, "descriptor") == 0)
        (void)snprintf(job->err.where, sizeof job->err.where, "%s", job->asked.file);
}

void lf_job_write(lf_job *job)
{
    const lf_export *asked = &job->asked;
    bool has_fds = asked->n_fds > 0;
    if (!asked->kind) {
        job->status = write_state(job);
    } else if (asked->kind->is_drawn) {
        job->status = write_snapshot(job, NULL);
    } else {
        lf_snapshot snapshot;
        job->status = lf_engine_snapshot(job->jobs->home.engine, asked->denoise,
                                         asked->kind->layers, &snapshot, &job->err);
        if (job->status == LF_OK)
            job->status = write_snapshot(job, &snapshot);
        lf_snapshot_finish(&snapshot);
    }
    if (has_fds && job->status != LF_OK)
        tell_meant(job);
}
