/* A TIFF written row by row, for prints and charts. */
#include <string.h>

#include "base/alloc.h"
#include "quilt/print/print.h"

static void mirror_row(float *row, int width)
{
    for (int left = 0, right = width - 1; left < right; left++, right--) {
        float pixel[3];
        memcpy(pixel, row + 3 * (size_t)left, sizeof pixel);
        memcpy(row + 3 * (size_t)left, row + 3 * (size_t)right, sizeof pixel);
        memcpy(row + 3 * (size_t)right, pixel, sizeof pixel);
    }
}

/* Makes one strip: rows of linear light, then device values. */
static void make_strip(const lf_print_page *page, const lf_print_colour *colour, int y, int rows,
                       float *row, unsigned char *strip, size_t row_bytes)
{
    for (int r = 0; r < rows; r++) {
        page->draw(page->context, y + r, row);
        if (page->print->mirror)
            mirror_row(row, page->width);
        lf_print_colour_encode(colour, (size_t)page->width, row, strip + (size_t)r * row_bytes);
    }
}

static lf_status write_strips(const lf_print_page *page, const lf_print_colour *colour,
                              const lf_print_run *run, lf_print_tiff *tiff, lf_error *err)
{
    const int height = page->height, strip_rows = lf_print_tiff_strip_rows(tiff);
    const size_t row_bytes = (size_t)page->width * (size_t)lf_print_colour_channels(colour) *
                             (size_t)page->print->bits / 8;
    float *row = lf_calloc((size_t)page->width, 3 * sizeof *row);
    unsigned char *data = lf_calloc((size_t)strip_rows, row_bytes);
    lf_status status = LF_OK;
    if (!row || !data ||
        (run->witness && lf_print_witness_begin(run->witness, height, row_bytes) != LF_OK))
        status = lf_error_set(err, LF_E_NOMEM, "print", "out of memory");
    for (int y = 0, strip = 0; y < height && status == LF_OK; y += strip_rows, strip++) {
        const int rows = height - y < strip_rows ? height - y : strip_rows;
        if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) {
            status = lf_error_set(err, LF_E_CANCELLED, "print", "cancelled");
            break;
        }
        make_strip(page, colour, y, rows, row, data, row_bytes);
        if (run->witness)
            lf_print_witness_see(run->witness, y, rows, data);
        status = lf_print_tiff_strip(tiff, strip, data, (size_t)rows * row_bytes, err);
        if (status == LF_OK && run->progress)
            run->progress(run->context, (double)(y + rows) / height);
    }
    lf_free(row);
    lf_free(data);
    return status;
}

lf_status lf_print_page_write(const lf_print_page *page, const lf_print_colour *colour,
                              const lf_print_run *run, int rows_per_strip, lf_outfile *file,
                              lf_error *err)
{
    lf_print_tiff *tiff = NULL;
    lf_status status = lf_print_tiff_open(file, page, colour, rows_per_strip, &tiff, err);
    if (status != LF_OK)
        return status;
    status = write_strips(page, colour, run, tiff, err);
    if (status == LF_OK)
        return lf_print_tiff_close(tiff, err);
    lf_print_tiff_abandon(tiff);
    return status;
}
