/* quiltctl's exports: files are opened here, with the caller's rights, and published when the
 * daemon reports that the job is done. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/paths.h"
#include "daemon/output/output.h"
#include "daemon/tools/ctl.h"

#define MAX_FILES 253

typedef struct export_files {
    lf_outfile file[MAX_FILES];
    int n;
} export_files;

static void abandon(export_files *files)
{
    for (int i = 0; i < files->n; i++)
        lf_outfile_abandon(&files->file[i]);
    files->n = 0;
}

static lf_status add_file(export_files *files, const char *path, bool overwrite, lf_error *err)
{
    lf_status status = lf_outfile_open(&files->file[files->n], path, overwrite, err);
    files->n += status == LF_OK ? 1 : 0;
    return status;
}

/* Queries the picture's layout from the daemon. */
static lf_status ask_layout(lf_ctl *ctl, lf_layout *out, lf_error *err)
{
    json_t *status = NULL;
    lf_status answer = lf_ctl_call(ctl, "status", json_object(), NULL, 0, &status, NULL, err);
    if (answer != LF_OK)
        return answer;
    int views = 0;
    double aspect = 0;
    *out = (lf_layout){0};
    int r = json_unpack(status, "{s:i, s:i, s:i, s:i, s:i, s:F}", "views", &views, "columns",
                        &out->columns, "rows", &out->rows, "view_width", &out->view_width,
                        "view_height", &out->view_height, "aspect", &aspect);
    json_decref(status);
    out->n_views = views;
    out->aspect = aspect;
    return r == 0 ? LF_OK
                  : lf_error_set(err, LF_E_STATE, "export",
                                 "nothing is loaded; call scene.load first");
}

/* Opens the n files of an output with this final name. */
static lf_status open_output(export_files *files, const lf_output_kind *kind, const char *path,
                             int n, bool overwrite, lf_error *err)
{
    if (n > MAX_FILES)
        return lf_error_set(
            err, LF_E_ARG, path,
            "cannot pass more than %d views at once; use quiltrender or an --export-dir of quiltd",
            MAX_FILES);
    if (kind->surplus && mkdir(path, 0777) != 0 && errno != EEXIST)
        return lf_error_set(err, LF_E_IO, path, "cannot make the folder: %s", lf_errno_text(errno));
    lf_status status = LF_OK;
    for (int i = 0; i < n && status == LF_OK; i++) {
        char *name = lf_output_file_name(kind, path, i);
        status = name ? add_file(files, name, overwrite, err)
                      : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
        lf_free(name);
    }
    return status;
}

/* Opens the files of the kind; *out_path is the name with the layout in it. */
static lf_status open_files(lf_ctl *ctl, const char *kind_name, const char *file, bool overwrite,
                            export_files *files, char **out_path, lf_error *err)
{
    if (strcmp(kind_name, "state") == 0) {
        *out_path = lf_strdup(file);
        return *out_path ? add_file(files, file, overwrite, err) : LF_E_NOMEM;
    }
    const lf_output_kind *kind = NULL;
    lf_layout layout = {0};
    lf_status status = lf_output_kind_from_name(kind_name, &kind, err);
    if (status == LF_OK && !kind->is_drawn)
        status = ask_layout(ctl, &layout, err);
    if (status == LF_OK)
        status = lf_output_path(kind, file, &layout, out_path, err);
    if (status != LF_OK)
        return status;
    return open_output(files, kind, *out_path, lf_output_n_files(kind, NULL, layout.n_views),
                       overwrite, err);
}

static void show_progress(const json_t *params)
{
    if (isatty(STDERR_FILENO))
        fprintf(stderr, "\r\033[K%s %3.0f %%", json_string_value(json_object_get(params, "state")),
                100 * json_number_value(json_object_get(params, "progress")));
}

/* Judges the state of a job that has ended; "running" and "done" are no errors. */
static lf_status judge(const json_t *params, lf_error *err)
{
    const char *state = json_string_value(json_object_get(params, "state"));
    const char *text =
        json_string_value(json_object_get(json_object_get(params, "error"), "message"));
    if (strcmp(state, "failed") == 0)
        return lf_error_set(err, LF_E_IO, "", "%s", text ? text : "the export failed");
    return strcmp(state, "cancelled") == 0
               ? lf_error_set(err, LF_E_CANCELLED, "export", "was cancelled")
               : LF_OK;
}

/* Waits for the end of the job. What its profiles gave, and their warnings, go to the result. */
static lf_status follow(lf_ctl *ctl, json_int_t job, json_t *result, lf_error *err)
{
    for (;;) {
        json_t *message = NULL;
        lf_status status = lf_ctl_next(ctl, &message, err);
        if (status != LF_OK)
            return status;
        const json_t *params = json_object_get(message, "params");
        const char *state = json_string_value(json_object_get(params, "state"));
        if (!state || json_integer_value(json_object_get(params, "job")) != job) {
            json_decref(message);
            continue;
        }
        show_progress(params);
        bool running = strcmp(state, "running") == 0;
        status = judge(params, err);
        json_array_extend(json_object_get(result, "warnings"), json_object_get(params, "warnings"));
        if (json_object_get(params, "used"))
            json_object_set(result, "used", json_object_get(params, "used"));
        json_decref(message);
        if (!running) {
            if (isatty(STDERR_FILENO))
                fputs("\r\033[K", stderr);
            return status;
        }
    }
}

static lf_status publish(export_files *files, bool overwrite, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; i < files->n; i++)
        if (status == LF_OK)
            status = lf_outfile_commit(&files->file[i], overwrite, err);
        else
            lf_outfile_abandon(&files->file[i]);
    files->n = 0;
    return status;
}

lf_status lf_ctl_export(lf_ctl *ctl, json_t *params, json_t **out_result, lf_error *err)
{
    const char *kind = json_string_value(json_object_get(params, "kind"));
    const char *file = json_string_value(json_object_get(params, "file"));
    bool overwrite = json_is_true(json_object_get(params, "overwrite"));
    export_files *files = lf_calloc(1, sizeof *files);
    char *path = NULL;
    json_t *result = NULL;
    int fds[MAX_FILES];
    lf_status status = LF_E_ARG;
    if (!files || !kind || !file) {
        status = lf_error_set(err, !files ? LF_E_NOMEM : LF_E_ARG, "export",
                              "expects a kind and a file; see quiltctl export --help");
        goto end;
    }
    status = open_files(ctl, kind, file, overwrite, files, &path, err);
    if (status != LF_OK)
        goto end;
    for (int i = 0; i < files->n; i++)
        fds[i] = files->file[i].fd;
    json_object_set_new(params, "file", json_string(path));
    json_object_set_new(params, "fds", json_integer(files->n));
    status = lf_ctl_call(ctl, "export", json_incref(params), fds, files->n, &result, NULL, err);
    if (status == LF_OK)
        status = follow(ctl, json_integer_value(json_object_get(result, "job")), result, err);
    if (status == LF_OK)
        status = publish(files, overwrite, err);
    if (status == LF_OK)
        *out_result = json_pack("{s:s, s:s, s:O*, s:O*}", "kind", kind, "file", path, "used",
                                json_object_get(result, "used"), "warnings",
                                json_object_get(result, "warnings"));
end:
    if (files)
        abandon(files);
    lf_free(files);
    lf_free(path);
    json_decref(result);
    json_decref(params);
    return status;
}

/* True until quiltfarm knows the job. */
static bool is_beginning(const json_t *params)
{
    const char *state = json_string_value(json_object_get(params, "state"));
    const char *farm = json_string_value(json_object_get(json_object_get(params, "farm"), "state"));
    return strcmp(state, "running") == 0 && farm &&
           (strcmp(farm, "planning") == 0 || strcmp(farm, "submitting") == 0);
}

lf_status lf_ctl_export_farmed(lf_ctl *ctl, json_t *params, json_t **out_result, lf_error *err)
{
    json_t *result = NULL;
    lf_status status = lf_ctl_call(ctl, "export", params, NULL, 0, &result, NULL, err);
    const json_int_t job = json_integer_value(json_object_get(result, "job"));
    for (bool begins = true; status == LF_OK && begins;) {
        json_t *message = NULL;
        status = lf_ctl_next(ctl, &message, err);
        const json_t *told = json_object_get(message, "params");
        if (json_is_string(json_object_get(told, "state")) &&
            json_integer_value(json_object_get(told, "job")) == job) {
            status = judge(told, err);
            begins = is_beginning(told);
            if (json_object_get(told, "farm"))
                json_object_set(result, "farm", json_object_get(told, "farm"));
        }
        json_decref(message);
    }
    if (status == LF_OK)
        *out_result = result;
    else
        json_decref(result);
    return status;
}

lf_status lf_ctl_image(lf_ctl *ctl, const char *method, const char *file, json_t *params,
                       json_t **out_result, lf_error *err)
{
    lf_outfile image;
    lf_status status = lf_outfile_open(&image, file, false, err);
    if (status != LF_OK) {
        json_decref(params);
        return status;
    }
    json_t *result = NULL;
    status = lf_ctl_call(ctl, method, params, &image.fd, 1, &result, NULL, err);
    if (status == LF_OK)
        status = lf_outfile_commit(&image, false, err);
    else
        lf_outfile_abandon(&image);
    if (status == LF_OK)
        *out_result = result;
    else
        json_decref(result);
    return status;
}

/* False: quilt.show would refuse it. */
static bool is_quilt_name(const char *name)
{
    return strlen(name) <= LF_MAX_ARRAY_NAME && lf_check_name(name, NULL) == LF_OK;
}

lf_status lf_ctl_show_quilt(lf_ctl *ctl, const char *file, json_t *params, json_t **out_result,
                            lf_error *err)
{
    const char *slash = strrchr(file, '/');
    int fd = open(file, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        json_decref(params);
        return lf_error_set(err, LF_E_IO, file, "cannot open: %s", lf_errno_text(errno));
    }
    const char *name = slash ? slash + 1 : file;
    if (!json_object_get(params, "name") && is_quilt_name(name))
        json_object_set_new(params, "name", json_string(name));
    lf_status status = lf_ctl_call(ctl, "quilt.show", params, &fd, 1, out_result, NULL, err);
    close(fd);
    return status;
}
