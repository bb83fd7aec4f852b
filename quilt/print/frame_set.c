/* Frames for shops that interlace themselves: each view as a picture of the print's size.
 *
 * A frame is a print of one view under lenses as wide as one pixel, with a lens centred on every
 * pixel. So frames are laid, coloured and written like prints. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/version.h"
#include "quilt/print/print.h"

lf_print lf_frame_set_print(const lf_print *print)
{
    lf_print frame = *print;
    frame.lpi = frame.dpi = print->frame_ppi;
    frame.dpi_down = 0.0;
    frame.n_views = 1;
    frame.stripes = LF_STRIPES_NEAREST;
    frame.reverse = false;
    frame.optics = (lf_optics){0};
    frame.sheet = (lf_print_sheet){0};
    frame.blur = (lf_print_blur){0};
    frame.compensation = (lf_compensation){0};
    frame.frame_ppi = 0.0;
    const double across =
        (print->horizontal ? print->height_mm : print->width_mm) + 2.0 * print->bleed_mm;
    /* an even raster has a border of pixels in the middle, not a pixel */
    frame.phase_mm = lround(across * frame.dpi / 25.4) % 2 == 0 ? 12.7 / frame.dpi : 0.0;
    return frame;
}

lf_status lf_frame_set_check(const lf_print *print, lf_error *err)
{
    const lf_print_sheet *sheet = &print->sheet;
    const bool is_laid = sheet->columns * sheet->rows > 1 || sheet->paper_width_mm > 0.0;
    const char *wrong = lf_print_is_micro(print) ? "lens-grid square or hexagonal"
                        : is_laid                ? "copies and paper"
                        : sheet->label           ? "label"
                        : sheet->guard > 0       ? "guard"
                        : sheet->morph > 0       ? "morph"
                        : print->marks           ? "marks"
                        : print->mirror          ? "mirror"
                        : print->reverse         ? "reverse"
                        : print->relief          ? "relief"
                                                 : NULL;
    if (wrong)
        return lf_error_set(err, LF_E_ARG, "frame set",
                            "holds single views of a linear sheet; leave %s out", wrong);
    lf_status status = lf_print_check(print, NULL, err);
    const lf_print frame = lf_frame_set_print(print);
    return status == LF_OK ? lf_print_check(&frame, NULL, err) : status;
}

/* ------------------------------------------------------------------------------------ frames -- */

typedef struct frames {
    const lf_print *print;
    const lf_print_run *run;
    int i;
} frames;

static void on_progress(void *context, double fraction)
{
    const frames *f = context;
    if (f->run->progress)
        f->run->progress(f->run->context, (f->i + fraction) / f->print->n_views);
}

/* The view that frame i shows. */
static int view_of(const lf_print *print, const lf_views32 *views, int i)
{
    return (int)(((2 * (int64_t)i + 1) * views->n_views) / (2 * (int64_t)print->n_views));
}

static lf_views32 one_view(const lf_views32 *views, int view)
{
    lf_views32 one = *views;
    one.n_views = 1;
    one.layers = NULL;
    if (views->codes)
        one.codes = lf_views32_codes(views, view, 0);
    else
        one.data = lf_views32_row(views, view, 0);
    return one;
}

static const char *place_of(const lf_print *print, int i, char text[static 64])
{
    const char *first = print->horizontal ? "topmost" : "leftmost",
               *last = print->horizontal ? "lowest" : "rightmost";
    if (i == 0 || i == print->n_views - 1)
        snprintf(text, 64, "%s camera", i == 0 ? first : last);
    else
        snprintf(text, 64, "camera %d from the %s", i + 1, print->horizontal ? "top" : "left");
    return text;
}

static lf_status write_frames(const lf_print *print, const lf_print *frame, const lf_views32 *views,
                              const lf_print_run *run, lf_outfile *files, lf_error *err)
{
    frames f = {.print = print, .run = run};
    lf_print_run each = *run;
    lf_status status = LF_OK;
    double ink = 0.0, most = 0.0;
    each.out_ink = &ink;
    each.format = LF_PRINT_TIFF;
    each.progress = on_progress;
    each.context = &f;
    for (; f.i < print->n_views && status == LF_OK; f.i++) {
        const lf_views32 view = one_view(views, view_of(print, views, f.i));
        char description[160], place[64];
        snprintf(description, sizeof description, "frame %d of %d, %s; not interlaced", f.i + 1,
                 print->n_views, place_of(print, f.i, place));
        status = lf_print_write_frame(frame, &view, &each, description, &files[f.i], err);
        most = fmax(most, ink);
    }
    if (run->out_ink)
        *run->out_ink = most;
    return status;
}

/* -------------------------------------------------------------------------------------- told -- */

static json_t *sizes_json(const lf_print *print, const lf_print_shape *shape)
{
    const double pixel_mm = 25.4 / print->frame_ppi;
    return json_pack("{s:[f,f], s:f, s:f, s:[i,i], s:[f,f]}", "trim_mm", print->width_mm,
                     print->height_mm, "bleed_mm", print->bleed_mm, "ppi", print->frame_ppi,
                     "frame_px", shape->raster_width, shape->raster_height, "frame_mm",
                     shape->raster_width * pixel_mm, shape->raster_height * pixel_mm);
}

static json_t *frames_json(const lf_print *print, const lf_views32 *views, const lf_outfile *files)
{
    json_t *list = json_array();
    char place[64];
    for (int i = 0; list && i < print->n_views; i++) {
        json_t *frame = lf_print_file_json(&files[i]);
        json_object_set_new(frame, "place", json_string(place_of(print, i, place)));
        json_object_set_new(frame, "view", json_integer(view_of(print, views, i)));
        json_array_append_new(list, frame);
    }
    return list;
}

/* Lines for people. */
static void print_order(FILE *out, const lf_print *print, const lf_print_shape *shape,
                        const json_t *list)
{
    fprintf(out, "%d frames of a lenticular print, not interlaced, in this order:\n\n",
            print->n_views);
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *frame = json_array_get(list, i);
        const char *name = json_string_value(json_object_get(frame, "name"));
        fprintf(out, "%s  %s\n", name ? name : "-",
                json_string_value(json_object_get(frame, "place")));
    }
    fprintf(out,
            "\nlenses        %s\npitch         %.10g lenses per inch, visual, as measured\n"
            "trim size     %.10g x %.10g mm\nbleed         %.10g mm on every side, in the frames\n"
            "frame size    %d x %d pixels at %.10g per inch\n\n"
            "Keep size, crop and colours the same for all frames.\n",
            print->horizontal ? "horizontal" : "vertical", print->lpi, print->width_mm,
            print->height_mm, print->bleed_mm, shape->raster_width, shape->raster_height,
            print->frame_ppi);
}

static lf_status write_order(const lf_print *print, const lf_print_shape *shape, const json_t *list,
                             lf_outfile *file, lf_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out)
        print_order(out, print, shape, list);
    lf_status status = out && fclose(out) == 0
                           ? lf_outfile_write(file, text, size, err)
                           : lf_error_set(err, LF_E_NOMEM, "frame set", "out of memory");
    free(text);
    return status;
}

/* The lines of a job as JSON; they may hold names of files in any bytes. */
static json_t *lines_json(const lf_image_notes *notes)
{
    json_t *lines = json_array();
    char text[512];
    for (size_t at = 0; lines && notes && lf_image_notes_next(notes, &at, text, sizeof text);) {
        json_t *line = json_string(text);
        json_array_append_new(lines, line ? line : json_string("a name is not UTF-8"));
    }
    return lines;
}

static lf_status write_manifest(const lf_print *print, const lf_print_run *run, json_t *sizes,
                                json_t *list, lf_outfile *file, lf_error *err)
{
    json_t *root = json_pack(
        "{s:i, s:i, s:s, s:o, s:{s:f, s:s, s:s}, s:o, s:O, s:o, s:O?}", "quiltd_print", 1,
        "quiltd_frames", 1, "software", "quiltd " LF_VERSION, "options",
        lf_param_json(lf_print_params, print), "lens", "lpi", print->lpi, "pitch_kind",
        "visual, as measured", "orientation", print->horizontal ? "horizontal" : "vertical", "size",
        sizes, "frames", list, "warnings", lines_json(run->notes), "settings", run->settings);
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(15)) : NULL;
    json_decref(root);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, "frame set", "out of memory");
    lf_status status = lf_outfile_write(file, text, strlen(text), err);
    if (status == LF_OK)
        status = lf_outfile_write(file, "\n", 1, err);
    free(text);
    return status;
}

lf_status lf_frame_set_write(const lf_print *print, const lf_views32 *views,
                             const lf_print_run *run, lf_outfile *files, lf_error *err)
{
    const lf_print frame = lf_frame_set_print(print);
    lf_print_shape shape;
    lf_status status = lf_frame_set_check(print, err);
    if (status != LF_OK)
        return status;
    lf_print_shape_of(&frame, &shape);
    status = write_frames(print, &frame, views, run, files + LF_FRAME_SET_TOLD, err);
    if (status != LF_OK)
        return status;
    json_t *list = frames_json(print, views, files + LF_FRAME_SET_TOLD);
    status = write_order(print, &shape, list, &files[0], err);
    if (status == LF_OK)
        status = write_manifest(print, run, sizes_json(print, &shape), list, &files[1], err);
    json_decref(list);
    return status;
}
