/* Exposure pictures of holograms: options, facts about the cameras, and files. */
#include "daemon/output/hologram.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/version.h"
#include "daemon/output/output_internal.h"

/* Shifts from direction to direction, in cells: docs/reference/holograms.md. */
#define SOFT_SHIFT 4.0
#define GHOST_SHIFT 8.0
/* Allowed difference between the shapes of a plate and of its grid of cells. */
#define MOST_STRETCH 0.02

static const char *const endings[] = {"/", NULL};

const lf_output_kind lf_output_hologram = {.name = "hologram",
                                           .what = "a hologram plate",
                                           .endings = endings,
                                           .option = "hologram",
                                           .n_files = 1};

/* ----------------------------------------------------------------------------------- options -- */

static const char *preset_at(int index)
{
    const lf_hologram_preset *preset = lf_hologram_preset_at(index);
    return preset ? preset->name : NULL;
}

static const char *what_preset_at(int index)
{
    const lf_hologram_preset *preset = lf_hologram_preset_at(index);
    return preset ? preset->what : NULL;
}

#define PLACE(field) .place = offsetof(lf_hologram_options, field)

/* clang-format off */
const lf_param lf_hologram_params[] = {
    {.option = "hologram", .argument = "FORM", PLACE(form), .type = LF_PARAM_WORD,
     .words = lf_plate_forms, .initial = -1,
     .help = "exposure pictures of a hologram plate, into the folder OUT"},
    {.option = "hologram-preset", .argument = "NAME", PLACE(preset), .type = LF_PARAM_NAME,
     .word_at = preset_at, .what_at = what_preset_at, .initial = -1,
     .help = "cameras that a printer of holograms needs"},
    {.option = "plate-size", .joined = "x", .argument = "W", PLACE(width_mm), .unit = "mm",
     .low = 1, .high = 10000, .help = "size of the plate in mm"},
    {.option = "plate-size", .argument = "H", PLACE(height_mm), .low = 1, .high = 10000},
    {.option = "plate-format", .argument = "FORMAT", PLACE(format), .type = LF_PARAM_WORD,
     .words = lf_plate_formats,
     .help = "samples of a plate: 8-bit sRGB, 16-bit sRGB or linear halfs"},
    {.option = "plate-grey", PLACE(is_grey), .type = LF_PARAM_SWITCH,
     .help = "linear luminance instead of colours; with tiff or exr"},
    {.option = "flip", .argument = "LIST", PLACE(flip), .type = LF_PARAM_TEXT,
     .help = "flips of a plate: u, v, hx, hy, transpose, rotate180"},
    {0},
};
/* clang-format on */

lf_status lf_hologram_check(const lf_hologram_options *options, lf_error *err)
{
    lf_plate_flips flips;
    if (options->is_grey && options->format == LF_PLATE_PNG)
        return lf_error_set(err, LF_E_ARG, "--plate-grey",
                            "is linear and needs 16 bits; add --plate-format tiff or exr");
    return lf_plate_flips_read(options->flip ? options->flip : "", &flips, err);
}

/* --------------------------------------------------------------------------------------- rig -- */

static bool is_cell(const lf_camera *camera)
{
    return camera->track > 0 && camera->own_windows;
}

static double distance_of(const lf_camera *camera)
{
    const double *p = camera->position, *t = camera->target;
    return sqrt((t[0] - p[0]) * (t[0] - p[0]) + (t[1] - p[1]) * (t[1] - p[1]) +
                (t[2] - p[2]) * (t[2] - p[2]));
}

/* Cameras of a row, and rows. */
static int columns_of(const lf_camera *camera)
{
    return camera->has_parts ? lf_camera_views(camera) : camera->n_views;
}

static int rows_of(const lf_camera *camera)
{
    return camera->n_rows > 0 && !camera->has_parts ? camera->n_rows : 1;
}

/* Where camera k of a row is, from the middle of the row. */
static double place_of(const lf_camera *camera, int k)
{
    const int n = columns_of(camera);
    const double inner = n > 1 ? (double)k / (n - 1) - 0.5 : 0;
    if (camera->track > 0)
        return inner * camera->track;
    return distance_of(camera) *
           tan(camera->cone * (camera->inclusive ? inner : (k + 0.5) / n - 0.5));
}

/* The mean distance from camera to camera along a row and between rows; 0: there is one. */
static void find_spacing(const lf_camera *camera, double out[2])
{
    const int columns = columns_of(camera), rows = rows_of(camera);
    out[0] =
        columns > 1 ? (place_of(camera, columns - 1) - place_of(camera, 0)) / (columns - 1) : 0;
    out[1] = rows > 1 ? camera->rows_height / (rows - 1) : 0;
}

/* Width and height of the plate in scene units; 0: unknown, because there is one cell. */
static void find_plate(const lf_camera *camera, double out[2])
{
    if (is_cell(camera)) {
        find_spacing(camera, out);
        out[0] *= columns_of(camera);
        out[1] *= rows_of(camera);
        return;
    }
    out[1] = 2 * distance_of(camera) * tan(0.5 * camera->fov_y);
    out[0] = out[1] * camera->aspect;
}

/* The printer's hogels, if pixels of views are finer. */
static bool find_hogels(const lf_hologram_options *options, const lf_render_settings *settings,
                        int out[2])
{
    const lf_hologram_preset *preset = lf_hologram_preset_of(options);
    if (!preset || !(preset->pitch_mm > 0) || !(options->width_mm > 0))
        return false;
    out[0] = (int)fmax(1, round(options->width_mm / preset->pitch_mm));
    out[1] = (int)fmax(1, round(options->height_mm / preset->pitch_mm));
    return out[0] < settings->width && out[1] < settings->height;
}

/* Whether the options fit the cameras. */
static lf_status check_plate(const lf_hologram_options *options, const lf_render_settings *settings,
                             lf_error *err)
{
    double size[2];
    int hogels[2];
    if (is_cell(&settings->camera) && settings->height == 1)
        return lf_error_set(err, LF_E_ARG, "--view-size",
                            "cells need several rows of directions; for horizontal parallax only, "
                            "use one row of eyes (\"window\": \"shared\")");
    find_plate(&settings->camera, size);
    if (options->width_mm > 0 && size[0] > 0 && size[1] > 0 &&
        fabs(options->width_mm * size[1] / (options->height_mm * size[0]) - 1) > MOST_STRETCH)
        return lf_error_set(err, LF_E_ARG, "--plate-size",
                            "the grid of cells is %.4g times as wide as high, the plate %.4g "
                            "times; change one of them",
                            size[0] / size[1], options->width_mm / options->height_mm);
    if (find_hogels(options, settings, hogels) && options->form != LF_PLATE_VIEWS)
        return lf_error_set(err, LF_E_ARG, "--hologram-preset",
                            "the printer makes %dx%d hogels from finer pixels; use --hologram "
                            "views, or --view-size %dx%d",
                            hogels[0], hogels[1], hogels[0], hogels[1]);
    return LF_OK;
}

lf_status lf_hologram_plate(const lf_hologram_options *options, const lf_render_settings *settings,
                            lf_plate *out, lf_error *err)
{
    const lf_camera *camera = &settings->camera;
    lf_plate plate = {.columns = columns_of(camera),
                      .rows = rows_of(camera),
                      .width = settings->width,
                      .height = settings->height,
                      .parts = camera->has_parts ? camera->n_rows : 1,
                      .form = options->form,
                      .format = options->format,
                      .camera_is_cell = is_cell(camera),
                      .is_grey = options->is_grey};
    lf_status status = check_plate(options, settings, err);
    if (status == LF_OK)
        status = lf_plate_flips_read(options->flip ? options->flip : "", &plate.flips, err);
    if (status != LF_OK)
        return status;
    plate.microns[0] = (int)lround(1000 * options->width_mm);
    plate.microns[1] = (int)lround(1000 * options->height_mm);
    *out = plate;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- depth -- */

/* Cells in the plate: a direction is a pixel, and what is Z behind shifts by Z times its slope. */
static bool measure_cells(const lf_scene *scene, const lf_render_settings *settings,
                          lf_hologram_depth *out)
{
    const lf_camera *camera = &settings->camera;
    const double *position = camera->position, distance = distance_of(camera);
    double box[2][3], spacing[2], z[2] = {INFINITY, -INFINITY};
    find_spacing(camera, spacing);
    if (!(spacing[0] > 0) || !lf_scene_bounds(scene, NULL, box))
        return false;
    for (int corner = 0; corner < 8; corner++) {
        double along = 0;
        for (int i = 0; i < 3; i++)
            along += (box[corner >> i & 1][i] - position[i]) * (camera->target[i] - position[i]) /
                     distance;
        z[0] = fmin(z[0], along);
        z[1] = fmax(z[1], along);
    }
    const double slope = 2 * tan(0.5 * camera->fov_y) * camera->aspect / settings->width;
    out->nearest = z[0] * slope / spacing[0];
    out->farthest = z[1] * slope / spacing[0];
    return true;
}

/* From row to row, a shift is as much larger as steps of eyes are, in cells. */
static double vertical_of(const lf_render_settings *settings)
{
    const lf_camera *camera = &settings->camera;
    double spacing[2];
    find_spacing(camera, spacing);
    if (!(spacing[0] > 0) || !(spacing[1] > 0))
        return 0;
    const double pixel = settings->width / (camera->aspect * settings->height); /* high by wide */
    return is_cell(camera) ? pixel * spacing[0] / spacing[1] : spacing[1] / spacing[0] / pixel;
}

/* The cells of shifts, in pixels of views. */
static double pixels_a_cell(const lf_hologram_options *options, const lf_render_settings *settings)
{
    int hogels[2];
    return find_hogels(options, settings, hogels) ? (double)settings->width / hogels[0] : 1;
}

/* Eyes. */
static bool measure_views(const lf_scene *scene, const lf_render_settings *settings,
                          lf_hologram_depth *out)
{
    lf_render_settings row = *settings;
    lf_depth depth;
    if (columns_of(&row.camera) == 1) /* it has no shift from u to u */
        return false;
    if (row.camera.n_rows > 0)
        row.camera = lf_camera_row(&settings->camera, row.camera.n_rows / 2);
    if (!lf_scene_depth(scene, &row, &depth))
        return false;
    out->nearest = depth.nearest_step;
    out->farthest = depth.farthest_step;
    return true;
}

bool lf_hologram_measure(const lf_hologram_options *options, const lf_scene *scene,
                         const lf_render_settings *settings, lf_hologram_depth *out)
{
    const bool is_known = is_cell(&settings->camera) ? measure_cells(scene, settings, out)
                                                     : measure_views(scene, settings, out);
    if (!is_known)
        return false;
    const double pixels = pixels_a_cell(options, settings);
    out->nearest /= pixels;
    out->farthest /= pixels;
    out->vertical = vertical_of(settings);
    return true;
}

char *lf_hologram_depth_words(const lf_hologram_depth *depth, const lf_camera *camera, char *buf,
                              size_t size)
{
    const bool is_before = -depth->nearest > depth->farthest, blurs = camera->view_blur >= 1;
    const double shift = (is_before ? -depth->nearest : depth->farthest) * fmax(1, depth->vertical);
    buf[0] = '\0';
    if (is_cell(camera) && depth->nearest < 0)
        snprintf(buf, size,
                 "some objects are in front of the plate and behind its cameras, which do not see "
                 "them; use a grid with \"window\": \"shared\"");
    else if (shift > SOFT_SHIFT)
        snprintf(buf, size,
                 "objects %s the plate shift by %.1f cells from %s; above %.0f they are "
                 "%s; use more %s or less depth%s",
                 is_before ? "in front of" : "behind", fmin(shift, 1e6),
                 depth->vertical > 1 ? "row to row" : "view to view",
                 shift > GHOST_SHIFT && !blurs ? GHOST_SHIFT : SOFT_SHIFT,
                 shift > GHOST_SHIFT && !blurs ? "doubled" : "soft",
                 depth->vertical > 1 ? "rows" : "views",
                 shift > GHOST_SHIFT && !blurs ? ", or view_blur 1" : "");
    return buf;
}

/* ------------------------------------------------------------------------------------- facts -- */

static json_t *number_or_null(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

/* [x, y], or null if both are 0. */
static json_t *pair(const double of[2])
{
    return of[0] > 0 || of[1] > 0 ? json_pack("[f,f]", of[0], of[1]) : json_null();
}

/* A shift from one u to the next, and from one v to the next. */
static json_t *shifts(double shift, const lf_hologram_depth *depth)
{
    return json_pack("[o,o]", number_or_null(shift), number_or_null(shift * depth->vertical));
}

static json_t *aperture_of(const lf_camera *camera, const double spacing[2])
{
    const double box[2] = {camera->view_blur * spacing[0], camera->view_blur * spacing[1]};
    if (camera->view_blur > 0)
        return json_pack("{s:s, s:f, s:[f,f]}", "shape", "box", "cells", camera->view_blur, "size",
                         box[0], box[1]);
    if (camera->lens_radius > 0)
        return json_pack("{s:s, s:f}", "shape", "disc", "radius", camera->lens_radius);
    return json_pack("{s:s}", "shape", "point");
}

/* Where the cameras are, in scene units; angles in degrees. */
static json_t *cameras_of(const lf_camera *camera)
{
    double spacing[2];
    find_spacing(camera, spacing);
    json_t *made =
        json_pack("{s:i, s:i, s:o, s:o}", "columns", columns_of(camera), "rows", rows_of(camera),
                  "spacing", pair(spacing), "aperture", aperture_of(camera, spacing));
    const double high = 0.5 * camera->fov_y, wide = atan(tan(high) * camera->aspect);
    if (is_cell(camera))
        json_object_set_new(made, "fov",
                            json_pack("[f,f]", wide * (360 / M_PI), high * (360 / M_PI)));
    else
        json_object_set_new(made, "distance", json_real(distance_of(camera)));
    json_object_set_new(made, "placement",
                        json_string(camera->track > 0 ? "equal spacing" : "equal angles"));
    json_t *places = camera->track > 0 ? NULL : json_array();
    for (int k = 0; places && k < columns_of(camera); k++)
        json_array_append_new(places, json_real(place_of(camera, k)));
    if (places)
        json_object_set_new(made, "positions", places);
    return made;
}

/* The hogels of a printer that takes finer pixels, in place of the cells. */
static void put_hogels(const double mm[2], const int hogels[2], const lf_plate *plate, json_t *made)
{
    const double pitch[2] = {mm[0] / hogels[0], mm[1] / hogels[1]};
    json_object_set_new(made, "pixels", json_pack("[i,i]", plate->width, plate->height));
    json_object_set(made, "pixel_pitch_mm", json_object_get(made, "hogel_pitch_mm"));
    json_object_set_new(made, "hogels", json_pack("[i,i]", hogels[0], hogels[1]));
    json_object_set_new(made, "hogel_pitch_mm", pair(pitch));
    json_object_set_new(made, "layout",
                        json_string("views/view_U: rows and columns of pixels, which are finer "
                                    "than hogels"));
}

json_t *lf_hologram_facts(const lf_hologram_options *options, const lf_plate *plate,
                          const lf_render_settings *settings, const lf_hologram_depth *depth,
                          json_t *recorded)
{
    const lf_camera *camera = &settings->camera;
    const lf_hologram_preset *preset = lf_hologram_preset_of(options);
    const lf_plate_place n = lf_plate_size(plate);
    const double mm[2] = {options->width_mm, options->height_mm},
                 pitch[2] = {mm[0] / n.hx, mm[1] / n.hy};
    double size[2];
    int hogels[2];
    find_plate(camera, size);
    const double a_unit = size[0] > 0 ? mm[0] / size[0] : 0;
    json_t *made =
        json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:s?, s:o}", "quiltd", LF_VERSION, "plate_mm",
                  pair(mm), "hogel_pitch_mm", pair(pitch), "plate", pair(size), "mm_per_unit",
                  a_unit > 0 ? json_real(a_unit) : json_null(), "cameras", cameras_of(camera),
                  "preset", options->preset, "settings", recorded);
    if (made && depth)
        json_object_set_new(made, "shift",
                            json_pack("{s:o, s:o}", "nearest", shifts(depth->nearest, depth),
                                      "farthest", shifts(depth->farthest, depth)));
    if (made && preset)
        json_object_set_new(made, "preset_note", json_string(preset->note));
    if (made && preset && find_hogels(options, settings, hogels))
        put_hogels(mm, hogels, plate, made);
    if (made)
        json_object_set_new(made, "units",
                            json_string("scene units; degrees; shift in cells, [u, v]"));
    return made;
}

/* ------------------------------------------------------------------------------------- files -- */

/* The views in the plate's encoding, [view][y][x]. */
static lf_status encode(const lf_output_request *request, const lf_output_source *source,
                        const lf_plate *plate, uint8_t *out, lf_error *err)
{
    const lf_views32 *in = &source->views32;
    const size_t row = (size_t)in->width * lf_plate_pixel_bytes(plate);
    lf_tone *tone = NULL;
    lf_views8 codes;
    uint8_t *buffer = NULL;
    lf_status status =
        plate->format == LF_PLATE_PNG
            ? output_views8(request, source, &codes, &buffer, err)
            : lf_tone_create(request->exposure, request->tonemap ? request->tonemap : "srgb", &tone,
                             err);
    for (int view = 0; view < in->n_views && status == LF_OK; view++)
        for (int y = 0; y < in->height; y++, out += row)
            if (plate->format == LF_PLATE_PNG)
                memcpy(out, lf_views8_row(&codes, view, y), row);
            else
                lf_plate_encode(plate, tone, (size_t)in->width, lf_views32_row(in, view, y), out);
    lf_tone_destroy(tone);
    lf_free(buffer);
    return status;
}

static lf_plate_run run_of(const lf_output_request *request)
{
    return (lf_plate_run){.cancel = request->cancel,
                          .pool = request->pool,
                          .progress = request->progress,
                          .context = request->context};
}

lf_status lf_hologram_write(const lf_output_request *request, const lf_output_source *source,
                            const lf_plate *plate, const json_t *facts, int task, lf_error *err)
{
    const lf_views32 *in = &source->views32;
    const lf_plate_run run = run_of(request);
    uint8_t *samples = lf_calloc((size_t)in->n_views * (size_t)in->height,
                                 (size_t)in->width * lf_plate_pixel_bytes(plate));
    lf_status status = samples ? encode(request, source, plate, samples, err)
                               : lf_error_set(err, LF_E_NOMEM, request->path, "out of memory");
    if (status == LF_OK)
        status = lf_plate_write_task(plate, request->path, facts, task, samples, &run, err);
    lf_free(samples);
    return status;
}

lf_status lf_hologram_finish(const lf_output_request *request, const lf_plate *plate,
                             const json_t *facts, lf_error *err)
{
    const lf_plate_run run = run_of(request);
    return lf_plate_finish(plate, request->path, facts, &run, err);
}
