/* A folder of views: view_000.exr, view_001.exr, … Each file becomes visible whole, and none before
 * all are written. */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

typedef struct view_paths {
    int n;
    char *text;        /* [n][stride] */
    const char **path; /* [n] into text */
} view_paths;

static void view_paths_finish(view_paths *paths)
{
    lf_free(paths->text);
    lf_free(paths->path);
}

static lf_status view_paths_init(view_paths *paths, const char *folder, int n, lf_error *err)
{
    size_t stride = strlen(folder) + sizeof "/view_000000.exr";
    *paths = (view_paths){
        .n = n, .text = lf_calloc((size_t)n, stride), .path = lf_calloc((size_t)n, sizeof(char *))};
    if (!paths->text || !paths->path) {
        view_paths_finish(paths);
        return lf_error_set(err, LF_E_NOMEM, folder, "out of memory");
    }
    for (int i = 0; i < n; i++) {
        char *path = paths->text + (size_t)i * stride;
        const char *slash = folder[0] != '\0' && folder[strlen(folder) - 1] != '/' ? "/" : "";
        snprintf(path, stride, "%s%sview_%03d.exr", folder, slash, i);
        paths->path[i] = path;
    }
    return LF_OK;
}

/* The number in "view_NNN.exr", else -1. */
static int view_number(const char *name)
{
    int number = -1;
    char again[32];
    if (sscanf(name, "view_%d", &number) != 1 || number < 0)
        return -1;
    snprintf(again, sizeof again, "view_%03d.exr", number);
    return strcmp(name, again) == 0 ? number : -1;
}

/* Views numbered n and above would make another light field of the folder: they are counted, or
 * removed. */
static int surplus_views(const char *folder, int n, bool remove)
{
    DIR *dir = opendir(folder);
    int count = 0;
    if (!dir)
        return 0;
    for (const struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        if (view_number(entry->d_name) < n)
            continue;
        count++;
        if (remove)
            unlinkat(dirfd(dir), entry->d_name, 0);
    }
    closedir(dir);
    return count;
}

static lf_status make_folder(const lf_output_request *request, int n_views, bool *out_made,
                             lf_error *err)
{
    *out_made = false;
    if (mkdir(request->path, 0777) == 0) {
        *out_made = true;
        return LF_OK;
    }
    if (errno != EEXIST)
        return lf_error_set(err, LF_E_IO, request->path, "cannot make the folder: %s",
                            strerror(errno));
    if (!request->overwrite && surplus_views(request->path, n_views, false) > 0)
        return lf_error_set(err, LF_E_EXISTS, request->path,
                            "the folder holds more than %d views already", n_views);
    return LF_OK;
}

static lf_status write_view(const lf_output_request *request, const lf_views32 *views, int view,
                            lf_image32 *image, const output_attributes *attributes,
                            lf_outfile *file, lf_error *err)
{
    size_t n = (size_t)views->width * 3;
    lf_status status = output_check_cancel(request, err);
    if (status != LF_OK)
        return status;
    for (int row = 0; row < views->height; row++)
        memcpy(image->data + (size_t)row * n, lf_views32_row(views, view, row), n * sizeof(float));
    return lf_exr_write(file, image, attributes->list, attributes->n, err);
}

static lf_status write_all(const lf_output_request *request, const lf_views32 *views,
                           output_files *files, lf_error *err)
{
    output_attributes attributes;
    lf_image32 image = {0};
    lf_status status = lf_image32_init(&image, views->width, views->height, 3);
    if (status != LF_OK)
        return lf_error_set(err, status, request->path, "no memory for a view of %dx%d pixels",
                            views->width, views->height);
    output_attributes_fill(&attributes, request->settings);
    for (int view = 0; view < views->n_views && status == LF_OK; view++) {
        status = write_view(request, views, view, &image, &attributes, &files->file[view], err);
        output_progress(request, (view + 1.0) / (views->n_views + 1.0));
    }
    lf_image32_finish(&image);
    return status;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             output_files *files, lf_error *err)
{
    lf_views32 views;
    float *buffer = NULL;
    lf_status status = output_views32(request, source, &views, &buffer, err);
    if (status == LF_OK)
        status = write_all(request, &views, files, err);
    lf_free(buffer);
    if (status == LF_OK)
        status = output_files_commit(files, request, err);
    output_files_abandon(files);
    return status;
}

lf_status output_write_views(const lf_output_request *request, const lf_output_source *source,
                             lf_error *err)
{
    int n_views = source->is_float ? source->views32.n_views : source->views8.n_views;
    output_files files = {0};
    view_paths paths = {0};
    bool made = false;
    lf_status status = LF_OK;
    if (request->n_fds == 0) {
        status = make_folder(request, n_views, &made, err);
        if (status == LF_OK)
            status = view_paths_init(&paths, request->path, n_views, err);
    }
    if (status == LF_OK)
        status = output_files_open(&files, request, n_views, paths.path, err);
    if (status == LF_OK)
        status = write_files(request, source, &files, err);
    if (status == LF_OK && request->n_fds == 0)
        surplus_views(request->path, n_views, true);
    if (status != LF_OK && made)
        rmdir(request->path);
    if (request->n_fds == 0)
        view_paths_finish(&paths);
    if (status == LF_OK)
        output_progress(request, 1);
    return status;
}
