#include "daemon/output/output.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

/* ------------------------------------------------------------------------------------- kinds -- */

#define LIST(name) &lf_output_##name,
const lf_output_kind *const lf_output_kinds[] = {LF_OUTPUT_KINDS(LIST) NULL};

lf_status lf_output_kind_from_name(const char *name, const lf_output_kind **out, lf_error *err)
{
    char known[128] = "";
    for (int i = 0; lf_output_kinds[i]; i++) {
        const size_t used = strlen(known);
        if (strcmp(name, lf_output_kinds[i]->name) == 0) {
            *out = lf_output_kinds[i];
            return LF_OK;
        }
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "",
                 lf_output_kinds[i]->name);
    }
    return lf_error_set(err, LF_E_ARG, "kind", "unknown kind \"%s\"; expected one of %s", name,
                        known);
}

/* The row of a key of lf_print_given. */
static const lf_param *row_of(const char *key)
{
    const lf_param *row = lf_print_params;
    while (strcmp(row->name ? row->name : row->option, key) != 0)
        row++;
    return row;
}

static bool is_option_given(const lf_print_given *given, const char *option)
{
    for (int i = 0; i < given->n; i++) {
        const lf_param *row = row_of(given->keys[i]);
        if (row->option && strcmp(row->option, option) == 0)
            return true;
    }
    return false;
}

lf_status lf_output_check_given(const char *what, const char *reads, const lf_print_given *given,
                                bool on_line, const char *where, lf_error *err)
{
    for (int i = 0; i < given->n; i++) {
        const lf_param *row = row_of(given->keys[i]);
        const bool is_read = !reads || !row->option || lf_param_among(row, reads);
        char name[64], needed[64];
        if (is_read && (!row->needs || is_option_given(given, row->needs)))
            continue;
        snprintf(name, sizeof name, "%s%s", on_line ? "--" : "", on_line ? row->option : row->name);
        snprintf(needed, sizeof needed, "%s%s", on_line ? "--" : "", row->needs ? row->needs : "");
        if (!is_read)
            return lf_error_set(err, LF_E_ARG, on_line ? name : where,
                                "%s%shas no effect on %s; leave it out", on_line ? "" : name,
                                on_line ? "" : " ", what);
        return lf_error_set(err, LF_E_ARG, on_line ? name : where,
                            "%s%shas no effect without %s; add it, or leave this out",
                            on_line ? "" : name, on_line ? "" : " ", needed);
    }
    return LF_OK;
}

/* NULL: no known ending. */
static const char *ending_of(const lf_output_kind *kind, const char *path)
{
    int i = 0;
    while (kind->endings[i] && !lf_path_has_ending(path, kind->endings[i]))
        i++;
    return kind->endings[i];
}

bool lf_output_fits(const lf_output_kind *kind, const char *path)
{
    return ending_of(kind, path);
}

char *lf_output_endings(const lf_output_kind *kind, char *buf, size_t size)
{
    buf[0] = '\0';
    for (int i = 0; kind->endings[i]; i++) {
        size_t used = strlen(buf);
        const char *between = i == 0 ? "" : kind->endings[i + 1] ? ", " : " or ";
        snprintf(buf + used, size - used, "%s%s", between, kind->endings[i]);
    }
    return buf;
}

bool lf_output_is_light(const lf_output_kind *kind, const char *path)
{
    return kind->is_linear || lf_path_has_ending(path, ".exr");
}

lf_status lf_output_path(const lf_output_kind *kind, const char *path, const lf_layout *layout,
                         char **out_path, lf_error *err)
{
    char endings[64];
    const char *ending = ending_of(kind, path);
    if (!ending)
        return lf_error_set(err, LF_E_ARG, path, "the name of %s must end in %s", kind->what,
                            lf_output_endings(kind, endings, sizeof endings));
    lf_status status =
        strcmp(ending, "/") == 0 ? lf_check_name(path, err) : lf_check_stem(path, ending, err);
    if (status != LF_OK)
        return status;
    if (kind->complete)
        return kind->complete(path, layout, out_path, err);
    *out_path = lf_strdup(path);
    return *out_path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

char *lf_output_file_name(const lf_output_kind *kind, const char *path, int i)
{
    return kind->file_name ? kind->file_name(path, i) : lf_strdup(path);
}

int lf_output_n_files(const lf_output_kind *kind, const lf_print *print, int n_views)
{
    if (kind->count && print)
        return kind->count(print);
    return kind->n_files > 0 ? kind->n_files : n_views;
}

/* ------------------------------------------------------------------------------------- files -- */

/* The files of one job, opened and published together. Zeroed is a valid empty set. */
typedef struct output_files {
    int n;
    lf_outfile *file; /* [n] */
} output_files;

/* For a job that fails before its files are opened. */
static void close_fds(const lf_output_request *request)
{
    for (int i = 0; i < request->n_fds; i++)
        close(request->fds[i]);
}

/* Accepts zeroed and committed sets. */
static void abandon(output_files *files)
{
    for (int i = 0; i < files->n; i++)
        lf_outfile_abandon(&files->file[i]);
    lf_free(files->file);
    *files = (output_files){0};
}

static lf_status open_one(lf_outfile *file, const lf_output_request *request, int i, lf_error *err)
{
    if (request->n_fds == 0) {
        char *path = lf_output_file_name(request->kind, request->path, i);
        lf_status status = path ? lf_outfile_open(file, path, request->overwrite, err)
                                : lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
        lf_free(path);
        file->pool = request->pool;
        return status;
    }
    lf_status status = lf_outfile_adopt(file, request->fds[i], err);
    file->pool = request->pool;
    if (status != LF_OK)
        close(request->fds[i]);
    return status;
}

/* Opens n files, or takes ownership of request->fds, which must be n. On failure nothing is open,
 * and the fds are closed. */
static lf_status open_all(output_files *files, const lf_output_request *request, int n,
                          lf_error *err)
{
    lf_status status = LF_OK;
    *files = (output_files){.file = lf_calloc((size_t)n, sizeof *files->file)};
    if (!files->file) {
        close_fds(request);
        return lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    }
    if (request->n_fds != 0 && request->n_fds != n) {
        close_fds(request);
        abandon(files);
        return lf_error_set(err, LF_E_ARG, request->path, "expects %d file descriptors, got %d", n,
                            request->n_fds);
    }
    for (int i = 0; i < n && status == LF_OK; i++) {
        status = open_one(&files->file[i], request, i, err);
        files->n += status == LF_OK;
    }
    if (status != LF_OK) {
        for (int i = files->n + 1; i < request->n_fds; i++)
            close(request->fds[i]);
        abandon(files);
    }
    return status;
}

static lf_status publish(output_files *files, const lf_output_request *request, lf_error *err)
{
    lf_status status = output_check_cancel(request, err);
    for (int i = 0; i < files->n && status == LF_OK; i++)
        status = lf_outfile_commit(&files->file[i], request->overwrite, err);
    return status;
}

static lf_status make_folder(const lf_output_request *request, int n, bool *out_made, lf_error *err)
{
    *out_made = mkdir(request->path, 0777) == 0;
    if (*out_made)
        return LF_OK;
    if (errno != EEXIST)
        return lf_error_set(err, LF_E_IO, request->path, "cannot make the folder: %s",
                            strerror(errno));
    if (!request->overwrite && request->kind->surplus(request->path, n, false) > 0)
        return lf_error_set(err, LF_E_EXISTS, request->path,
                            "the folder already holds more than %d views; choose another folder or "
                            "pass overwrite=true",
                            n);
    return LF_OK;
}

lf_status output_check_cancel(const lf_output_request *request, lf_error *err)
{
    if (request->cancel && atomic_load_explicit(request->cancel, memory_order_relaxed))
        return lf_error_set(err, LF_E_CANCELLED, request->path, "cancelled");
    return LF_OK;
}

void output_progress(const lf_output_request *request, double fraction)
{
    if (request->progress)
        request->progress(request->context, fraction);
}

/* --------------------------------------------------------------------------------------- job -- */

lf_output_source lf_output_from_quilt(const lf_quilt_file *quilt, const char *file)
{
    return (lf_output_source){.is_float = quilt->is_float,
                              .views8 = quilt->views8,
                              .views32 = quilt->views32,
                              .aspect = quilt->layout.aspect,
                              .file = file,
                              .notes = &quilt->notes};
}

lf_output_source lf_output_from_film(const lf_render_settings *settings, const float *film)
{
    const int n_views = lf_camera_views(&settings->camera);
    size_t width = (size_t)settings->width * 3;
    return (lf_output_source){.is_float = true,
                              .views32 = {.n_views = n_views,
                                          .width = settings->width,
                                          .height = settings->height,
                                          .view_stride = width,
                                          .row_stride = width * (size_t)n_views,
                                          .data = film},
                              .aspect = settings->camera.aspect};
}

static int views_of(const lf_output_source *source)
{
    return source->is_float ? source->views32.n_views : source->views8.n_views;
}

lf_status lf_output_write(const lf_output_request *request, const lf_output_source *source,
                          lf_error *err)
{
    const lf_output_kind *kind = request->kind;
    const bool in_folder = kind->surplus && request->n_fds == 0;
    const int n = lf_output_n_files(kind, request->print, source ? views_of(source) : 0);
    output_files files = {0};
    bool made = false;
    lf_status status = output_check_cancel(request, err);
    if (status != LF_OK) {
        close_fds(request);
        return status;
    }
    if (in_folder)
        status = make_folder(request, n, &made, err);
    if (status == LF_OK)
        status = open_all(&files, request, n, err);
    if (status == LF_OK)
        status = kind->write(request, source, files.file, err);
    if (status == LF_OK)
        status = publish(&files, request, err);
    abandon(&files);
    if (status == LF_OK && in_folder)
        kind->surplus(request->path, n, true);
    if (status != LF_OK && made)
        rmdir(request->path);
    if (status == LF_OK)
        output_progress(request, 1);
    return status;
}
