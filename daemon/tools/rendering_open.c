/* Reads the inputs of a job and determines its final name, before rendering. */
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/log.h"
#include "daemon/media/movie.h"
#include "daemon/output/content.h"
#include "daemon/output/fit.h"
#include "daemon/output/hld.h"
#include "daemon/output/hologram.h"
#include "daemon/output/rgbd_views.h"
#include "daemon/tools/rendering_plate.h"

/* Open files in addition to the files of an output. */
#define OTHER_FILES 64
/* Cameras of a grid for a micro lens sheet. */
#define MOST_GRID_VIEWS 4096

/* Checked early, so that an hour of rendering does not end at a missing folder. */
static lf_status check_folder_of(const char *path, lf_error *err)
{
    size_t n = strlen(path);
    char *copy = lf_strdup(path);
    char *folder = NULL;
    lf_status status = LF_OK;
    while (copy && n > 1 && copy[n - 1] == '/')
        copy[--n] = '\0';
    folder = copy ? lf_path_folder(copy) : NULL;
    if (!folder)
        status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    else if (access(folder, W_OK | X_OK) != 0)
        status = lf_error_set(err, LF_E_IO, path, "cannot write to the folder %s: %s", folder,
                              strerror(errno));
    lf_free(folder);
    lf_free(copy);
    return status;
}

lf_status lf_rendering_open_print(lf_rendering *r, int n_views_most, lf_error *err)
{
    const char *warning = NULL;
    r->print = r->asked;
    r->print.photo = r->arguments->options.photo;
    r->print.n_views = r->arguments->options.views;
    const char *where = r->print.n_views > 0 ? "--views" : "--print";
    lf_status status = lf_print_choose_views(&r->print, n_views_most, where, NULL, err);
    if (status == LF_OK)
        status = r->arguments->kind->check_print(&r->print, &warning, err);
    if (status == LF_OK && warning && !r->pool) /* while it opens, not for every frame */
        lf_log(LF_LOG_WARNING, "%s: %s", where, warning);
    return status;
}

lf_status lf_rendering_open_made_print(lf_rendering *r, lf_error *err)
{
    const lf_print_sheet *sheet = &r->arguments->print.sheet;
    if (sheet->guard > 0 || sheet->morph > 0)
        return lf_error_set(err, LF_E_ARG, sheet->guard > 0 ? "--guard" : "--morph",
                            "is for flips of finished images, such as a folder of photos; not for "
                            "views of a scene");
    const bool is_micro = lf_print_is_micro(&r->arguments->print);
    return lf_rendering_open_print(r, is_micro ? MOST_GRID_VIEWS : LF_MAX_VIEWS, err);
}

/* Default number of views of a loop on an arc. */
static lf_options options_of(const lf_rendering *r, const lf_camera *camera)
{
    lf_options options = r->arguments->options;
    if (r->arguments->kind == &lf_output_wiggle && !camera->list && !(camera->track > 0.0) &&
        camera->n_rows == 0 && options.views == 0 && !options.preset && options.columns == 0)
        options.views = LF_WIGGLE_VIEWS;
    return options;
}

static bool is_alone(const lf_rendering *r)
{
    return !lf_path_has_ending(r->arguments->scene, ".json");
}

lf_render_settings lf_rendering_in_lenses(const lf_rendering *r)
{
    lf_render_settings settings = r->settings;
    if (r->print.frame_ppi > 0)
        settings.width = (int)fmax(1, round(settings.width * r->print.lpi / r->print.frame_ppi));
    return settings;
}

/* A file without a scene has no cone: for a print it is as wide as lenses show sharply. */
static void narrow_cone(lf_rendering *r)
{
    lf_camera *camera = &r->settings.camera;
    const double before = camera->cone;
    lf_depth depth;
    for (int i = 0; i < 8; i++) {
        const lf_render_settings in_lenses = lf_rendering_in_lenses(r);
        if (!lf_scene_depth(r->scene, &in_lenses, &depth) ||
            !lf_depth_exceeds(&depth, camera, LF_DEPTH_PRINT))
            break;
        camera->cone *= 0.98 / lf_depth_shift(&depth);
    }
    if (camera->cone < before && !r->pool) /* while it opens, not for every frame */
        lf_log(LF_LOG_INFO,
               "%s: the view cone is %.1f degrees instead of %.0f, so that the lenses show all of "
               "the scene sharply",
               r->arguments->scene, camera->cone * 180 / M_PI, before * 180 / M_PI);
}

lf_status lf_rendering_resolve(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_calibration *calibration = a->kind->needs_panel ? &r->calibration : NULL;
    const lf_camera *camera = lf_scene_camera(r->scene);
    const bool of_rows = a->frames.of_rows, of_print = lf_rendering_is_print_row(r);
    lf_camera row;
    const bool one_rig = a->kind->needs_panel || a->kind->check_print ||
                         a->kind == &lf_output_still || a->kind == &lf_output_wiggle ||
                         (a->kind->layers && (!a->rgbd.is_quilt || camera->list));
    if (of_rows && !of_print) {
        if (lf_rendering_scene_row(r, &row, err) != LF_OK)
            return LF_E_ARG;
        camera = &row;
    }
    const lf_options options = options_of(r, camera);
    lf_status status = (one_rig ? lf_resolve_view : lf_resolve_rows)(&options, camera, calibration,
                                                                     &r->settings, &r->layout, err);
    r->reconstructs = a->options.denoise == LF_DENOISE_ON ||
                      (a->options.denoise == LF_DENOISE_AUTO && !camera->list);
    r->settings.features |= r->reconstructs;
    if (a->kind == &lf_output_wiggle)
        r->settings.camera.cone *= LF_WIGGLE_CONE;
    if (r->sequence.on)
        r->settings.seed =
            (of_rows ? lf_rows_seed : lf_frames_seed)(a->options.seed, r->sequence.frame);
    if (status == LF_OK && a->kind->check_print) {
        status = lf_rendering_open_made_print(r, err);
        if (status == LF_OK)
            lf_output_print_view(&r->print, &r->settings);
        if (status == LF_OK && is_alone(r))
            narrow_cone(r);
        if (status == LF_OK)
            lf_output_print_rig(&r->print, &r->settings.camera);
        r->print.rolled = r->print.horizontal;
    }
    return status == LF_OK && of_print ? lf_rendering_print_row(r, err) : status;
}

/* Replaces the scene by a patched one. Takes ownership of patch; NULL: out of memory. */
static lf_status patch_scene(lf_rendering *r, json_t *patch, lf_error *err)
{
    lf_scene *patched = NULL;
    json_t *doc = patch ? lf_json_merge_patch(lf_scene_json(r->scene), patch) : NULL;
    lf_status status = doc ? lf_scene_from_json(doc, lf_scene_folder(r->scene), r->arguments->scene,
                                                NULL, r->scene, &patched, err)
                           : lf_error_set(err, LF_E_NOMEM, r->arguments->scene, "out of memory");
    json_decref(doc);
    json_decref(patch);
    if (status != LF_OK)
        return status;
    lf_scene_unref(r->scene);
    r->scene = patched;
    return lf_rendering_resolve(r, err);
}

/* Replaces the scene by one with the camera of --fit. */
static lf_status fit(lf_rendering *r, lf_error *err)
{
    const char *name = r->arguments->options.fit.name, *ground;
    json_t *patch = NULL;
    lf_status status = lf_fit_patch(r->scene, &r->settings, name, LF_CAMERA_FILL, 0.0, &patch, err);
    for (int i = 0; status == LF_OK && !name && (ground = lf_scene_ground(r->scene, i)); i++)
        lf_log(LF_LOG_INFO, "--fit: the ground \"%s\" is not framed; use --fit=\"%s\" to frame it",
               ground, ground);
    return status == LF_OK ? patch_scene(r, patch, err) : status;
}

/* Adapts the scene to --preset hld. A file without a scene has no camera of its own to keep. */
static lf_status whiten(lf_rendering *r, lf_error *err)
{
    const lf_options *o = &r->arguments->options;
    const lf_film_settings *film = lf_scene_film_settings(r->scene);
    const bool frames = o->fit.on || is_alone(r);
    const lf_film_settings exposed =
        lf_exposed_film(film, o->has_exposure ? o->exposure : -HUGE_VAL);
    json_t *patch = NULL;
    if (exposed.auto_exposure)
        return lf_error_set(
            err, LF_E_ARG, "--preset hld",
            "needs a fixed exposure for its white ground, not \"auto\"; pass --exposure STOPS");
    lf_status status = lf_hld_patch(r->scene, exposed.exposure, frames, &patch, err);
    return status == LF_OK ? patch_scene(r, patch, err) : status;
}

static lf_status open_scene(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    if (a->photo_option && access(a->scene, F_OK) == 0) {
        char where[64];
        snprintf(where, sizeof where, "--%s", a->photo_option);
        return lf_error_set(
            err, LF_E_ARG, where,
            "applies only to finished images; a scene is rendered in the shape that you ask for");
    }
    if (a->depth.inverts && !a->kind->layers)
        return lf_error_set(err, LF_E_ARG, "--depth-inversion",
                            "needs --rgbd, or an image with depth (--rgbd-in)");
    if (a->kind->check_print &&
        (a->options.preset || a->options.columns > 0 || a->options.view_width > 0))
        return lf_error_set(err, LF_E_ARG, "--print",
                            "cannot be combined with --preset, --quilt and --view-size, because "
                            "the print defines the views");
    const bool moves = r->sequence.on && !a->frames.of_rows;
    json_t *patch = moves ? lf_frames_patch(r->sequence.frame) : NULL;
    lf_status status =
        lf_scene_load_patched(a->scene, &a->options.alone, patch, NULL, NULL, &r->scene, err);
    json_decref(patch);
    lf_progress_line_clear(&r->line);
    if (status == LF_OK)
        lf_log_warnings(r->scene, NULL);
    if (status == LF_OK)
        status = lf_rendering_plate_open(r, err);
    if (status == LF_OK && moves && a->frames.turntable == 0 && !lf_scene_has_frames(r->scene))
        return lf_error_set(err, LF_E_ARG, "--frames",
                            "%s has no animation (a file name with %%04d, a glTF animation or "
                            "keyframes); use --turntable N to orbit the camera",
                            a->scene);
    if (status == LF_OK && a->frames.turntable > 0 && lf_scene_camera(r->scene)->list)
        return lf_error_set(err, LF_E_ARG, "--turntable",
                            "is not supported with a list, path or circle of cameras");
    if (status == LF_OK)
        status = lf_rendering_resolve(r, err);
    const lf_preset *preset = lf_options_preset(&a->options);
    if (status == LF_OK && preset && preset->is_plain)
        return whiten(r, err);
    if (status == LF_OK && a->options.fit.on)
        status = fit(r, err);
    return status == LF_OK ? lf_rendering_plate_rig(r, err) : status;
}

/* Publishing by renaming would replace the input. Either may be NULL. */
static lf_status check_not_input(const char *path, const char *input, lf_error *err)
{
    struct stat out, in;
    if (path && input && stat(path, &out) == 0 && stat(input, &in) == 0 &&
        out.st_dev == in.st_dev && out.st_ino == in.st_ino)
        return lf_error_set(err, LF_E_ARG, path, "is the input; choose another output name");
    return LF_OK;
}

/* True if two names are the same file, which need not exist. */
static bool is_same_file(const char *a, const char *b)
{
    char *folders[2] = {lf_path_folder(a), lf_path_folder(b)};
    char real[2][PATH_MAX];
    const char *slash_a = strrchr(a, '/'), *slash_b = strrchr(b, '/');
    const bool same = strcmp(slash_a ? slash_a + 1 : a, slash_b ? slash_b + 1 : b) == 0 &&
                      folders[0] && folders[1] && realpath(folders[0], real[0]) &&
                      realpath(folders[1], real[1]) && strcmp(real[0], real[1]) == 0;
    lf_free(folders[0]);
    lf_free(folders[1]);
    return same;
}

/* A state file must not be one of the job's outputs. */
static lf_status check_state(const lf_rendering *r, const char *state, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    char *manifest = a->kind->check_print ? lf_output_file_name(a->kind, r->path, 1) : NULL;
    const char *const written[] = {r->path, a->stats, a->files, manifest};
    lf_status status = state ? check_not_input(state, a->scene, err)
                             : lf_error_set(err, LF_E_NOMEM, a->state.file, "out of memory");
    for (size_t i = 0; i < sizeof written / sizeof *written && status == LF_OK; i++)
        if (written[i] && is_same_file(state, written[i]))
            status = lf_error_set(err, LF_E_ARG, "--state",
                                  "names the same file as another output: %s", written[i]);
    lf_free(manifest);
    return status;
}

/* All states of the current frame or row, or of the rows of a grid. */
static lf_status check_states(const lf_rendering *r, lf_error *err)
{
    lf_status status = LF_OK;
    for (int row = 0; row < lf_rendering_camera_rows(r) && status == LF_OK; row++) {
        char *state = lf_rendering_state_current(r, row);
        status = check_state(r, state, err);
        lf_free(state);
    }
    return status;
}

/* The manifest of a print may replace only another manifest. */
static lf_status check_manifest(const lf_output_kind *kind, const char *print, const char *input,
                                lf_error *err)
{
    char *path = lf_output_file_name(kind, print, 1);
    if (!path)
        return lf_error_set(err, LF_E_NOMEM, print, "out of memory");
    lf_status status = check_not_input(path, input, err);
    if (status == LF_OK && access(path, F_OK) == 0) {
        json_t *there = json_load_file(path, 0, NULL);
        if (!json_object_get(there, "quiltd_print"))
            status = lf_error_set(
                err, LF_E_ARG, path,
                "exists and is not a print manifest; choose another name for the print");
        json_decref(there);
    }
    lf_free(path);
    return status;
}

lf_status lf_rendering_check_outputs(const lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_status status = check_not_input(r->path, lf_rendering_input(r), err);
    if (status == LF_OK && a->stats && strcmp(a->stats, "-") != 0)
        status = check_not_input(a->stats, a->scene, err);
    if (status == LF_OK && a->files)
        status = check_not_input(a->files, a->scene, err);
    if (status == LF_OK && a->state.file)
        status = check_states(r, err);
    if (status == LF_OK && a->kind->check_print)
        status = check_manifest(a->kind, r->path, a->scene, err);
    if (status == LF_OK && a->kind->check_print &&
        lf_print_check_wanted(&a->of_print.check, r->path))
        status = lf_print_check_room_beside(r->path, err);
    if (status == LF_OK && a->kind->check_print && !a->plan.on && !lf_state_is_all(&a->state))
        status = lf_print_check_room(&r->print, lf_output_print_format(r->path), r->path, err);
    return status;
}

/* The name of OUT for a frame. Caller frees. */
static char *out_of(const lf_rendering *r, int frame)
{
    const lf_render_arguments *a = r->arguments;
    bool is_one = !r->sequence.on || a->kind == &lf_output_video || a->kind == &lf_output_hologram;
    return is_one ? lf_strdup(a->out) : lf_frames_path(a->out, frame);
}

bool lf_rendering_is_track(const lf_rendering *r)
{
    const lf_output_kind *kind = r->arguments->kind;
    return kind == &lf_output_wiggle || (kind == &lf_output_video && !r->sequence.on);
}

const lf_output_kind *lf_rendering_kind(const lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    const bool one = r->layout.n_views == 1 &&
                     (a->options.columns == 0 || (r->is_quilt && a->options.file.still));
    if (a->kind == &lf_output_video && (one || lf_rendering_is_track(r)))
        return &lf_output_track;
    return one && a->kind == &lf_output_quilt ? &lf_output_still : a->kind;
}

lf_status lf_rendering_name(lf_rendering *r, int frame, lf_error *err)
{
    const lf_output_kind *kind = lf_rendering_kind(r);
    char *out = out_of(r, frame), *path = NULL;
    lf_status status = out ? lf_output_path(kind, out, &r->layout, &path, err)
                           : lf_error_set(err, LF_E_NOMEM, r->arguments->out, "out of memory");
    lf_free(out);
    if (status == LF_OK) {
        lf_free(r->path);
        r->path = path;
    }
    return status;
}

/* Checks the folders of all outputs. */
static lf_status check_folders(const lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    char *first = out_of(r, r->sequence.frame);
    lf_status status = !first ? lf_error_set(err, LF_E_NOMEM, a->out, "out of memory")
                       : lf_state_is_all(&a->state) ? LF_OK
                                                    : check_folder_of(first, err);
    lf_free(first);
    if (status == LF_OK && a->stats && strcmp(a->stats, "-") != 0)
        status = check_folder_of(a->stats, err);
    if (status == LF_OK && a->files)
        status = check_folder_of(a->files, err);
    if (status == LF_OK && a->state.file)
        status = check_folder_of(a->state.file, err);
    return status;
}

/* Automatic exposure per frame would flicker. EXR holds linear light, which has no exposure. */
static lf_status check_exposure(const lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    lf_film_settings film = {0};
    if (r->scene)
        film = *lf_scene_film_settings(r->scene);
    if (a->options.has_exposure)
        film = lf_exposed_film(&film, a->options.exposure);
    const bool is_light = a->kind == &lf_output_hologram
                              ? a->hologram.options.format == LF_PLATE_EXR
                              : lf_output_is_light(a->kind, a->out);
    if (!film.auto_exposure || is_light)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, a->options.has_exposure ? "--exposure" : a->scene,
                        "%sauto would give each of the %s another exposure; pass --exposure STOPS "
                        "(render without %s to see what auto chooses)",
                        a->options.has_exposure ? "" : "film.exposure: ",
                        lf_frames_noun(&a->frames), lf_frames_option(&a->frames));
}

static lf_status check_track(const lf_rendering *r, lf_error *err)
{
    const lf_camera *camera = &r->settings.camera;
    if (camera->n_rows > 0 && !camera->has_parts)
        return lf_error_set(err, LF_E_ARG, r->arguments->out,
                            "a camera grid cannot become a video of views; use --frames or "
                            "--turntable for a video of quilts");
    if (!(camera->track > 0.0) && !camera->list)
        return lf_error_set(err, LF_E_ARG, r->arguments->out,
                            "a video needs --frames, --turntable, --wiggle, or camera.views on a "
                            "track, path or circle or in a list");
    return LF_OK;
}

static lf_status check_wiggle(const lf_rendering *r, lf_error *err)
{
    if (r->layout.n_views > 1)
        return LF_OK;
    return lf_error_set(err, LF_E_ARG, "--wiggle", "needs at least two views");
}

double lf_rendering_rate(const lf_rendering *r)
{
    if (r->arguments->frames.turntable > 0 || (r->scene && !lf_scene_has_frames(r->scene)))
        return 0;
    return r->scene ? lf_scene_rate(r->scene) : r->quilt.frame_rate;
}

lf_video_options lf_rendering_video_options(const lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    const double rate = lf_rendering_rate(r);
    lf_video_options options = a->video;
    if (options.wiggle && !a->has_fps)
        options.fps = lf_wiggle_fps(r->layout.n_views);
    else if (rate > 0 && a->frames.has_range && !a->has_fps)
        options.fps = fmin(fmax(rate, LF_VIDEO_LEAST_FPS), LF_VIDEO_MOST_FPS);
    if (options.wiggle && a->options.view_width == 0)
        options.most_width = LF_WIGGLE_WIDTH;
    return options;
}

/* Checks whether the output can be a video. A video of views starts here, before hours of
 * rendering. */
static lf_status open_video(lf_rendering *r, lf_error *err)
{
    const bool is_track = lf_rendering_is_track(r);
    const lf_video_options options = lf_rendering_video_options(r);
    const lf_layout layout = is_track ? lf_video_view_layout(&r->layout) : r->layout;
    const char *warning = NULL;
    lf_status status = options.wiggle ? check_wiggle(r, err)
                       : is_track     ? check_track(r, err)
                                      : LF_OK;
    if (status == LF_OK)
        status = lf_video_check(&options, &layout, r->path, &warning, err);
    if (status == LF_E_ARG && lf_rendering_of_pictures(r)) /* --view-size is no remedy */
        status = lf_error_set(err, status, r->path,
                              "yuv420p cannot hold images with an odd side; use --pixel-format "
                              "yuv444p");
    if (status == LF_OK && is_track && !r->arguments->plan.on &&
        !lf_state_is_all(&r->arguments->state))
        status = lf_video_create(r->path, &layout, &options, r->cancel, &r->video, err);
    if (warning)
        lf_log(LF_LOG_WARNING, "%s: %s", r->path, warning);
    return status;
}

/* Reports an output with too many views before hours of rendering. Files of one output are open at
 * the same time, so that all of them appear; raises the process's limit as far as allowed. */
static lf_status provide_for_views(const lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const int n = r->layout.n_views;
    struct rlimit limit;
    if (a->kind->has_tiles && r->layout.columns == 0)
        return lf_error_set(err, LF_E_ARG, a->out,
                            "%d views do not fit into the %dx%d tiles of a quilt; write a folder "
                            "(a path that ends in /)",
                            n, LF_MAX_TILES, LF_MAX_TILES);
    if (a->kind->n_files > 0 || getrlimit(RLIMIT_NOFILE, &limit) != 0)
        return LF_OK;
    limit.rlim_cur = limit.rlim_max;
    if (setrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_max < (rlim_t)n + OTHER_FILES)
        return lf_error_set(
            err, LF_E_ARG, a->out,
            "%d views need as many open files, but the limit is %llu; raise it (ulimit -Hn)", n,
            (unsigned long long)limit.rlim_max);
    return LF_OK;
}

/* Refuses a file that is meant as an image but cannot be read as one, before options are compared
 * with its kind. */
static lf_status check_image(const lf_render_arguments *a, lf_error *err)
{
    lf_image_kind kind;
    if (lf_image_is_foreign(a->scene, NULL) || (a->photo_option && lf_image_ending(a->scene)))
        return lf_image_probe(a->scene, NULL, &kind, err);
    return LF_OK;
}

/* Opens what is to be rendered, or a finished image. */
static lf_status open_input(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    if (!a->depth.batch && lf_is_movie(a->scene, NULL))
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "is a video, which quiltd plays; take images from it with ffmpeg -i "
                            "FILE frame_%%04d.png");
    if (lf_rendering_is_numbered(a))
        return lf_rendering_open_pictures(r, err);
    if (a->depth.batch || lf_is_quilt(a->scene, NULL))
        return lf_rendering_open_picture(r, err);
    lf_status status = check_image(a, err);
    return status == LF_OK ? open_scene(r, err) : status;
}

/* Fills the print from profiles, and tells what they gave; options win over them. */
static lf_status open_profiles(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    char line[512];
    r->asked = a->print;
    if (!a->kind->check_print)
        return LF_OK;
    lf_status status = lf_profiles_open(&a->of_print.profiles, NULL, &a->of_print.given, &r->asked,
                                        &r->profiles, err);
    if (status != LF_OK)
        return status;
    for (size_t at = 0; lf_image_notes_next(&r->profiles.told.lines, &at, line, sizeof line);)
        lf_log(LF_LOG_INFO, "%s", line);
    for (size_t at = 0; lf_image_notes_next(&r->profiles.told.warnings, &at, line, sizeof line);)
        lf_log(LF_LOG_WARNING, "%s", line);
    return a->kind->is_drawn ? a->kind->check_print(&r->asked, NULL, err) : LF_OK;
}

lf_status lf_rendering_open(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    r->sequence.on = lf_frames_wanted(&a->frames);
    r->sequence.frame = a->frames.first;
    lf_status status = check_folders(r, err);
    if (status == LF_OK)
        status = open_profiles(r, err);
    if (status == LF_OK && a->kind->needs_panel)
        status = lf_calibration_load(a->options.calibration, &r->calibration, err);
    char words[256];
    if (status == LF_OK && a->kind->needs_panel &&
        lf_options_preset_differs(&a->options, &r->calibration, words, sizeof words))
        lf_log(LF_LOG_WARNING, "%s: %s", a->options.calibration, words);
    if (a->kind->is_drawn)
        r->print = r->asked;
    else if (status == LF_OK)
        status = open_input(r, err);
    if (status == LF_OK && !r->is_quilt && !a->kind->is_drawn)
        status = provide_for_views(r, err);
    if (status == LF_OK && lf_state_is_all(&a->state) && r->scene)
        status = lf_rendering_state_fits(r, err);
    if (status == LF_OK && a->stats && r->settings.camera.n_rows > 0)
        status = lf_error_set(err, LF_E_ARG, "--stats",
                              "supports one row of cameras, but the scene has several; render them "
                              "with --camera-rows");
    if (status == LF_OK)
        status = lf_rendering_name(r, r->sequence.frame, err);
    if (status == LF_OK && r->sequence.on && !lf_state_is_all(&a->state))
        status = check_exposure(r, err);
    if (status == LF_OK && (a->kind == &lf_output_video || a->kind == &lf_output_wiggle))
        status = open_video(r, err);
    if (status == LF_OK)
        status = lf_rendering_check_outputs(r, err);
    if (status == LF_OK)
        status = lf_rendering_plate_begin(r, err);
    if (status == LF_OK && lf_pool_create(a->options.threads, &r->pool) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "--threads", "cannot start the worker threads");
    return status;
}
