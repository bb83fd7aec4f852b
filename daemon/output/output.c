#include "daemon/output/output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

#define MAX_PICTURE_SIDE 65536
#define MAX_PICTURE_SAMPLES (INT64_C(1) << 31)

/* ------------------------------------------------------------------------------------- names -- */

static lf_status find_name(const char *what, const char *const *names, int n, const char *name,
                           int *out, lf_error *err)
{
    char known[128] = "";
    for (int i = 0; i < n; i++) {
        if (strcmp(name, names[i]) == 0) {
            *out = i;
            return LF_OK;
        }
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i > 0 ? ", " : "", names[i]);
    }
    return lf_error_set(err, LF_E_ARG, what, "unknown name \"%s\" (there are: %s)", name, known);
}

static const char *const kind_names[] = {[LF_OUTPUT_QUILT] = "quilt",
                                         [LF_OUTPUT_VIEWS] = "views",
                                         [LF_OUTPUT_PANEL] = "panel",
                                         [LF_OUTPUT_PRINT] = "print",
                                         [LF_OUTPUT_CHART] = "chart"};
static const char *const filter_names[] = {
    [LF_FILTER_NEAREST] = "nearest", [LF_FILTER_LINEAR] = "linear"};
static const char *const invert_names[] = {
    [LF_INVERT_AUTO] = "auto", [LF_INVERT_YES] = "yes", [LF_INVERT_NO] = "no"};

#define COUNT(array) ((int)(sizeof(array) / sizeof((array)[0])))

lf_status lf_output_kind_from_name(const char *name, lf_output_kind *out, lf_error *err)
{
    int index = 0;
    lf_status status = find_name("kind", kind_names, COUNT(kind_names), name, &index, err);
    if (status == LF_OK)
        *out = (lf_output_kind)index;
    return status;
}

const char *lf_output_kind_name(lf_output_kind kind)
{
    return kind_names[kind];
}

lf_status lf_filter_from_name(const char *name, lf_filter *out, lf_error *err)
{
    int index = 0;
    lf_status status = find_name("filter", filter_names, COUNT(filter_names), name, &index, err);
    if (status == LF_OK)
        *out = (lf_filter)index;
    return status;
}

lf_status lf_invert_from_name(const char *name, lf_invert *out, lf_error *err)
{
    int index = 0;
    lf_status status = find_name("invert", invert_names, COUNT(invert_names), name, &index, err);
    if (status == LF_OK)
        *out = (lf_invert)index;
    return status;
}

/* ------------------------------------------------------------------------------------- paths -- */

bool output_has_ending(const char *text, const char *ending)
{
    size_t n = strlen(text);
    size_t m = strlen(ending);
    return n >= m && strcasecmp(text + n - m, ending) == 0;
}

static lf_status check_quilt_size(const char *path, const lf_layout *layout, lf_error *err)
{
    int64_t width = (int64_t)layout->columns * layout->view_width;
    int64_t height = (int64_t)layout->rows * layout->view_height;
    if (width > MAX_PICTURE_SIDE || height > MAX_PICTURE_SIDE ||
        width * height * 3 > MAX_PICTURE_SAMPLES)
        return lf_error_set(err, LF_E_ARG, path,
                            "a quilt of %dx%d views of %dx%d pixels is too large for one picture "
                            "(write a folder of views: OUT/)",
                            layout->columns, layout->rows, layout->view_width, layout->view_height);
    return LF_OK;
}

static lf_status quilt_path(const char *path, const lf_layout *layout, char **out_path,
                            lf_error *err)
{
    int columns = 0;
    int rows = 0;
    double aspect = 0;
    lf_status status = check_quilt_size(path, layout, err);
    if (status != LF_OK)
        return status;
    if (lf_layout_from_name(path, &columns, &rows, &aspect)) {
        if (columns != layout->columns || rows != layout->rows)
            return lf_error_set(
                err, LF_E_ARG, path,
                "the name says %dx%d tiles, but the quilt has %dx%d (--quilt changes them)",
                columns, rows, layout->columns, layout->rows);
        if (aspect > 0 && fabs(aspect - layout->aspect) > 0.01 * layout->aspect)
            return lf_error_set(err, LF_E_ARG, path,
                                "the name says an aspect of %g, but the views have %g", aspect,
                                layout->aspect);
        *out_path = lf_strdup(path);
    } else {
        *out_path = lf_layout_name(path, layout);
    }
    return *out_path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

lf_status lf_output_path(lf_output_kind kind, const char *path, const lf_layout *layout,
                         char **out_path, lf_error *err)
{
    static const char *const endings[][2] = {[LF_OUTPUT_QUILT] = {".png", ".exr"},
                                             [LF_OUTPUT_VIEWS] = {"/", "/"},
                                             [LF_OUTPUT_PANEL] = {".png", ".png"},
                                             [LF_OUTPUT_PRINT] = {".tif", ".tiff"},
                                             [LF_OUTPUT_CHART] = {".tif", ".tiff"}};
    static const char *const wanted[] = {[LF_OUTPUT_QUILT] = "a quilt ends in .png or .exr",
                                         [LF_OUTPUT_VIEWS] = "a folder of views ends in /",
                                         [LF_OUTPUT_PANEL] = "a panel picture ends in .png",
                                         [LF_OUTPUT_PRINT] = "a print ends in .tif",
                                         [LF_OUTPUT_CHART] = "a chart ends in .tif"};
    if (!output_has_ending(path, endings[kind][0]) && !output_has_ending(path, endings[kind][1]))
        return lf_error_set(err, LF_E_ARG, path, "%s", wanted[kind]);
    if (kind == LF_OUTPUT_QUILT)
        return quilt_path(path, layout, out_path, err);
    *out_path = lf_strdup(path);
    return *out_path ? LF_OK : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
}

char *lf_output_manifest_path(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(path, '.');
    size_t stem = dot && (!slash || dot > slash) ? (size_t)(dot - path) : strlen(path);
    char *manifest = lf_calloc(stem + sizeof ".json", 1);
    if (manifest) {
        memcpy(manifest, path, stem);
        memcpy(manifest + stem, ".json", sizeof ".json");
    }
    return manifest;
}

/* ------------------------------------------------------------------------------------- files -- */

void output_close_fds(const lf_output_request *request)
{
    for (int i = 0; i < request->n_fds; i++)
        close(request->fds[i]);
}

void output_files_abandon(output_files *files)
{
    for (int i = 0; i < files->n; i++)
        lf_outfile_abandon(&files->file[i]);
    lf_free(files->file);
    *files = (output_files){0};
}

static lf_status open_one(lf_outfile *file, const lf_output_request *request, int i,
                          const char *const *paths, lf_error *err)
{
    if (request->n_fds == 0)
        return lf_outfile_open(file, paths[i], request->overwrite, err);
    lf_status status = lf_outfile_adopt(file, request->fds[i], err);
    if (status != LF_OK)
        close(request->fds[i]);
    return status;
}

lf_status output_files_open(output_files *files, const lf_output_request *request, int n,
                            const char *const *paths, lf_error *err)
{
    lf_status status = LF_OK;
    *files = (output_files){.file = lf_calloc((size_t)n, sizeof *files->file)};
    if (!files->file) {
        output_close_fds(request);
        return lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    }
    if (request->n_fds != 0 && request->n_fds != n) {
        output_close_fds(request);
        output_files_abandon(files);
        return lf_error_set(err, LF_E_ARG, request->path, "expects %d descriptors, not %d", n,
                            request->n_fds);
    }
    for (int i = 0; i < n && status == LF_OK; i++) {
        status = open_one(&files->file[i], request, i, paths, err);
        files->n += status == LF_OK;
    }
    if (status != LF_OK) {
        for (int i = files->n + 1; i < request->n_fds; i++)
            close(request->fds[i]);
        output_files_abandon(files);
    }
    return status;
}

lf_status output_files_commit(output_files *files, const lf_output_request *request, lf_error *err)
{
    lf_status status = output_check_cancel(request, err);
    for (int i = 0; i < files->n && status == LF_OK; i++)
        status = lf_outfile_commit(&files->file[i], request->overwrite, err);
    output_files_abandon(files);
    return status;
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

lf_output_source lf_output_from_quilt(const lf_quilt_file *quilt)
{
    return (lf_output_source){.is_float = quilt->is_float,
                              .views8 = quilt->views8,
                              .views32 = quilt->views32,
                              .aspect = quilt->layout.aspect};
}

lf_output_source lf_output_from_film(const lf_render_settings *settings, const float *film)
{
    size_t width = (size_t)settings->width * 3;
    return (lf_output_source){.is_float = true,
                              .views32 = {.n_views = settings->camera.n_views,
                                          .width = settings->width,
                                          .height = settings->height,
                                          .view_stride = width,
                                          .row_stride = width * (size_t)settings->camera.n_views,
                                          .data = film},
                              .aspect = settings->camera.aspect};
}

lf_status lf_output_write(const lf_output_request *request, const lf_output_source *source,
                          lf_error *err)
{
    lf_status status = output_check_cancel(request, err);
    if (status != LF_OK) {
        output_close_fds(request);
        return status;
    }
    switch (request->kind) {
    case LF_OUTPUT_VIEWS:
        return output_write_views(request, source, err);
    case LF_OUTPUT_PANEL:
        return output_write_panel(request, source, err);
    case LF_OUTPUT_PRINT:
    case LF_OUTPUT_CHART:
        return output_write_print(request, source, err);
    case LF_OUTPUT_QUILT:
        break;
    }
    return output_write_quilt(request, source, err);
}
