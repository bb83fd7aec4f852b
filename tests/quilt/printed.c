#include "tests/testing.h"

#include <tiffio.h>

#include "base/alloc.h"
#include "quilt/print/print.h"
#include "tests/quilt/printed.h"

static void read_bytes(const char *path, lf_printed *out)
{
    char *data = NULL;
    lf_error err;
    lf_assert_ok(lf_file_read(path, NULL, UINT32_MAX, &data, &out->file_size, &err), &err);
    out->file = (uint8_t *)data;
}

void lf_printed_read(const char *path, lf_printed *out)
{
    TIFF *tiff = TIFFOpen(path, "r");
    uint32_t width = 0, height = 0;
    uint16_t channels = 0, bits = 0;
    assert_non_null(tiff);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
    TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    out->width = (int)width;
    out->height = (int)height;
    out->channels = channels;
    out->bits = bits;
    const size_t row_values = (size_t)width * channels;
    out->value = lf_calloc(row_values * height, sizeof *out->value);
    uint16_t *row = lf_calloc(1, (size_t)TIFFScanlineSize(tiff));
    assert_non_null(out->value);
    assert_non_null(row);
    for (uint32_t y = 0; y < height; y++) {
        assert_int_equal(TIFFReadScanline(tiff, row, y, 0), 1);
        for (size_t i = 0; i < row_values; i++)
            out->value[y * row_values + i] = bits == 16 ? row[i] : ((const uint8_t *)row)[i];
    }
    lf_free(row);
    TIFFClose(tiff);
}

static void make(const lf_print *print, const lf_views32 *views, int rows_per_strip,
                 lf_printed *out)
{
    char *folder = lf_test_folder();
    const char *path = lf_test_path(folder, "print.tif"),
               *manifest_path = lf_test_path(folder, "print.json");
    const lf_print_run run = {0};
    lf_outfile tiff, manifest;
    lf_error err;
    json_error_t json_error;
    memset(out, 0, sizeof *out);
    lf_assert_ok(lf_outfile_open(&tiff, path, false, &err), &err);
    lf_assert_ok(lf_outfile_open(&manifest, manifest_path, false, &err), &err);
    lf_assert_ok(
        views ? lf_print_write_strips(print, views, &run, rows_per_strip, &tiff, &manifest, &err)
              : lf_chart_write(print, &run, &tiff, &manifest, &err),
        &err);
    lf_assert_ok(lf_outfile_commit(&tiff, false, &err), &err);
    lf_assert_ok(lf_outfile_commit(&manifest, false, &err), &err);
    out->manifest = json_load_file(manifest_path, JSON_REJECT_DUPLICATES, &json_error);
    assert_non_null(out->manifest);
    read_bytes(path, out);
    lf_printed_read(path, out);
    lf_test_folder_remove(folder);
}

void lf_printed_make(const lf_print *print, const lf_views32 *views, int rows_per_strip,
                     lf_printed *out)
{
    make(print, views, rows_per_strip, out);
}

void lf_printed_chart(const lf_print *print, lf_printed *out)
{
    make(print, NULL, 0, out);
}

void lf_printed_finish(lf_printed *printed)
{
    lf_free(printed->value);
    lf_free(printed->file);
    json_decref(printed->manifest);
    memset(printed, 0, sizeof *printed);
}

double lf_srgb_to_linear(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

double lf_printed_linear(const lf_printed *printed, int x, int y, int c)
{
    const size_t i =
        ((size_t)y * (size_t)printed->width + (size_t)x) * (size_t)printed->channels + (size_t)c;
    return lf_srgb_to_linear(printed->value[i] / (printed->bits == 16 ? 65535.0 : 255.0));
}

void lf_card_make(const lf_print *print,
                  float (*value)(const void *context, int view, int row, int column, int c),
                  const void *context, lf_views32 *out)
{
    lf_print_shape shape;
    lf_print_shape_of(print, &shape);
    const size_t width = (size_t)shape.view_width, height = (size_t)shape.view_height;
    float *data = lf_calloc((size_t)print->n_views * height, 3 * width * sizeof *data);
    assert_non_null(data);
    *out = (lf_views32){print->n_views,
                        shape.view_width,
                        shape.view_height,
                        3 * width * height,
                        3 * width,
                        data,
                        NULL,
                        NULL,
                        NULL};
    for (int view = 0; view < print->n_views; view++)
        for (int row = 0; row < shape.view_height; row++)
            for (int i = 0; i < 3 * shape.view_width; i++)
                data[(size_t)view * out->view_stride + (size_t)row * out->row_stride + (size_t)i] =
                    value(context, view, row, i / 3, i % 3);
}

void lf_card_finish(lf_views32 *views)
{
    lf_free((void *)(uintptr_t)views->data);
    memset(views, 0, sizeof *views);
}

lf_print lf_print_sound(void)
{
    return (lf_print){
        .lpi = 60.0, .dpi = 600, .width_mm = 50.8, .height_mm = 2.54, .n_views = 8, .bits = 8};
}

float lf_card_speckle(const void *context, int view, int row, int column, int c)
{
    const uint32_t h = (uint32_t)(view * 73 + row * 9176 + column * 51749 + c * 331) * 2654435761u;
    (void)context;
    return (float)(h >> 8) * 0x1p-24f;
}

void lf_printed_assert_same(const lf_printed *a, const lf_printed *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    assert_memory_equal(a->value, b->value,
                        (size_t)a->width * (size_t)a->height * (size_t)a->channels *
                            sizeof *a->value);
}

uint16_t lf_printed_at(const lf_printed *printed, int x, int y, int c)
{
    return printed
        ->value[((size_t)y * (size_t)printed->width + (size_t)x) * (size_t)printed->channels +
                (size_t)c];
}

lf_print lf_print_odd(void)
{
    lf_print print = lf_print_sound();
    print.lpi = 61.37;
    print.dpi = 720;
    print.width_mm = 31.7;
    print.height_mm = 1.9;
    print.bleed_mm = 1.3;
    print.phase_mm = 0.17;
    print.n_views = 7;
    print.bits = 16;
    return print;
}
