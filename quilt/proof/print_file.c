#include "quilt/proof/print_file.h"

#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/proof/print_light.h"
#include "quilt/proof/print_tags.h"

#define MAX_FILE_BYTES ((uint64_t)1 << 41)
/* What libtiff may take at once: a strip, or the list of strips. */
#define MAX_TAKEN ((tmsize_t)(LF_PRINT_FILE_MAX_STRIP + (1 << 20)))

struct lf_print_file {
    lf_tiff tiff;
    char *path;
    const char *unreadable;
    uint8_t *icc;
    lf_print_light *light; /* NULL: unreadable */
    void *row;             /* for lf_print_file_row */
    /* compressed files only */
    TIFF *client;
    uint64_t at;       /* libtiff's place in the file */
    int next_row;      /* that libtiff decodes next; -1: none */
    char message[200]; /* libtiff's first complaint */
};

/* ----------------------------------------------------------------- libtiff's way to the file -- */

static tmsize_t read_bytes(thandle_t handle, void *data, tmsize_t n)
{
    lf_print_file *file = handle;
    const uint64_t size = file->tiff.size;
    const uint64_t left = file->at < size ? size - file->at : 0;
    const uint64_t wanted = n > 0 ? (uint64_t)n : 0, some = wanted < left ? wanted : left;
    if (!lf_tiff_bytes(&file->tiff, file->at, data, (size_t)some))
        return -1;
    file->at += some;
    return (tmsize_t)some;
}

static tmsize_t write_nothing(thandle_t handle, void *data, tmsize_t n)
{
    (void)handle;
    (void)data;
    (void)n;
    return -1;
}

static toff_t seek_to(thandle_t handle, toff_t offset, int whence)
{
    lf_print_file *file = handle;
    file->at = whence == SEEK_SET   ? offset
               : whence == SEEK_CUR ? file->at + offset
                                    : file->tiff.size + offset;
    return file->at;
}

static int close_nothing(thandle_t handle)
{
    (void)handle;
    return 0;
}

static toff_t size_of_file(thandle_t handle)
{
    const lf_print_file *file = handle;
    return file->tiff.size;
}

static int keep_error(TIFF *client, void *context, const char *module, const char *format,
                      va_list arguments) LF_PRINTF(4, 0);
static int keep_error(TIFF *client, void *context, const char *module, const char *format,
                      va_list arguments)
{
    lf_print_file *file = context;
    (void)client;
    (void)module;
    if (file->message[0] == '\0')
        vsnprintf(file->message, sizeof file->message, format, arguments);
    return 1; /* keeps it from libtiff's global handler, which prints */
}

static int ignore_warning(TIFF *client, void *context, const char *module, const char *format,
                          va_list arguments) LF_PRINTF(4, 0);
static int ignore_warning(TIFF *client, void *context, const char *module, const char *format,
                          va_list arguments)
{
    (void)client;
    (void)context;
    (void)module;
    (void)format;
    (void)arguments;
    return 1;
}

static lf_status open_client(lf_print_file *file, lf_error *err)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (!options)
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, file);
    TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, NULL);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, MAX_TAKEN);
    file->client = TIFFClientOpenExt(file->path, "rm", file, read_bytes, write_nothing, seek_to,
                                     close_nothing, size_of_file, NULL, NULL, options);
    TIFFOpenOptionsFree(options);
    if (!file->client || TIFFScanlineSize(file->client) != (tmsize_t)lf_print_file_raw_bytes(file))
        return lf_error_set(err, LF_E_FORMAT, file->path,
                            "damaged TIFF: %.150s; write the file again",
                            file->message[0] ? file->message : "its rows");
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- opening -- */

static bool is_compressed(const lf_print_tags *t)
{
    return t->compression != COMPRESSION_NONE;
}

/* Static text, or NULL. */
static const char *what_is_unreadable(const lf_print_tags *t)
{
    if (t->compression == COMPRESSION_JPEG || t->compression == COMPRESSION_OJPEG)
        return "JPEG compression";
    if (t->compression != COMPRESSION_NONE && t->compression != COMPRESSION_LZW &&
        t->compression != COMPRESSION_ADOBE_DEFLATE && t->compression != COMPRESSION_DEFLATE)
        return "a compression other than none, LZW and deflate";
    if (t->palette || t->photometric == PHOTOMETRIC_PALETTE)
        return "a palette";
    if (t->photometric != PHOTOMETRIC_RGB && t->photometric != PHOTOMETRIC_SEPARATED)
        return "a colour space other than RGB and CMYK";
    if (t->extra_samples > 0)
        return "an alpha channel or other extra channels";
    if (t->samples != (t->photometric == PHOTOMETRIC_RGB ? 3 : 4) || t->ink_set != 1)
        return "a number of channels other than 3 for RGB and 4 for CMYK";
    if (t->bits != 8 && t->bits != 16)
        return "a number of bits other than 8 and 16";
    if (t->sample_format != 1)
        return "samples that are not whole numbers";
    if (t->tiled || t->planar != 1)
        return t->tiled ? "tiles instead of strips" : "a plane per channel";
    if (t->fill_order != 1)
        return "bits in reverse order";
    if (t->predictor != 1 && (t->predictor != 2 || !is_compressed(t)))
        return "an unknown predictor";
    return NULL;
}

static lf_status read_profile(lf_print_file *file, lf_error *err)
{
    const size_t size = (size_t)file->tiff.tags.icc_bytes;
    if (size == 0)
        return LF_OK;
    file->icc = lf_calloc(1, size);
    if (!file->icc)
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    if (!lf_tiff_bytes(&file->tiff, file->tiff.icc_at, file->icc, size))
        return lf_error_set(err, LF_E_IO, file->path, "cannot read its colour profile");
    return LF_OK;
}

static lf_status prepare_rows(lf_print_file *file, lf_error *err)
{
    const lf_print_tags *t = &file->tiff.tags;
    if (file->unreadable)
        return LF_OK;
    file->row = lf_calloc(1, lf_print_file_raw_bytes(file));
    if (!file->row || lf_print_light_create(t->samples, t->bits, file->icc, (size_t)t->icc_bytes,
                                            &file->light) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    return is_compressed(t) ? open_client(file, err) : LF_OK;
}

lf_status lf_print_file_open(const char *path, const lf_roots *roots, lf_print_file **out,
                             lf_error *err)
{
    lf_print_file *file = lf_calloc(1, sizeof *file);
    lf_status status;
    if (!file)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    file->tiff.fd = -1;
    file->next_row = -1;
    file->path = lf_strdup(path);
    status = file->path
                 ? lf_file_open(path, roots, MAX_FILE_BYTES, &file->tiff.fd, &file->tiff.size, err)
                 : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    file->tiff.where = file->path;
    if (status == LF_OK)
        status = lf_tiff_read(&file->tiff, err);
    if (status == LF_OK)
        status = read_profile(file, err);
    if (status == LF_OK) {
        file->unreadable = what_is_unreadable(&file->tiff.tags);
        status = prepare_rows(file, err);
    }
    if (status != LF_OK) {
        lf_print_file_close(file);
        return status;
    }
    *out = file;
    return LF_OK;
}

void lf_print_file_close(lf_print_file *file)
{
    if (!file)
        return;
    if (file->client)
        TIFFClose(file->client);
    if (file->tiff.fd >= 0)
        close(file->tiff.fd);
    lf_print_light_destroy(file->light);
    lf_free(file->row);
    lf_free(file->icc);
    lf_free(file->path);
    lf_free(file);
}

/* ------------------------------------------------------------------------------------- facts -- */

const lf_print_tags *lf_print_file_tags(const lf_print_file *file)
{
    return &file->tiff.tags;
}

const void *lf_print_file_icc(const lf_print_file *file, size_t *out_size)
{
    *out_size = (size_t)file->tiff.tags.icc_bytes;
    return file->icc;
}

const char *lf_print_file_profile_name(const lf_print_file *file)
{
    return file->light ? lf_print_light_name(file->light) : "";
}

const char *lf_print_file_profile_problem(const lf_print_file *file)
{
    return file->light ? lf_print_light_problem(file->light) : file->unreadable;
}

const char *lf_print_file_unreadable(const lf_print_file *file)
{
    return file->unreadable;
}

size_t lf_print_file_raw_bytes(const lf_print_file *file)
{
    const lf_print_tags *t = &file->tiff.tags;
    return (size_t)t->width * (size_t)t->samples * (size_t)t->bits / 8;
}

/* -------------------------------------------------------------------------------------- rows -- */

static lf_status damaged_row(const lf_print_file *file, int y, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, file->path,
                        "damaged TIFF: row %d%s%.150s; write it again", y, what[0] ? ": " : "",
                        what);
}

static void swap_bytes(uint16_t *values, size_t n)
{
    for (size_t i = 0; i < n; i++)
        values[i] = (uint16_t)(values[i] << 8 | values[i] >> 8);
}

static lf_status read_plain(lf_print_file *file, int y, void *out, lf_error *err)
{
    const lf_print_tags *t = &file->tiff.tags;
    const uint64_t strip = (uint64_t)(y / t->rows_per_strip),
                   row = (uint64_t)(y % t->rows_per_strip);
    const size_t bytes = lf_print_file_raw_bytes(file);
    uint64_t at, held;
    if (!lf_tiff_element(&file->tiff, &file->tiff.offsets, strip, &at) ||
        !lf_tiff_element(&file->tiff, &file->tiff.byte_counts, strip, &held) ||
        held < (row + 1) * bytes || at > file->tiff.size ||
        !lf_tiff_bytes(&file->tiff, at + row * bytes, out, bytes))
        return damaged_row(file, y, "", err);
    if (t->bits == 16 && t->big_endian)
        swap_bytes(out, bytes / 2);
    return LF_OK;
}

/* Refuses strips that would take too much memory before libtiff reads them. */
static lf_status check_strip(lf_print_file *file, int y, lf_error *err)
{
    const uint64_t strip = (uint64_t)(y / file->tiff.tags.rows_per_strip);
    uint64_t held;
    if (!lf_tiff_element(&file->tiff, &file->tiff.byte_counts, strip, &held))
        return damaged_row(file, y, "", err);
    if (held > LF_PRINT_FILE_MAX_STRIP)
        return lf_error_set(err, LF_E_FORMAT, file->path,
                            "has compressed strips of over 64 MiB; save it with smaller strips");
    return LF_OK;
}

/* libtiff decodes a strip from its beginning, row by row. */
static lf_status read_compressed(lf_print_file *file, int y, void *out, lf_error *err)
{
    const int rows = file->tiff.tags.rows_per_strip, first = y / rows * rows;
    const bool goes_on = file->next_row >= first && file->next_row <= y;
    lf_status status = check_strip(file, y, err);
    file->message[0] = '\0';
    for (int row = goes_on ? file->next_row : first; row <= y && status == LF_OK; row++) {
        file->next_row = -1;
        if (TIFFReadScanline(file->client, out, (uint32_t)row, 0) != 1 || file->message[0] != '\0')
            status = damaged_row(file, row, file->message, err);
    }
    if (status == LF_OK)
        file->next_row = y + 1;
    return status;
}

lf_status lf_print_file_raw(lf_print_file *file, int y, void *out, lf_error *err)
{
    if (file->unreadable)
        return lf_error_set(err, LF_E_FORMAT, file->path,
                            "has %s; save it as plain RGB or CMYK of 8 or 16 bits",
                            file->unreadable);
    return file->client ? read_compressed(file, y, out, err) : read_plain(file, y, out, err);
}

void lf_print_file_light(const lf_print_file *file, const void *raw, size_t n, float *out)
{
    lf_print_light_decode(file->light, raw, n, out);
}

lf_status lf_print_file_row(lf_print_file *file, int y, float *out, lf_error *err)
{
    const lf_status status = lf_print_file_raw(file, y, file->unreadable ? NULL : file->row, err);
    if (status == LF_OK)
        lf_print_file_light(file, file->row, (size_t)file->tiff.tags.width, out);
    return status;
}

/* ---------------------------------------------------------------------------------- manifest -- */

/* "sheet.json" for "sheet.tif"; the caller frees. NULL: out of memory. */
static char *manifest_name(const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const size_t stem =
        dot && dot > (slash ? slash + 1 : path) ? (size_t)(dot - path) : strlen(path);
    char *name = lf_calloc(stem + sizeof ".json", 1);
    if (name) {
        memcpy(name, path, stem);
        memcpy(name + stem, ".json", sizeof ".json");
    }
    return name;
}

static lf_status parse_manifest(const char *name, const char *text, size_t size, json_t **out,
                                lf_error *err)
{
    json_error_t where;
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return lf_error_set_at(err, LF_E_FORMAT, name, where.line > 0 ? where.line : 0, NULL,
                               "not JSON: %s", where.text);
    if (!json_is_integer(json_object_get(root, "quiltd_print"))) {
        json_decref(root);
        return lf_error_set(
            err, LF_E_FORMAT, name,
            "not the manifest of a print: it has no \"quiltd_print\"; move it away");
    }
    *out = root;
    return LF_OK;
}

lf_status lf_print_file_manifest(const char *path, const lf_roots *roots, json_t **out,
                                 lf_error *err)
{
    char *name = manifest_name(path), *text = NULL;
    size_t size = 0;
    lf_status status = LF_OK;
    if (!name)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    if (access(name, F_OK) != 0) {
        *out = NULL;
        lf_free(name);
        return LF_OK;
    }
    status = lf_file_read(name, roots, LF_PRINT_FILE_MAX_MANIFEST, &text, &size, err);
    if (status == LF_OK)
        status = parse_manifest(name, text, size, out, err);
    lf_free(text);
    lf_free(name);
    return status;
}
