/* Opens finished pictures: quilts, folders of views, and numbered sequences of quilts or views. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/frame_name.h"
#include "base/image_io.h"
#include "base/log.h"
#include "base/sandbox/raster.h"
#include "daemon/output/content.h"
#include "daemon/output/rgbd_views.h"
#include "daemon/tools/rendering.h"

const char *lf_rendering_input(const lf_rendering *r)
{
    return r->sequence.input ? r->sequence.input : r->arguments->scene;
}

/* ----------------------------------------------------------------------------------- picture -- */

/* The new layout of a finished light field: a folder has tiles and aspect only from options and
 * names. */
static void lay_out_quilt(lf_rendering *r)
{
    const lf_render_arguments *a = r->arguments;
    int columns = 0;
    int rows = 0;
    double aspect = 0;
    bool stated = lf_layout_from_name(lf_rendering_input(r), &columns, &rows, &aspect);
    stated = stated && aspect > 0;
    r->layout = r->quilt.layout;
    if (a->options.columns * a->options.rows >= r->layout.n_views) {
        r->layout.columns = a->options.columns;
        r->layout.rows = a->options.rows;
    }
    aspect = 0;
    stated = stated || a->options.photo.aspect > 0;
    if (!stated && lf_layout_from_name(a->out, &columns, &rows, &aspect) && aspect > 0)
        r->layout.aspect = aspect;
}

/* Refuses an option for scenes. */
static lf_status refuse_quilt(const lf_render_arguments *a, lf_error *err)
{
    char where[64];
    if (a->kind->layers && lf_rgbd_side_of(&a->options.standing, a->scene) != LF_RGBD_IN_OFF)
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "is a finished image, which has its depth; --rgbd needs a scene");
    if (a->kind->layers)
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "is a finished image without depth; --rgbd needs a scene");
    snprintf(where, sizeof where, "--%s", a->render_option);
    return lf_error_set(err, LF_E_ARG, where,
                        "cannot be combined with a finished quilt, which is not rendered");
}

static lf_status refuse_depth(const lf_render_arguments *a, lf_error *err)
{
    char where[64];
    snprintf(where, sizeof where, "--%s", a->depth.option);
    return lf_error_set(err, LF_E_ARG, where,
                        "needs an image with depth; add --rgbd-in SIDE, if it has one");
}

/* True if the output is the middle view. */
static bool is_still(const lf_render_arguments *a)
{
    const lf_options *o = &a->options;
    return a->kind == &lf_output_still || (a->kind == &lf_output_video && o->file.still) ||
           (a->kind == &lf_output_quilt && o->views == 1 && o->columns == 0);
}

/* Reads the views as they are to be shown by the kind of output. */
static lf_status read_quilt(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_options *o = &a->options;
    const char *input = lf_rendering_input(r);
    const bool is_view = r->sequence.on && o->file.still && !lf_layout_suffix(input);
    int columns = o->columns, rows = o->rows;
    if (is_view && columns == 0)
        columns = rows = 1;
    lf_photo photo = o->photo;
    if (a->kind->needs_panel)
        photo.frame = (double)r->calibration.screen_width_px / r->calibration.screen_height_px;
    else if (a->kind->check_print)
        photo.frame = a->print.width_mm / a->print.height_mm;
    photo.on_paper = a->kind->check_print;
    lf_status status = lf_quilt_read_photo(input, NULL, columns, rows, &photo, &r->quilt, err);
    if (status != LF_OK)
        return status;
    if (a->kind->needs_panel)
        lf_photo_cut(&photo, &r->quilt);
    lf_standing standing = o->standing;
    standing.on_paper = photo.on_paper;
    return lf_rgbd_stand(&standing, o->threads, input, &r->quilt, err);
}

/* Chooses the views of the output. */
static lf_status choose_views(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_options *o = &a->options;
    const bool one = is_still(a), of_middle = one || a->kind == &lf_output_wiggle;
    lf_status status = LF_OK;
    if (a->kind->check_print)
        status = lf_rendering_open_print(r, r->quilt.layout.n_views, err);
    else if (o->views > r->quilt.layout.n_views)
        status = lf_error_set(err, LF_E_ARG, "--views", "asks for %d views, but the quilt has %d",
                              o->views, r->quilt.layout.n_views);
    else if (o->views > 0 && !of_middle)
        r->quilt.layout.n_views = r->quilt.views8.n_views = r->quilt.views32.n_views = o->views;
    if (status == LF_OK && o->has_exposure && !r->quilt.is_float)
        status = lf_error_set(err, LF_E_ARG, "--exposure",
                              "cannot be combined with a finished 8-bit image; use an EXR file");
    if (status == LF_OK)
        lay_out_quilt(r);
    if (status == LF_OK && of_middle) { /* keeps all views; the kind selects those it writes */
        r->layout.columns = r->layout.rows = 1;
        r->layout.n_views = one ? 1 : o->views > 0 ? o->views : lf_wiggle_views(r->layout.n_views);
    }
    return status;
}

static lf_status open_picture(lf_rendering *r, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_options *o = &a->options;
    const lf_rgbd_in side = lf_rgbd_side_of(&o->standing, lf_rendering_input(r));
    if (a->render_option || a->kind->layers)
        return refuse_quilt(a, err);
    if (side != LF_RGBD_IN_OFF)
        return lf_rendering_open_rgbd(r, side, err);
    if (a->depth.option)
        return refuse_depth(a, err);
    if (o->preset || o->view_width > 0)
        return lf_error_set(
            err, LF_E_ARG, o->preset ? "--preset" : "--view-size",
            "cannot be combined with a finished quilt; its name or --quilt gives the layout; "
            "if the image has depth next to it, add --rgbd-in");
    lf_status status = read_quilt(r, err);
    r->is_quilt = status == LF_OK;
    return status == LF_OK ? choose_views(r, err) : status;
}

lf_status lf_rendering_open_picture(lf_rendering *r, lf_error *err)
{
    if (r->sequence.on)
        return lf_error_set(err, LF_E_ARG, lf_frames_option(&r->arguments->frames),
                            "cannot be combined with one finished image; a sequence of images has "
                            "a name such as frame_%%04d.png");
    lf_status status = open_picture(r, err);
    if (status == LF_OK)
        lf_log_notes(&r->quilt.notes, r->arguments->scene);
    return status;
}

/* ---------------------------------------------------------------------------------- sequence -- */

bool lf_rendering_is_numbered(const lf_render_arguments *a)
{
    return !a->depth.batch && lf_image_ending(a->scene) && strchr(a->scene, '%') &&
           access(a->scene, F_OK) != 0 &&
           (lf_frame_name_varies(a->scene) || lf_frames_wanted(&a->frames));
}

bool lf_rendering_of_pictures(const lf_rendering *r)
{
    return r->sequence.input;
}

lf_status lf_rendering_tell_frame(int frame, int first, lf_error *err)
{
    const lf_error was = *err;
    char before[64] = "";
    if (strncmp(was.where, "--", 2) == 0) /* of all frames */
        return was.status;
    if (frame > first)
        snprintf(before, sizeof before, "; use --frames %d:%d", first, frame - 1);
    return lf_error_set_at(err, was.status, was.where, was.line, was.pointer, "frame %d: %s%s",
                           frame, was.what, before);
}

static lf_status check_name(const lf_render_arguments *a, lf_error *err)
{
    const int n = lf_frame_name_fields(a->scene);
    const lf_frames *frames = &a->frames;
    if (n == 0)
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "has no number field; name a sequence of images frame_%%04d.png, for "
                            "instance");
    if (n > 1)
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "has %d number fields; expected one, such as %%04d", n);
    if (!lf_frames_wanted(frames))
        return lf_error_set(err, LF_E_ARG, a->scene,
                            "is a sequence of images; add --frames FIRST:LAST");
    if (frames->of_rows || frames->turntable > 0)
        return lf_error_set(err, LF_E_ARG, lf_frames_option(frames),
                            "cannot be combined with finished images; number them with --frames");
    return LF_OK;
}

static lf_status set_input(lf_rendering *r, int frame, lf_error *err)
{
    char *name = lf_frame_name(r->arguments->scene, frame);
    if (!name)
        return lf_error_set(err, LF_E_NOMEM, r->arguments->scene, "out of memory");
    lf_free(r->sequence.input);
    r->sequence.input = name;
    return LF_OK;
}

/* The size of an image; only of formats other than PNG all pixels are read. */
static lf_status measure(const char *path, int *out_width, int *out_height, lf_error *err)
{
    lf_raster raster;
    lf_status status = lf_png_measure(path, NULL, out_width, out_height, err);
    if (status != LF_E_STATE)
        return status;
    status = lf_raster_open(path, NULL, false, &raster, err);
    if (status != LF_OK)
        return status;
    *out_width = raster.width;
    *out_height = raster.height;
    lf_raster_close(&raster);
    return LF_OK;
}

lf_status lf_rendering_open_pictures(lf_rendering *r, lf_error *err)
{
    lf_sequence_state *s = &r->sequence;
    lf_status status = check_name(r->arguments, err);
    if (status != LF_OK)
        return status;
    status = set_input(r, s->frame, err);
    if (status == LF_OK)
        status = measure(s->input, &s->width, &s->height, err);
    if (status == LF_OK)
        lf_made_with_read(s->input, &s->made);
    if (status == LF_OK)
        status = open_picture(r, err);
    if (status == LF_OK)
        lf_log_notes(&r->quilt.notes, s->input);
    else if (strcmp(err->where, r->arguments->scene) != 0)
        return lf_rendering_tell_frame(s->frame, s->frame, err);
    return status;
}

static lf_status check_made(const lf_rendering *r, const char *name, lf_error *err)
{
    char words[3 * LF_PNG_TEXT];
    lf_made_with made;
    if (r->arguments->frames.mixed)
        return LF_OK;
    lf_made_with_read(name, &made);
    return lf_made_with_differs(&made, &r->sequence.made, words, sizeof words)
               ? lf_error_set(err, LF_E_STATE, name,
                              "was rendered with %s as in the first frame; render it again, or "
                              "join all with --mixed",
                              words)
               : LF_OK;
}

lf_status lf_rendering_check_picture(const lf_rendering *r, int frame, lf_error *err)
{
    const lf_sequence_state *s = &r->sequence;
    int width, height;
    char *name = lf_frame_name(r->arguments->scene, frame);
    lf_status status = name ? measure(name, &width, &height, err)
                            : lf_error_set(err, LF_E_NOMEM, r->arguments->scene, "out of memory");
    if (status == LF_OK && (width != s->width || height != s->height))
        status =
            lf_error_set(err, LF_E_FORMAT, name, "has %dx%d pixels, but the first frame has %dx%d",
                         width, height, s->width, s->height);
    if (status == LF_OK)
        status = check_made(r, name, err);
    lf_free(name);
    return status;
}

static bool is_same_layout(const lf_layout *a, const lf_layout *b)
{
    return a->columns == b->columns && a->rows == b->rows && a->n_views == b->n_views &&
           a->view_width == b->view_width && a->view_height == b->view_height &&
           fabs(a->aspect / b->aspect - 1) < 1e-3;
}

/* Repeats no notes of the frame before. */
static void log_news(const lf_rendering *r, const lf_image_notes *before)
{
    const lf_image_notes *notes = &r->quilt.notes;
    if (notes->length != before->length || memcmp(notes->text, before->text, notes->length) != 0)
        lf_log_notes(notes, r->sequence.input);
}

lf_status lf_rendering_take_picture(lf_rendering *r, lf_error *err)
{
    const lf_layout layout = r->layout;
    const lf_image_notes notes = r->quilt.notes;
    const int frame = r->sequence.frame, first = r->arguments->frames.first;
    if (frame == first) /* is open */
        return LF_OK;
    lf_status status = set_input(r, frame, err);
    lf_quilt_finish(&r->quilt);
    if (status == LF_OK)
        status = open_picture(r, err);
    if (status == LF_OK && !is_same_layout(&r->layout, &layout))
        status = lf_error_set(err, LF_E_FORMAT, r->sequence.input,
                              "has %d views of %dx%d pixels, but the first frame has %d of %dx%d",
                              r->layout.n_views, r->layout.view_width, r->layout.view_height,
                              layout.n_views, layout.view_width, layout.view_height);
    if (status != LF_OK && status != LF_E_CANCELLED)
        return lf_rendering_tell_frame(frame, first, err);
    if (status == LF_OK)
        log_news(r, &notes);
    return status;
}
