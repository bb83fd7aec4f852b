/* Prints as PDF: one page with one image, in the exact size of its raster. */
#include <math.h>

#include "base/alloc.h"
#include "quilt/print/print.h"
#include "quilt/print/sheet.h"

/* Of pixels; each strip is compressed alone. */
#define STRIP_BYTES (512 << 10)

typedef struct sink {
    lf_pdf *pdf;
    lf_pdf_image image;
    int rows_per_strip;
} sink;

/* The trim edges of all copies with a margin, in points from the bottom left, within the page. A
 * chart is one copy in the middle. */
static void box_of(const lf_print_page *page, const lf_pdf_page *out, double margin_mm,
                   double box[4])
{
    const lf_print *print = page->print;
    const double point = 72.0 / 25.4;
    const double half_width = (0.5 * print->width_mm + margin_mm) * point,
                 half_height = (0.5 * print->height_mm + margin_mm) * point;
    const int n = page->sheet ? page->sheet->n_rows * page->sheet->n_columns : 1;
    double low[2] = {0}, high[2] = {0}; /* middles of the outermost copies, right and up */
    for (int i = 0; page->sheet && i < n; i++) {
        const lf_copy *copy = &page->sheet->copies[i];
        const double middle[2] = {(print->mirror ? -copy->right_mm : copy->right_mm) * point,
                                  -copy->down_mm * point};
        for (int k = 0; k < 2; k++) {
            low[k] = i == 0 ? middle[k] : fmin(low[k], middle[k]);
            high[k] = i == 0 ? middle[k] : fmax(high[k], middle[k]);
        }
    }
    box[0] = fmax(0.5 * out->width + low[0] - half_width, 0.0);
    box[1] = fmax(0.5 * out->height + low[1] - half_height, 0.0);
    box[2] = fmin(0.5 * out->width + high[0] + half_width, out->width);
    box[3] = fmin(0.5 * out->height + high[1] + half_height, out->height);
}

static lf_pdf_page page_of(const lf_print_page *page, const lf_print_colour *colour)
{
    const lf_print *print = page->print;
    lf_pdf_page out = {.width = page->width * 72.0 / print->dpi,
                       .height = page->height * 72.0 / lf_print_dpi_down(print),
                       .title = page->description,
                       .profile_channels = lf_print_colour_channels(colour),
                       .profile_name = lf_print_colour_name(colour)};
    out.profile = lf_print_colour_profile(colour, &out.profile_size);
    box_of(page, &out, 0.0, out.trim);
    box_of(page, &out, print->bleed_mm, out.bleed);
    return out;
}

static void sink_abandon(void *state)
{
    sink *s = state;
    if (s)
        lf_pdf_abandon(s->pdf);
    lf_free(s);
}

static lf_status sink_open(lf_outfile *file, const lf_print_page *page,
                           const lf_print_colour *colour, int rows_per_strip, void **out_state,
                           lf_error *err)
{
    const lf_pdf_page pdf_page = page_of(page, colour);
    const lf_print *print = page->print;
    const int channels = lf_print_colour_channels(colour);
    const size_t row_bytes = (size_t)page->width * (size_t)channels * (size_t)print->bits / 8;
    if (1.01 * (double)row_bytes * page->height > LF_PDF_MAX_BYTES)
        return lf_error_set(err, LF_E_ARG, file->path ? file->path : "print",
                            "the raster has %.3g GB, and a PDF file holds 10; write OUT.tif",
                            1e-9 * (double)row_bytes * page->height);
    sink *s = lf_calloc(1, sizeof *s);
    if (!s)
        return lf_error_set(err, LF_E_NOMEM, "print", "out of memory");
    const int usual = row_bytes < STRIP_BYTES ? (int)(STRIP_BYTES / row_bytes) : 1;
    s->rows_per_strip = rows_per_strip > 0 ? rows_per_strip : usual;
    if (s->rows_per_strip > page->height)
        s->rows_per_strip = page->height;
    s->image = (lf_pdf_image){.width = page->width,
                              .height = page->height,
                              .channels = channels,
                              .bits = print->bits,
                              .width_pt = pdf_page.width,
                              .height_pt = pdf_page.height};
    lf_status status = lf_pdf_open(file, &pdf_page, &s->pdf, err);
    if (status == LF_OK)
        status = lf_pdf_image_begin(s->pdf, &s->image, err);
    if (status != LF_OK) {
        sink_abandon(s);
        return status;
    }
    *out_state = s;
    return LF_OK;
}

static int sink_strip_rows(const void *state)
{
    const sink *s = state;
    return s->rows_per_strip;
}

static lf_status sink_pack(const void *state, lf_print_strip *strip)
{
    const sink *s = state;
    return lf_pdf_strip_pack(&s->image, strip->data, strip->n_rows, strip->is_last, &strip->packed);
}

static lf_status sink_write(void *state, lf_print_strip *strip, lf_error *err)
{
    const sink *s = state;
    return lf_pdf_image_strip(s->pdf, &strip->packed, err);
}

static lf_status sink_close(void *state, lf_error *err)
{
    sink *s = state;
    lf_status status = lf_pdf_image_end(s->pdf, err);
    if (status == LF_OK) {
        status = lf_pdf_close(s->pdf, err);
        s->pdf = NULL;
    }
    sink_abandon(s);
    return status;
}

const lf_print_sink lf_print_pdf_sink = {.open = sink_open,
                                         .strip_rows = sink_strip_rows,
                                         .pack = sink_pack,
                                         .write = sink_write,
                                         .close = sink_close,
                                         .abandon = sink_abandon};
