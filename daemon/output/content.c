#include "daemon/output/content.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/sandbox/import.h"
#include "base/sandbox/import_group.h"
#include "daemon/output/rgbd_views.h"

static lf_content *content_create(const char *file)
{
    lf_content *content = lf_calloc(1, sizeof *content);
    char *copy = lf_strdup(file);
    if (!content || !copy) {
        lf_free(content);
        lf_free(copy);
        return NULL;
    }
    atomic_init(&content->references, 1);
    content->file = copy;
    strcpy(content->film.tonemap, "srgb");
    return content;
}

lf_status lf_content_from_scene(lf_scene *scene, const char *file, const lf_options *options,
                                const lf_calibration *calibration, lf_content **out_content,
                                lf_error *err)
{
    lf_content *content = content_create(file);
    if (!content)
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    content->scene = lf_scene_ref(scene);
    content->film = *lf_scene_film_settings(scene);
    lf_status status = lf_resolve_view(options, lf_scene_camera(scene), calibration,
                                       &content->settings, &content->layout, err);
    content->settings.features = options->denoise != LF_DENOISE_OFF || options->guides;
    if (status != LF_OK) {
        lf_content_unref(content);
        return status;
    }
    content->is_unseen = !lf_scene_is_seen(scene, &content->settings);
    content->has_depth = lf_scene_depth(scene, &content->settings, &content->depth);
    *out_content = content;
    return LF_OK;
}

static lf_photo photo_of(const lf_options *options, const lf_calibration *calibration)
{
    lf_photo photo = options->photo;
    if (calibration)
        photo.frame = (double)calibration->screen_width_px / calibration->screen_height_px;
    return photo;
}

/* Takes over the views, also on failure. is_rgbd: they stand as they are to. */
static lf_status take_quilt(const char *file, const lf_photo *photo, const lf_options *options,
                            bool is_rgbd, lf_quilt_file *quilt, lf_content **out_content,
                            lf_error *err)
{
    lf_content *content = content_create(file);
    if (!content) {
        lf_quilt_finish(quilt);
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    }
    content->quilt = *quilt;
    content->standing = options->standing;
    content->is_rgbd = is_rgbd;
    lf_status status = LF_OK;
    if (!is_rgbd) {
        lf_photo_cut(photo, &content->quilt);
        status = lf_rgbd_stand(&options->standing, options->threads, file, &content->quilt, err);
    }
    if (status != LF_OK) {
        lf_content_unref(content);
        return status;
    }
    lf_log_notes(&content->quilt.notes, file);
    content->layout = content->quilt.layout;
    *out_content = content;
    return LF_OK;
}

/* Draws a picture with depth, which is closed. */
static lf_status take_rgbd(const char *name, const lf_options *options,
                           const lf_calibration *calibration, lf_rgbd_file *file,
                           lf_content **out_content, lf_error *err)
{
    lf_layout layout;
    lf_quilt_file quilt = {0};
    lf_status status = lf_rgbd_layout(options, file->aspect, calibration, &layout, err);
    if (status == LF_OK)
        status = lf_rgbd_draw(file, name, options, &layout, &quilt, err);
    lf_rgbd_file_close(file);
    return status == LF_OK
               ? take_quilt(name, &options->photo, options, true, &quilt, out_content, err)
               : status;
}

lf_status lf_content_from_quilt(const char *file, const lf_roots *roots, const lf_options *options,
                                const lf_calibration *calibration, lf_content **out_content,
                                lf_error *err)
{
    const lf_photo photo = photo_of(options, calibration);
    const lf_rgbd_in side = lf_rgbd_side_of(&options->standing, file);
    lf_quilt_file quilt = {0};
    lf_rgbd_file rgbd;
    if (side != LF_RGBD_IN_OFF) {
        lf_status status =
            lf_rgbd_file_open(file, roots, &options->standing, side, &photo, &rgbd, err);
        return status == LF_OK ? take_rgbd(file, options, calibration, &rgbd, out_content, err)
                               : status;
    }
    lf_import_group group, *before = lf_import_group_begin(&group); /* for a folder's pictures */
    lf_status status =
        lf_quilt_read_photo(file, roots, options->columns, options->rows, &photo, &quilt, err);
    (void)lf_import_group_enter(before);
    return status == LF_OK ? take_quilt(file, &photo, options, false, &quilt, out_content, err)
                           : status;
}

lf_status lf_content_from_sent_quilt(const char *name, const lf_sent_quilt *sent, lf_passed *passed,
                                     const lf_options *options, const lf_calibration *calibration,
                                     lf_content **out_content, lf_error *err)
{
    const lf_photo photo = photo_of(options, calibration);
    lf_quilt_file quilt = {0};
    lf_sent_rgbd rgbd = {.standing = &options->standing,
                         .side = lf_rgbd_side_of(&options->standing, name)};
    lf_status status;
    if (rgbd.side == LF_RGBD_IN_OFF) {
        status = lf_sent_quilt_read(sent, passed, name, &photo, &quilt, err);
        return status == LF_OK ? take_quilt(name, &photo, options, false, &quilt, out_content, err)
                               : status;
    }
    status = lf_sent_rgbd_open(sent, passed, name, &photo, &rgbd, err);
    if (status == LF_OK)
        status = take_rgbd(name, options, calibration, &rgbd.file, out_content, err);
    lf_sent_rgbd_close(&rgbd);
    return status;
}

/* Takes over the player, also on failure. layout: of the views as they are shown. */
static lf_status take_player(const char *file, const lf_options *options, lf_player *player,
                             const lf_layout *layout, lf_content **out_content, lf_error *err)
{
    lf_content *content = content_create(file);
    if (!content) {
        lf_player_destroy(player);
        return lf_error_set(err, LF_E_NOMEM, file, "out of memory");
    }
    content->player = player;
    content->standing = options->standing;
    content->quilt.layout = content->layout = *layout;
    content->quilt.notes = lf_player_movie(player)->notes;
    lf_log_notes(&content->quilt.notes, file);
    *out_content = content;
    return LF_OK;
}

/* A video with depth: its pictures are decoded whole, and the engine draws the views. */
static lf_status open_rgbd(const char *file, const lf_roots *roots, const lf_options *options,
                           lf_rgbd_in side, const lf_photo *photo,
                           const lf_calibration *calibration, lf_content **out_content,
                           lf_error *err)
{
    const lf_photo whole = {0};
    lf_player *player;
    lf_layout layout;
    int width, height;
    if (photo->rotate != LF_TURN_NONE)
        return lf_error_set(err, LF_E_ARG, file,
                            "photo_rotate does not apply to videos with depth; rotate the video "
                            "with ffmpeg");
    lf_status status = lf_standing_check(&options->standing, file, err);
    if (status == LF_OK)
        status = lf_player_create(file, roots, 1, 1, &whole, lf_import_is_stopped, &player, err);
    if (status != LF_OK)
        return status;
    const lf_movie *movie = lf_player_movie(player);
    const lf_views8 *views = &movie->views;
    status = lf_rgbd_size(side, views->width, views->height, file, &width, &height, err);
    const double pixel = movie->layout.aspect * views->height / views->width;
    const double aspect = photo->aspect > 0 ? photo->aspect : pixel * width / height;
    if (status == LF_OK)
        status = lf_rgbd_layout(options, aspect, calibration, &layout, err);
    if (status == LF_OK)
        status = take_player(file, options, player, &layout, out_content, err);
    else
        lf_player_destroy(player);
    if (status != LF_OK)
        return status;
    (*out_content)->is_rgbd = true;
    (*out_content)->rgbd = lf_rgbd_of(&options->standing, side, NULL);
    (*out_content)->rgbd.photo = *photo;
    (*out_content)->pixel_aspect = aspect * height / width;
    return LF_OK;
}

lf_status lf_content_from_movie(const char *file, const lf_roots *roots, const lf_options *options,
                                bool plays_once, const lf_calibration *calibration,
                                lf_content **out_content, lf_error *err)
{
    const lf_photo photo = photo_of(options, calibration);
    const lf_rgbd_in side = lf_rgbd_side_of(&options->standing, file);
    lf_player *player;
    lf_status status;
    if (side != LF_RGBD_IN_OFF) {
        status = open_rgbd(file, roots, options, side, &photo, calibration, out_content, err);
    } else {
        status = lf_player_create(file, roots, options->columns, options->rows, &photo,
                                  lf_import_is_stopped, &player, err);
        if (status == LF_OK)
            status = take_player(file, options, player, &lf_player_movie(player)->layout,
                                 out_content, err);
    }
    if (status != LF_OK)
        return status;
    lf_player_set_once((*out_content)->player, plays_once);
    (*out_content)->plays_once = plays_once;
    return LF_OK;
}

void lf_content_write_document(lf_content *content)
{
    if (!content->scene || lf_scene_json_bytes(content->scene) >= LF_CONTENT_MAX_DOCUMENT)
        return;
    char *text = malloc(LF_CONTENT_MAX_DOCUMENT);
    if (!text)
        return;
    size_t n =
        json_dumpb(lf_scene_json(content->scene), text, LF_CONTENT_MAX_DOCUMENT - 1, JSON_COMPACT);
    if (n == 0 || n >= LF_CONTENT_MAX_DOCUMENT) {
        free(text);
        return;
    }
    text[n] = '\0';
    char *fitted = realloc(text, n + 1);
    if (fitted)
        text = fitted;
    content->document = text;
}

#define SCENE_REMEDY "set \"view_blur\": 1 or a smaller \"cone\" in the scene's camera"

/* Prints two numbers with enough digits to differ. */
static void write_apart(double a, double b, char *of_a, char *of_b, size_t size)
{
    for (int digits = 0; digits <= 6; digits++) {
        snprintf(of_a, size, "%.*f", digits, a);
        snprintf(of_b, size, "%.*f", digits, b);
        if (strcmp(of_a, of_b) != 0)
            return;
    }
}

double lf_depth_shift(const lf_depth *depth)
{
    return fmax(-depth->nearest_step, depth->farthest_step);
}

bool lf_depth_exceeds(const lf_depth *depth, const lf_camera *camera, lf_depth_place place)
{
    return place == LF_DEPTH_PRINT ? camera->view_blur < 1 && lf_depth_shift(depth) > 1
                                   : depth->exceeded;
}

char *lf_depth_words(const lf_depth *depth, int width, lf_depth_place place, char *buf, size_t size)
{
    static const struct {
        const char *what, *unit, *remedy;
    } of[] = {
        [LF_DEPTH_PANEL] = {"a panel", "pixels", "use camera.fit or camera.view_blur=1"},
        [LF_DEPTH_FILE] = {"a panel", "pixels", SCENE_REMEDY},
        [LF_DEPTH_PRINT] = {"lenses", "lenses", SCENE_REMEDY},
    };
    const bool is_before = -depth->nearest_step > depth->farthest_step;
    const double most = place == LF_DEPTH_PRINT ? 1 : depth->limit;
    char shift[32], limit[32], far[64] = "by more than the view width", sharp[64] = "";
    write_apart(lf_depth_shift(depth), most, shift, limit, sizeof shift);
    if (lf_depth_shift(depth) < width)
        snprintf(far, sizeof far, "by %s of %d %s", shift, width, of[place].unit);
    if (place != LF_DEPTH_PRINT)
        snprintf(sharp, sizeof sharp, "; sharp %s distance %.4g", is_before ? "from" : "up to",
                 is_before ? depth->sharp_from : depth->sharp_to);
    snprintf(buf, size,
             "too deep for %s: objects %s the focal plane shift %s between views (limit %s%s); %s",
             of[place].what, is_before ? "in front of" : "behind", far, limit, sharp,
             of[place].remedy);
    return buf;
}

bool lf_content_depth_on_print(const lf_content *content, const lf_print *print, lf_depth *out,
                               int *out_lenses)
{
    if (!content || !content->has_depth || print->horizontal || print->n_views < 2)
        return false;
    lf_print laid = *print;
    laid.view_aspect = content->layout.aspect;
    const double lenses = lf_print_lenses(&laid);
    const double of_views = (double)content->layout.n_views / print->n_views;
    const double scale = of_views * lenses / content->layout.view_width;
    *out = content->depth;
    out->nearest_step *= scale;
    out->farthest_step *= scale;
    *out_lenses = (int)lenses;
    return lf_depth_exceeds(out, &content->settings.camera, LF_DEPTH_PRINT);
}

static bool has_warned(const lf_scene *scene, const char *line)
{
    for (int i = 0; scene && lf_scene_warning(scene, i); i++)
        if (strcmp(lf_scene_warning(scene, i), line) == 0)
            return true;
    return false;
}

void lf_log_warnings(const lf_scene *scene, const lf_scene *before)
{
    for (int i = 0; lf_scene_warning(scene, i); i++)
        if (!has_warned(before, lf_scene_warning(scene, i)))
            lf_log(LF_LOG_WARNING, "%s", lf_scene_warning(scene, i));
}

void lf_log_notes(const lf_image_notes *notes, const char *file)
{
    char line[512];
    for (size_t at = 0; lf_image_notes_next(notes, &at, line, sizeof line);)
        lf_log(LF_LOG_WARNING, "%s: %s", file, line);
}

lf_content *lf_content_ref(lf_content *content)
{
    atomic_fetch_add_explicit(&content->references, 1, memory_order_relaxed);
    return content;
}

void lf_content_unref(lf_content *content)
{
    if (!content || atomic_fetch_sub_explicit(&content->references, 1, memory_order_acq_rel) != 1)
        return;
    if (content->scene)
        lf_scene_unref(content->scene);
    else
        lf_quilt_finish(&content->quilt);
    lf_player_destroy(content->player);
    lf_passed_unref(content->passed);
    json_decref(content->sent);
    lf_free(content->file);
    free(content->document);
    lf_free(content);
}
