/* Lenticular prints: the views that they need, and the TIFF with its manifest. */
#include <math.h>

#include "base/alloc.h"
#include "daemon/output/output_internal.h"

/* The column of cameras that horizontal lenses want: the rig rolled by 90 degrees, see
 * lf_print_shape_of. */
static void roll(lf_camera *camera, double width_over_height)
{
    double forward[3];
    double right[3];
    for (int k = 0; k < 3; k++)
        forward[k] = camera->target[k] - camera->position[k];
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3;
        int b = (k + 2) % 3;
        right[k] = forward[a] * camera->up[b] - forward[b] * camera->up[a];
    }
    double length = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    for (int k = 0; k < 3 && length > 0; k++)
        camera->up[k] = right[k] / length;
    camera->fov_y = 2 * atan(tan(0.5 * camera->fov_y) * width_over_height);
}

void lf_output_print_view(const lf_print *print, lf_render_settings *settings)
{
    lf_print rendered = *print;
    lf_print_shape shape;
    /* the trim size as the rig sees it: across the picture and up */
    double width = print->horizontal ? print->height_mm : print->width_mm;
    double height = print->horizontal ? print->width_mm : print->height_mm;
    rendered.rolled = print->horizontal;
    lf_print_shape_of(&rendered, &shape);
    if (print->horizontal)
        roll(&settings->camera, print->width_mm / print->height_mm);
    settings->camera.n_views = print->n_views;
    settings->camera.aspect = width / height;
    settings->width = shape.view_width;
    settings->height = shape.view_height;
    double left = shape.window_center_x_mm - 0.5 * shape.window_width_mm;
    double top = shape.window_center_y_mm - 0.5 * shape.window_height_mm;
    settings->window[0] = 0.5 + left / width;
    settings->window[1] = 0.5 + top / height;
    settings->window[2] = 0.5 + (left + shape.window_width_mm) / width;
    settings->window[3] = 0.5 + (top + shape.window_height_mm) / height;
}

static lf_status write_picture(const lf_output_request *request, const lf_output_source *source,
                               const lf_print_run *run, const output_files *files, lf_error *err)
{
    lf_print print = *request->print;
    lf_views32 views;
    float *decoded = NULL;
    lf_status status = output_views32(request, source, &views, &decoded, err);
    if (!(print.view_aspect > 0))
        print.view_aspect = source->aspect;
    if (status == LF_OK)
        status = lf_print_write(&print, &views, run, &files->file[0], &files->file[1], err);
    lf_free(decoded);
    return status;
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             output_files *files, lf_error *err)
{
    const bool is_chart = request->kind == LF_OUTPUT_CHART;
    const bool is_float = !is_chart && source->is_float;
    const lf_print_run run = {.exposure = is_float ? request->exposure : 0,
                              .tonemap = is_float ? request->tonemap : NULL,
                              .settings = request->settings,
                              .cancel = request->cancel,
                              .progress = request->progress,
                              .context = request->context};
    lf_status status =
        is_chart ? lf_chart_write(request->print, &run, &files->file[0], &files->file[1], err)
                 : write_picture(request, source, &run, files, err);
    if (status == LF_OK)
        status = output_files_commit(files, request, err);
    output_files_abandon(files);
    return status;
}

lf_status output_write_print(const lf_output_request *request, const lf_output_source *source,
                             lf_error *err)
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
