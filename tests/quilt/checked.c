#include "tests/testing.h"

#include <nettle/sha2.h>
#include <tiffio.h>

#include "base/alloc.h"
#include "tests/quilt/checked.h"
#include "tests/quilt/printed.h"

static double wave(double x, double y, int c)
{
    return 0.5 + 0.2 * sin(0.9 * x + 0.31 * y + c) + 0.15 * sin(2.3 * x - 0.17 * y) +
           0.1 * cos(0.23 * x + 0.05 * y * y * 0.1 - c);
}

float lf_card_waves(const void *context, int view, int row, int column, int c)
{
    (void)context;
    /* two depths, one before the plane and one behind it */
    const double near = wave(column + 0.45 * view, 0.3 * row, c),
                 far = wave(1.7 * column - 0.3 * view, 0.2 * row, c + 1);
    return (float)fmin(fmax(0.6 * near + 0.4 * far, 0.0), 1.0);
}

float lf_card_still(const void *context, int view, int row, int column, int c)
{
    (void)view;
    return lf_card_waves(context, 3, row, column, c);
}

float lf_card_grey(const void *context, int view, int row, int column, int c)
{
    (void)context;
    (void)view;
    (void)row;
    (void)column;
    (void)c;
    return 0.4F;
}

static void make(const lf_print *print, lf_card_value *value, bool chart, lf_print_format format,
                 lf_checked *out)
{
    memset(out, 0, sizeof *out);
    out->folder = lf_test_folder();
    out->tiff = lf_test_path(out->folder, format == LF_PRINT_PDF ? "sheet.pdf" : "sheet.tif");
    out->manifest = lf_test_path(out->folder, "sheet.json");
    out->print = *print;
    out->witness.n_rows = 16;
    const lf_print_run run = {.format = format, .witness = &out->witness};
    lf_outfile files[2];
    lf_views32 views = {0};
    lf_error err;
    lf_assert_ok(lf_outfile_open(&files[0], out->tiff, false, &err), &err);
    lf_assert_ok(lf_outfile_open(&files[1], out->manifest, false, &err), &err);
    if (chart) {
        lf_assert_ok(lf_chart_write(print, &run, &files[0], &files[1], &err), &err);
    } else {
        lf_card_make(print, value, NULL, &views);
        lf_assert_ok(lf_print_write(print, &views, &run, &files[0], &files[1], &err), &err);
        lf_card_finish(&views);
    }
    for (int i = 0; i < 2; i++)
        lf_assert_ok(lf_outfile_commit(&files[i], true, &err), &err);
}

void lf_checked_make(const lf_print *print, lf_card_value *value, bool chart, lf_checked *out)
{
    make(print, value, chart, LF_PRINT_TIFF, out);
}

void lf_checked_make_pdf(const lf_print *print, lf_card_value *value, bool chart, lf_checked *out)
{
    make(print, value, chart, LF_PRINT_PDF, out);
}

void lf_checked_run(lf_checked *checked, bool with_witness)
{
    const lf_print_check_options options = {.witness = with_witness ? &checked->witness : NULL};
    lf_error err;
    lf_print_report_finish(&checked->report);
    lf_assert_ok(lf_print_check_file(checked->tiff, &options, &checked->report, &err), &err);
}

void lf_checked_hash(const lf_checked *checked)
{
    char *data = NULL, hex[65];
    size_t size = 0;
    lf_error err;
    json_error_t json_error;
    struct sha256_ctx hash;
    uint8_t digest[SHA256_DIGEST_SIZE];
    lf_assert_ok(lf_file_read(checked->tiff, NULL, UINT32_MAX, &data, &size, &err), &err);
    sha256_init(&hash);
    sha256_update(&hash, size, (const uint8_t *)data);
    sha256_digest(&hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(hex + 2 * i, 3, "%02x", digest[i]);
    lf_free(data);
    json_t *root = json_load_file(checked->manifest, 0, &json_error);
    if (!root)
        return; /* a test has spoilt or removed it */
    json_t *file = json_object_get(root, "file");
    json_object_set_new(file, "sha256", json_string(hex));
    json_object_set_new(file, "bytes", json_integer((json_int_t)size));
    assert_int_equal(json_dump_file(root, checked->manifest, JSON_INDENT(2)), 0);
    json_decref(root);
}

void lf_checked_finish(lf_checked *checked)
{
    lf_print_report_finish(&checked->report);
    lf_print_witness_finish(&checked->witness);
    lf_test_folder_remove(checked->folder);
    memset(checked, 0, sizeof *checked);
}

lf_check_result lf_checked_point(const lf_checked *checked, int number)
{
    return checked->report.points[number - 1].result;
}

/* ----------------------------------------------------------------------------------- rasters -- */

void lf_saved_read(const char *path, lf_saved *out)
{
    TIFF *tiff = TIFFOpen(path, "r");
    uint32_t width = 0, height = 0, icc_size = 0;
    uint16_t samples = 0, bits = 0, compression = 0, photometric = 0, unit = 0;
    float dpi[2] = {0, 0};
    void *icc = NULL;
    assert_non_null(tiff);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetField(tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetField(tiff, TIFFTAG_RESOLUTIONUNIT, &unit);
    TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &dpi[0]);
    TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &dpi[1]);
    *out = (lf_saved){.width = (int)width,
                      .height = (int)height,
                      .samples = samples,
                      .bits = bits,
                      .compression = compression,
                      .photometric = photometric,
                      .unit = unit,
                      .orientation = 1,
                      .dpi = {(double)dpi[0], (double)dpi[1]}};
    if (TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &icc_size, &icc)) {
        out->icc = lf_calloc(1, icc_size);
        memcpy(out->icc, icc, icc_size);
        out->icc_size = icc_size;
    }
    const size_t row = (size_t)TIFFScanlineSize(tiff);
    out->data = lf_calloc(height, row);
    for (uint32_t y = 0; y < height; y++)
        assert_int_equal(TIFFReadScanline(tiff, out->data + y * row, y, 0), 1);
    TIFFClose(tiff);
}

void lf_saved_write(const lf_saved *raster, const char *path)
{
    TIFF *tiff = TIFFOpen(path, "w");
    const size_t row = (size_t)raster->width * (size_t)raster->samples * (size_t)raster->bits / 8;
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)raster->width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)raster->height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, raster->samples);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, raster->bits);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, raster->photometric);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, raster->compression);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, raster->orientation);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
    if (raster->photometric == PHOTOMETRIC_SEPARATED)
        TIFFSetField(tiff, TIFFTAG_INKSET, INKSET_CMYK);
    if (raster->compression == COMPRESSION_JPEG)
        TIFFSetField(tiff, TIFFTAG_JPEGQUALITY, 90);
    if (raster->unit > 0) {
        TIFFSetField(tiff, TIFFTAG_XRESOLUTION, raster->dpi[0]);
        TIFFSetField(tiff, TIFFTAG_YRESOLUTION, raster->dpi[1]);
        TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, raster->unit);
    }
    if (raster->icc)
        TIFFSetField(tiff, TIFFTAG_ICCPROFILE, raster->icc_size, raster->icc);
    if (raster->extra > 0) {
        const uint16_t kinds[] = {EXTRASAMPLE_UNASSALPHA};
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, kinds);
    }
    for (int y = 0; y < raster->height; y++)
        assert_int_equal(TIFFWriteScanline(tiff, raster->data + (size_t)y * row, (uint32_t)y, 0),
                         1);
    TIFFClose(tiff);
}

void lf_saved_finish(lf_saved *raster)
{
    lf_free(raster->data);
    lf_free(raster->icc);
    memset(raster, 0, sizeof *raster);
}

static size_t place(const lf_saved *raster, int x, int y, int c)
{
    return ((size_t)y * (size_t)raster->width + (size_t)x) * (size_t)raster->samples + (size_t)c;
}

uint16_t lf_saved_at(const lf_saved *raster, int x, int y, int c)
{
    const size_t i = place(raster, x, y, c);
    return raster->bits == 16 ? ((const uint16_t *)(const void *)raster->data)[i] : raster->data[i];
}

void lf_saved_set(lf_saved *raster, int x, int y, int c, double value)
{
    const double most = raster->bits == 16 ? 65535.0 : 255.0;
    const uint16_t code = (uint16_t)lround(fmin(fmax(value, 0.0), most));
    const size_t i = place(raster, x, y, c);
    if (raster->bits == 16)
        ((uint16_t *)(void *)raster->data)[i] = code;
    else
        raster->data[i] = (uint8_t)code;
}

lf_print lf_checked_chart(void)
{
    return (lf_print){.lpi = 60,
                      .dpi = 600,
                      .width_mm = 60,
                      .height_mm = 40,
                      .bits = 8,
                      .chart_range = 0.2,
                      .chart_step = 0.1};
}
