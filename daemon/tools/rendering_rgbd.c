/* Opens a picture with depth: draws its views for the kind of output. */
#include <stdio.h>

#include "base/log.h"
#include "daemon/output/content.h"
#include "daemon/output/rgbd_views.h"
#include "daemon/tools/rendering.h"

/* The options with the number of views of the kind. */
static lf_options options_of(const lf_render_arguments *a, bool is_still)
{
    lf_options options = a->options;
    if (is_still)
        options.views = 1;
    else if (a->kind == &lf_output_wiggle && options.views == 0 && !options.preset)
        options.views = LF_WIGGLE_VIEWS;
    return options;
}

static lf_status lay_out(lf_rendering *r, lf_rgbd_file *file, lf_layout *out, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const bool is_still =
        a->kind == &lf_output_still ||
        (a->kind == &lf_output_quilt && a->options.views == 1 && a->options.columns == 0);
    const lf_options options = options_of(a, is_still);
    const lf_calibration *calibration = a->kind->needs_panel ? &r->calibration : NULL;
    lf_status status = lf_rgbd_layout(&options, file->aspect, calibration, out, err);
    if (status == LF_OK && is_still && !options.preset && options.view_width == 0) {
        out->view_width = file->width; /* the picture as it is */
        out->view_height = file->height;
    }
    if (a->kind == &lf_output_wiggle)
        lf_rgbd_narrow(&file->rgbd, LF_WIGGLE_CONE);
    return status;
}

static lf_status lay_out_print(lf_rendering *r, lf_rgbd_file *file, lf_layout *out, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const lf_options *o = &a->options;
    if (o->preset || o->columns > 0 || o->view_width > 0)
        return lf_error_set(err, LF_E_ARG, "--print",
                            "cannot be combined with --preset, --quilt and --view-size, because "
                            "the print defines the views");
    if (a->print.horizontal)
        return lf_error_set(err, LF_E_ARG, "--horizontal",
                            "is not supported for images with depth, whose views lie side by side");
    lf_status status = lf_rendering_open_made_print(r, err);
    if (status != LF_OK)
        return status;
    const double shift = lf_rgbd_print_depth(file, &r->print);
    char words[160];
    r->print.parallax_lenses = shift; /* for the manifest */
    if (shift > 1)
        lf_log(
            LF_LOG_WARNING, "%s: %s", lf_rendering_input(r),
            lf_rgbd_print_words(&file->rgbd, o->standing.depthiness, shift, words, sizeof words));
    lf_print laid = r->print.frame_ppi > 0 ? lf_frame_set_print(&r->print) : r->print;
    laid.n_views = r->print.n_views;
    *out = lf_rgbd_print_layout(file, &laid);
    return LF_OK;
}

lf_status lf_rendering_open_rgbd(lf_rendering *r, lf_rgbd_in side, lf_error *err)
{
    const lf_render_arguments *a = r->arguments;
    const bool is_print = a->kind->check_print;
    lf_photo photo = a->options.photo;
    lf_rgbd_file file;
    if (a->options.has_exposure)
        return lf_error_set(err, LF_E_ARG, "--exposure",
                            "cannot be combined with a finished 8-bit image; use an EXR file");
    photo.on_paper = is_print;
    if (a->kind->needs_panel)
        photo.frame = (double)r->calibration.screen_width_px / r->calibration.screen_height_px;
    else if (is_print)
        photo.frame = a->print.width_mm / a->print.height_mm;
    else if (lf_options_preset(&a->options))
        photo.frame = lf_options_preset(&a->options)->layout.aspect;
    lf_status status = lf_rgbd_file_open(lf_rendering_input(r), NULL, &a->options.standing, side,
                                         &photo, &file, err);
    if (status != LF_OK)
        return status;
    lf_layout layout;
    status = (is_print ? lay_out_print : lay_out)(r, &file, &layout, err);
    if (status == LF_OK)
        status = lf_rgbd_draw(&file, lf_rendering_input(r), &a->options, &layout, &r->quilt, err);
    lf_rgbd drawn = file.rgbd;
    drawn.side = side; /* of the file, not of the turned halves */
    r->quilt.frame_rate = file.raster.meta.frame_rate;
    lf_rgbd_file_close(&file);
    if (status != LF_OK)
        return status;
    r->is_quilt = true;
    r->rgbd = drawn;
    r->layout = layout;
    return LF_OK;
}
