#include "daemon/output/preview.h"

#include "base/alloc.h"

static const char *const formats[] = {[LF_PREVIEW_JPEG] = "jpeg", [LF_PREVIEW_RAW] = "raw", NULL};

const char *lf_preview_format_name(int format)
{
    return formats[format];
}

static lf_status check_cancel(const lf_cancel *cancel, lf_error *err)
{
    return atomic_load_explicit(cancel, memory_order_relaxed)
               ? lf_error_set(err, LF_E_CANCELLED, "", "cancelled")
               : LF_OK;
}

/* The layout with views of this width and of their shape. */
static lf_layout layout_of_width(const lf_layout *layout, int width)
{
    lf_layout small = *layout;
    small.view_width = width;
    small.view_height =
        (int)(((int64_t)layout->view_height * width + layout->view_width / 2) / layout->view_width);
    small.view_height = small.view_height > 0 ? small.view_height : 1;
    return small;
}

/* Packed views. */
static lf_views8 views_of(const uint8_t *rgb, const lf_layout *layout)
{
    const size_t row = (size_t)layout->view_width * 3;
    return (lf_views8){layout->n_views,
                       layout->view_width,
                       layout->view_height,
                       row * (size_t)layout->view_height,
                       row,
                       rgb};
}

static lf_status shrink(const lf_views8 *views, const lf_layout *to, const lf_cancel *cancel,
                        uint8_t *out, lf_error *err)
{
    const size_t size = (size_t)to->view_width * (size_t)to->view_height * 3;
    for (int view = 0; view < views->n_views; view++) {
        lf_status status = check_cancel(cancel, err);
        if (status == LF_OK && lf_view_shrink(views, view, to->view_width, to->view_height,
                                              out + (size_t)view * size) != LF_OK)
            status = lf_error_set(err, LF_E_NOMEM, "", "out of memory for smaller views");
        if (status != LF_OK)
            return status;
    }
    return LF_OK;
}

static lf_status write_raw(const lf_views8 *views, const lf_layout *layout, lf_outfile *file,
                           lf_error *err)
{
    const size_t n = (size_t)layout->columns * (size_t)views->width * 3;
    uint8_t *row = lf_calloc(n, 1);
    lf_status status = row ? LF_OK : lf_error_set(err, LF_E_NOMEM, "", "out of memory for a row");
    for (int y = 0; y < layout->rows * views->height && status == LF_OK; y++) {
        lf_quilt_row8(views, layout, y, row);
        status = lf_outfile_write(file, row, n, err);
    }
    lf_free(row);
    return status;
}

static lf_status write_quilt(const lf_preview_options *options, const lf_views8 *views,
                             const lf_layout *layout, lf_outfile *file, lf_error *err)
{
    return options->format == LF_PREVIEW_RAW
               ? write_raw(views, layout, file, err)
               : lf_quilt_write_jpeg(file, views, layout, options->quality, err);
}

lf_status lf_preview_write(const lf_preview_options *options, const uint8_t *rgb,
                           const lf_layout *layout, const lf_cancel *cancel, lf_outfile *file,
                           lf_layout *out_layout, lf_error *err)
{
    if (options->width > layout->view_width)
        return lf_error_set_at(err, LF_E_ARG, "", 0, "/width",
                               "the views are %d pixels wide; %d is more", layout->view_width,
                               options->width);
    const bool same = options->width == 0 || options->width == layout->view_width;
    const lf_layout small = same ? *layout : layout_of_width(layout, options->width);
    lf_views8 views = views_of(rgb, layout);
    uint8_t *buffer = NULL;
    lf_status status = check_cancel(cancel, err);
    if (status == LF_OK && !same) {
        buffer = lf_calloc((size_t)small.n_views * (size_t)small.view_height,
                           (size_t)small.view_width * 3);
        status = buffer ? shrink(&views, &small, cancel, buffer, err)
                        : lf_error_set(err, LF_E_NOMEM, "", "out of memory for smaller views");
        views = views_of(buffer, &small);
    }
    if (status == LF_OK)
        status = write_quilt(options, &views, &small, file, err);
    if (status == LF_OK)
        *out_layout = small;
    lf_free(buffer);
    return status;
}
