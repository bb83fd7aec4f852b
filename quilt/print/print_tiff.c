#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/version.h"
#include "quilt/print/print.h"

#define STRIP_BYTES (256 << 10)

struct lf_print_tiff {
    TIFF *tiff;
    lf_outfile *file;
    int rows_per_strip;
    double dpi[2];  /* across the page and down */
    bool at_end;    /* libtiff is writing the directory */
    lf_error error; /* the first error; status LF_OK = none */
};

/* ----------------------------------------------------------------- libtiff's way to the file -- */

static const char *file_name(const lf_outfile *file)
{
    return file->path ? file->path : "print";
}

static void keep_failure(lf_print_tiff *tiff, const char *what)
{
    if (tiff->error.status == LF_OK)
        lf_error_set(&tiff->error, LF_E_IO, file_name(tiff->file), "%s: %s", what,
                     lf_errno_text(errno));
}

static tmsize_t read_bytes(thandle_t handle, void *data, tmsize_t n)
{
    const lf_print_tiff *tiff = handle;
    return read(tiff->file->fd, data, (size_t)n);
}

/* The fraction with the smallest denominator for a decimal resolution: 4064 / 5. */
static void exact_fraction(double dpi, uint32_t out[2])
{
    uint32_t below = 1;
    while (below < 100000 && fabs(round(dpi * below) - dpi * below) > 1e-9 * below)
        below++;
    out[0] = (uint32_t)lround(dpi * below);
    out[1] = below;
}

static uint64_t number_of(const unsigned char *bytes, int n)
{
    uint64_t number = 0;
    while (n-- > 0)
        number = number << 8 | bytes[n];
    return number;
}

static void fraction_of(double dpi, unsigned char out[8])
{
    uint32_t exact[2];
    exact_fraction(dpi, exact);
    for (int i = 0; i < 8; i++)
        out[i] = (unsigned char)(exact[i / 4] >> 8 * (i % 4));
}

/* libtiff stores a resolution as a float. If that is not exact, the fraction it writes is replaced
 * by the requested one. data: bytes that libtiff is about to write, little endian; the directory
 * comes last. It has a count of entries, then 12 bytes per entry, with the positions of 8-byte
 * values. In a BigTIFF an entry has 20 bytes and contains such values. */
static void put_fractions(lf_print_tiff *tiff, unsigned char *data, size_t n)
{
    enum { X_RESOLUTION = 282 };
    const bool big = n % 20 == 16 && number_of(data, 8) == (n - 16) / 20,
               classic = !big && n % 12 == 6 && number_of(data, 2) == (n - 6) / 12;
    const size_t entry = big ? 20 : 12, value = big ? 12 : 8;
    if (!big && !classic)
        return;
    for (size_t at = big ? 8 : 2; at + entry <= n; at += entry) {
        const uint64_t tag = number_of(data + at, 2);
        unsigned char fraction[8];
        if ((tag != X_RESOLUTION && tag != X_RESOLUTION + 1) || data[at + 2] != TIFF_RATIONAL)
            continue;
        fraction_of(tiff->dpi[tag - X_RESOLUTION], fraction);
        if (big)
            memcpy(data + at + value, fraction, sizeof fraction);
        else if (pwrite(tiff->file->fd, fraction, sizeof fraction,
                        (off_t)number_of(data + at + value, 4)) != (ssize_t)sizeof fraction)
            keep_failure(tiff, "cannot write");
    }
}

static tmsize_t write_bytes(thandle_t handle, void *data, tmsize_t n)
{
    lf_print_tiff *tiff = handle;
    if (tiff->error.status != LF_OK)
        return -1;
    if (tiff->at_end)
        put_fractions(tiff, data, (size_t)n);
    return lf_outfile_write(tiff->file, data, (size_t)n, &tiff->error) == LF_OK ? n : -1;
}

static toff_t seek_to(thandle_t handle, toff_t offset, int whence)
{
    lf_print_tiff *tiff = handle;
    const off_t at = lseek(tiff->file->fd, (off_t)offset, whence);
    if (at < 0)
        keep_failure(tiff, "cannot seek");
    return (toff_t)at;
}

/* The lf_outfile keeps the descriptor. */
static int close_nothing(thandle_t handle)
{
    (void)handle;
    return 0;
}

static toff_t size_of_file(thandle_t handle)
{
    const lf_print_tiff *tiff = handle;
    struct stat facts;
    return fstat(tiff->file->fd, &facts) == 0 ? (toff_t)facts.st_size : 0;
}

static int keep_error(TIFF *handle, void *context, const char *module, const char *format,
                      va_list arguments) LF_PRINTF(4, 0);
static int keep_error(TIFF *handle, void *context, const char *module, const char *format,
                      va_list arguments)
{
    lf_print_tiff *tiff = context;
    char text[256];
    (void)handle;
    (void)module;
    vsnprintf(text, sizeof text, format, arguments);
    if (tiff->error.status == LF_OK)
        lf_error_set(&tiff->error, LF_E_IO, file_name(tiff->file), "cannot write the TIFF: %s",
                     text);
    return 1; /* keeps it from libtiff's global handler, which prints */
}

static int ignore_warning(TIFF *handle, void *context, const char *module, const char *format,
                          va_list arguments) LF_PRINTF(4, 0);
static int ignore_warning(TIFF *handle, void *context, const char *module, const char *format,
                          va_list arguments)
{
    (void)handle;
    (void)context;
    (void)module;
    (void)format;
    (void)arguments;
    return 1;
}

/* Copies the error; there always is one. */
static lf_status report(const lf_print_tiff *tiff, lf_error *err)
{
    if (tiff->error.status == LF_OK)
        return lf_error_set(err, LF_E_IO, file_name(tiff->file), "cannot write the TIFF");
    if (err)
        *err = tiff->error;
    return tiff->error.status;
}

/* -------------------------------------------------------------------------------------- tags -- */

static bool set_compression(TIFF *tiff, lf_compress compress)
{
    static const uint16_t scheme[] = {
        [LF_COMPRESS_NONE] = COMPRESSION_NONE,
        [LF_COMPRESS_LZW] = COMPRESSION_LZW,
        [LF_COMPRESS_DEFLATE] = COMPRESSION_ADOBE_DEFLATE,
    };
    return TIFFSetField(tiff, TIFFTAG_COMPRESSION, scheme[compress]) &&
           (compress == LF_COMPRESS_NONE ||
            TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL));
}

/* Without colour: 16-bit grey, white is high. */
static bool set_colour(TIFF *tiff, const lf_print *print, const lf_print_colour *colour)
{
    const int channels = colour ? lf_print_colour_channels(colour) : 1;
    size_t profile_size;
    const void *profile = colour ? lf_print_colour_profile(colour, &profile_size) : NULL;
    return TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, colour ? print->bits : 16) &&
           TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, channels) &&
           TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                        channels == 4   ? PHOTOMETRIC_SEPARATED
                        : channels == 1 ? PHOTOMETRIC_MINISBLACK
                                        : PHOTOMETRIC_RGB) &&
           (channels != 4 || TIFFSetField(tiff, TIFFTAG_INKSET, INKSET_CMYK)) &&
           (!profile || TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)profile_size, profile));
}

static bool set_tags(const lf_print_tiff *out, const lf_print_page *page,
                     const lf_print_colour *colour)
{
    const lf_print *print = page->print;
    TIFF *tiff = out->tiff;
    return TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (uint32_t)page->width) &&
           TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (uint32_t)page->height) &&
           set_colour(tiff, print, colour) &&
           TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) &&
           TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) &&
           set_compression(tiff, print->compress) &&
           TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, (uint32_t)out->rows_per_strip) &&
           TIFFSetField(tiff, TIFFTAG_XRESOLUTION, print->dpi) &&
           TIFFSetField(tiff, TIFFTAG_YRESOLUTION, lf_print_dpi_down(print)) &&
           TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH) &&
           TIFFSetField(tiff, TIFFTAG_SOFTWARE, "quiltd " LF_VERSION) &&
           TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, page->description);
}

/* The largest possible size of the file: LZW turns a byte into at most 12 bits, deflate adds less
 * than a hundredth. */
static double largest_size(const lf_print *print, double raster_bytes, size_t profile_size)
{
    static const double growth[] = {
        [LF_COMPRESS_NONE] = 1.0, [LF_COMPRESS_LZW] = 1.6, [LF_COMPRESS_DEFLATE] = 1.01};
    return raster_bytes * (growth[print->compress] + 1e-3) + (double)profile_size + 65536.0;
}

/* ------------------------------------------------------------------------------------ public -- */

static TIFF *open_client(lf_print_tiff *tiff, bool big)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    TIFF *client = NULL;
    if (!options)
        return NULL;
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, tiff);
    TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, NULL);
    client =
        TIFFClientOpenExt(file_name(tiff->file), big ? "wl8" : "wl", tiff, read_bytes, write_bytes,
                          seek_to, close_nothing, size_of_file, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    return client;
}

lf_status lf_print_tiff_open(lf_outfile *file, const lf_print_page *page,
                             const lf_print_colour *colour, int rows_per_strip, lf_print_tiff **out,
                             lf_error *err)
{
    const int pixel_bits = colour ? lf_print_colour_channels(colour) * page->print->bits : 16;
    const size_t row_bytes = (size_t)page->width * (size_t)pixel_bits / 8;
    lf_print_tiff *tiff = lf_calloc(1, sizeof *tiff);
    size_t profile_size = 0;
    if (!tiff)
        return lf_error_set(err, LF_E_NOMEM, file_name(file), "out of memory");
    if (colour)
        (void)lf_print_colour_profile(colour, &profile_size);
    tiff->file = file;
    tiff->dpi[0] = page->print->dpi;
    tiff->dpi[1] = lf_print_dpi_down(page->print);
    if (rows_per_strip == 0)
        rows_per_strip = row_bytes < STRIP_BYTES ? (int)(STRIP_BYTES / row_bytes) : 1;
    tiff->rows_per_strip = rows_per_strip < page->height ? rows_per_strip : page->height;
    const double size = largest_size(page->print, (double)row_bytes * page->height, profile_size);
    tiff->tiff = open_client(tiff, size >= 4294967296.0);
    if (!tiff->tiff || !set_tags(tiff, page, colour)) {
        const lf_status status = report(tiff, err);
        lf_print_tiff_abandon(tiff);
        return status;
    }
    *out = tiff;
    return LF_OK;
}

int lf_print_tiff_strip_rows(const lf_print_tiff *tiff)
{
    return tiff->rows_per_strip;
}

lf_status lf_print_tiff_strip(lf_print_tiff *tiff, int strip, void *data, size_t size,
                              lf_error *err)
{
    if (TIFFWriteEncodedStrip(tiff->tiff, (uint32_t)strip, data, (tmsize_t)size) < 0)
        return report(tiff, err);
    return LF_OK;
}

lf_status lf_print_tiff_close(lf_print_tiff *tiff, lf_error *err)
{
    lf_status status = LF_OK;
    tiff->at_end = true;
    if (!TIFFWriteDirectory(tiff->tiff) || tiff->error.status != LF_OK)
        status = report(tiff, err);
    lf_print_tiff_abandon(tiff);
    return status;
}

void lf_print_tiff_abandon(lf_print_tiff *tiff)
{
    if (!tiff)
        return;
    if (tiff->tiff)
        TIFFCleanup(tiff->tiff);
    lf_free(tiff);
}

/* -------------------------------------------------------------------------------------- sink -- */

static lf_status sink_open(lf_outfile *file, const lf_print_page *page,
                           const lf_print_colour *colour, int rows_per_strip, void **out_state,
                           lf_error *err)
{
    lf_print_tiff *tiff = NULL;
    const lf_status status = lf_print_tiff_open(file, page, colour, rows_per_strip, &tiff, err);
    *out_state = tiff;
    return status;
}

static int sink_strip_rows(const void *state)
{
    return lf_print_tiff_strip_rows(state);
}

static lf_status sink_write(void *state, lf_print_strip *strip, lf_error *err)
{
    return lf_print_tiff_strip(state, strip->index, strip->data, strip->size, err);
}

static lf_status sink_close(void *state, lf_error *err)
{
    return lf_print_tiff_close(state, err);
}

static void sink_abandon(void *state)
{
    lf_print_tiff_abandon(state);
}

const lf_print_sink lf_print_tiff_sink = {.open = sink_open,
                                          .strip_rows = sink_strip_rows,
                                          .write = sink_write,
                                          .close = sink_close,
                                          .abandon = sink_abandon};
