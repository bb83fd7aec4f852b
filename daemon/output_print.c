/* Lenticular prints: the views that they need, and the TIFF with its manifest. */
#include <string.h>

#include "base/alloc.h"
#include "daemon/output_internal.h"

void lf_output_print_view(const lf_print *print, lf_render_settings *settings)
{
    lf_print_shape shape;

    lf_print_shape_of(print, &shape);
    settings->camera.n_views = print->n_views;
    settings->camera.aspect = print->width_mm / print->height_mm;
    settings->width = shape.view_width;
    settings->height = shape.view_height;
    double left = shape.window_center_x_mm - 0.5 * shape.window_width_mm;
    double top = shape.window_center_y_mm - 0.5 * shape.window_height_mm;
    settings->window[0] = 0.5 + left / print->width_mm;
    settings->window[1] = 0.5 + top / print->height_mm;
    settings->window[2] = 0.5 + (left + shape.window_width_mm) / print->width_mm;
    settings->window[3] = 0.5 + (top + shape.window_height_mm) / print->height_mm;
}

/* The views of source that the print shows: all, or as many as it has, spread evenly over the cone. */
static lf_status pick_views(const lf_output_request *request, const lf_views32 *in, lf_views32 *out, float **out_buffer,
                            lf_error *err)
{
    int n = request->print->n_views;
    size_t width = (size_t)in->width * 3;

    *out_buffer = NULL;
    *out = *in;
    if (n == in->n_views)
        return LF_OK;
    if (n > in->n_views)
        return lf_error_set(err, LF_E_ARG, request->path, "the print asks for %d views, but there are only %d", n, in->n_views);
    float *buffer = lf_calloc((size_t)in->height, (size_t)n * width * sizeof(float));
    if (!buffer)
        return lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    for (int row = 0; row < in->height; row++) {
        for (int view = 0; view < n; view++) {
            int from = (int)(((2 * (int64_t)view + 1) * in->n_views) / (2 * (int64_t)n));
            memcpy(buffer + ((size_t)row * (size_t)n + (size_t)view) * width, lf_views32_row(in, from, row), width * sizeof(float));
        }
    }
    *out_buffer = buffer;
    *out = (lf_views32){n, in->width, in->height, width, (size_t)n * width, buffer};
    return LF_OK;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source, output_files *files, lf_error *err)
{
    lf_views32 all;
    lf_views32 views;
    float *decoded = NULL;
    float *picked = NULL;
    double exposure = source->is_float ? request->exposure : 0;
    const char *tonemap = source->is_float && request->tonemap ? request->tonemap : "srgb";
    lf_status status = output_views32(request, source, &all, &decoded, err);

    if (status == LF_OK)
        status = pick_views(request, &all, &views, &picked, err);
    if (status == LF_OK)
        status = lf_print_write(request->print, &views, exposure, tonemap, request->settings, &files->file[0], &files->file[1],
                                request->cancel, request->progress, request->context, err);
    lf_free(picked);
    lf_free(decoded);
    if (status == LF_OK)
        status = output_files_commit(files, request, err);
    output_files_abandon(files);
    return status;
}

lf_status output_write_print(const lf_output_request *request, const lf_output_source *source, lf_error *err)
{
    output_files files = {0};
    char *manifest = lf_output_manifest_path(request->path);
    const char *paths[2] = {request->path, manifest};
    lf_status status = LF_OK;

    if (!manifest) {
        output_close_fds(request);
        return lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    }
    status = output_files_open(&files, request, 2, paths, err);
    if (status == LF_OK)
        status = write_files(request, source, &files, err);
    lf_free(manifest);
    if (status == LF_OK)
        output_progress(request, 1);
    return status;
}
