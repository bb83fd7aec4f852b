/* Lenticular prints: their views, and the TIFF or PDF with its manifest. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/output/content.h"
#include "daemon/output/output_internal.h"

/* Rolls the rig by 90 degrees to a column of cameras for horizontal lenses, see
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
    camera->rolled = true;
}

void lf_output_print_view(const lf_print *print, lf_render_settings *settings)
{
    lf_print rendered = *print;
    lf_print_shape shape;
    /* trim size in the rig's picture: across and up */
    double width = print->horizontal ? print->height_mm : print->width_mm;
    double height = print->horizontal ? print->width_mm : print->height_mm;
    if (print->frame_ppi > 0)
        rendered = lf_frame_set_print(print);
    rendered.rolled = print->horizontal;
    lf_print_shape_of(&rendered, &shape);
    if (print->horizontal)
        roll(&settings->camera, print->width_mm / print->height_mm);
    settings->camera.n_views = print->n_views / lf_print_view_rows(print);
    settings->camera.track = 0.0;
    settings->camera.n_rows = 0;
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

void lf_output_print_rig(const lf_print *print, lf_camera *camera)
{
    if (!lf_print_is_micro(print))
        return;
    double distance = 0;
    for (int k = 0; k < 3; k++)
        distance +=
            (camera->target[k] - camera->position[k]) * (camera->target[k] - camera->position[k]);
    /* the whole width of a lens shows the cone; a hexagon is higher than wide */
    const double reach = 2 * sqrt(distance) * tan(0.5 * camera->cone),
                 height = print->optics.grid == LF_LENS_HEXAGONAL ? 2 / sqrt(3) : 1;
    const int rows = lf_print_view_rows(print), columns = camera->n_views;
    camera->n_rows = rows;
    camera->track = reach * (columns - 1) / columns;
    camera->rows_height = reach * height * (rows - 1) / rows;
    camera->own_windows = false;
}

char *output_print_file(const char *path, int i)
{
    return i == 0 ? lf_strdup(path) : lf_path_beside(path, i == 1 ? ".json" : "_relief.tif");
}

static int count_files(const lf_print *print)
{
    return lf_output_print.n_files + print->relief;
}

lf_print_format lf_output_print_format(const char *path)
{
    return lf_path_has_ending(path, ".pdf") ? LF_PRINT_PDF : LF_PRINT_TIFF;
}

lf_print_run output_print_run(const lf_output_request *request)
{
    return (lf_print_run){.format = lf_output_print_format(request->path),
                          .pool = request->pool,
                          .settings = request->settings,
                          .witness = request->witness,
                          .cancel = request->cancel,
                          .progress = request->progress,
                          .context = request->context};
}

/* Adds the warnings of the manifest: earlier notes about the picture, and its placement, which is
 * also logged. */
static void note_laid(const lf_output_request *request, const lf_output_source *source,
                      const lf_print *print, const lf_views32 *views, lf_image_notes *out)
{
    const char *name = source->file ? source->file : request->path;
    lf_image_notes laid = {0};
    char line[512];
    lf_print_note_laid(print, views, &laid);
    lf_print_note_sheet(print, views->n_views, &laid);
    lf_log_notes(&laid, name);
    for (size_t at = 0;
         source->notes && lf_image_notes_next(source->notes, &at, line, sizeof line);)
        lf_image_note(out, "%s: %s", name, line);
    for (size_t at = 0; lf_image_notes_next(&laid, &at, line, sizeof line);)
        lf_image_note(out, "%s: %s", name, line);
}

/* Bands that an eye hardly sees, as a fraction of white. */
#define BANDS 0.001

/* What compensation took back, and what it left. */
static void log_left(const lf_output_request *request, const lf_print_left *left)
{
    if (left->compensated)
        lf_log(LF_LOG_INFO,
               "%s: compensated: ghosts of %.2g %% of white are %.2g %% (worst %.2g %%, was "
               "%.2g %%); %.2g %% of the dots are at the end of the gamut",
               request->path, 100.0 * left->ghost_before, 100.0 * left->ghost, 100.0 * left->worst,
               100.0 * left->worst_before, 100.0 * left->clamped);
    if (left->compensated && left->between > fmax(BANDS, left->between_before))
        lf_log(LF_LOG_WARNING,
               "%s: eyes between two views see bands of %.2g %% of white, %.2g %% without "
               "compensation; fewer views make them weaker",
               request->path, 100.0 * left->between, 100.0 * left->between_before);
}

static lf_status write_files(const lf_output_request *request, const lf_output_source *source,
                             lf_outfile *files, lf_error *err)
{
    lf_print print = *request->print;
    lf_print_run run = output_print_run(request);
    float light[256];
    lf_views32 views = output_views32(source, light);
    if (source->is_float) {
        run.exposure = request->exposure;
        run.tonemap = request->tonemap;
    }
    if (!(print.view_aspect > 0))
        print.view_aspect = source->aspect;
    lf_image_notes notes = {0};
    const lf_print laid = print.frame_ppi > 0 ? lf_frame_set_print(&print) : print;
    note_laid(request, source, &laid, &views, &notes);
    run.notes = &notes;
    run.relief = print.relief ? &files[2] : NULL;
    lf_print_left left = {0};
    run.out_left = &left;
    double ink = 0;
    run.out_ink = &ink;
    const lf_status status = print.frame_ppi > 0
                                 ? lf_frame_set_write(&print, &views, &run, files, err)
                                 : lf_print_write(&print, &views, &run, &files[0], &files[1], err);
    if (status == LF_OK && ink > 0)
        lf_log(LF_LOG_INFO,
               "%s: the densest colour has %.0f %% ink; compare it with the shop's limit",
               request->path, ink);
    if (status == LF_OK)
        log_left(request, &left);
    return status;
}

const char *const output_print_endings[] = {".tif", ".tiff", ".pdf", NULL};

const lf_output_kind lf_output_print = {.name = "print",
                                        .what = "a print",
                                        .rendered = LF_RENDERED_VIEWS,
                                        .endings = output_print_endings,
                                        .option = "print",
                                        .asks = "lpi, width and height (mm)",
                                        .n_files = 2,
                                        .count = count_files,
                                        .check_print = lf_print_check,
                                        .file_name = output_print_file,
                                        .write = write_files};

/* ------------------------------------------------------------------------------------ frames -- */

static char *frame_file(const char *folder, int i)
{
    char name[32];
    snprintf(name, sizeof name, "frame_%03d.tif", i - LF_FRAME_SET_TOLD + 1);
    return lf_path_join(folder, i == 0 ? "order.txt" : i == 1 ? "frames.json" : name);
}

static int count_frames(const lf_print *print)
{
    return LF_FRAME_SET_TOLD + print->n_views;
}

static lf_status check_frames(const lf_print *print, const char **out_warning, lf_error *err)
{
    if (out_warning)
        *out_warning = NULL;
    return lf_frame_set_check(print, err);
}

/* Counts or removes frames beyond the first n files. */
static int surplus_frames(const char *folder, int n, bool remove)
{
    int count = 0;
    for (int i = n; i < LF_FRAME_SET_TOLD + LF_MAX_VIEWS; i++) {
        char *name = frame_file(folder, i);
        if (name && access(name, F_OK) == 0) {
            count++;
            if (remove)
                unlink(name);
        }
        lf_free(name);
    }
    return count;
}

static const char *const folder_endings[] = {"/", NULL};

const lf_output_kind lf_output_frame_set = {.name = "frames",
                                            .what = "a frame set",
                                            .endings = folder_endings,
                                            .option = "frame-set",
                                            .asks = "lpi, width and height (mm)",
                                            .count = count_frames,
                                            .reads = "print print-size frame-set orientation slant "
                                                     "lens-grid view-rows map thickness index "
                                                     "radius viewing-angle distance bleed icc bits "
                                                     "compress",
                                            .check_print = check_frames,
                                            .file_name = frame_file,
                                            .write = write_files,
                                            .surplus = surplus_frames};
