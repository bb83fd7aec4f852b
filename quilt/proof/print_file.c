#include "quilt/proof/print_file.h"

#include <fcntl.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/proof/print_light.h"
#include "quilt/proof/print_strip.h"
#include "quilt/proof/print_tags.h"

#define MAX_FILE_BYTES ((uint64_t)1 << 41)

enum { NONE = 1, LZW = 5, OLD_JPEG = 6, JPEG = 7, DEFLATE = 8, OLD_DEFLATE = 32946 };
enum { RGB = 2, PALETTE = 3, INKS = 5 };
enum { FILTER_NONE, FILTER_LEFT, FILTER_ABOVE };

struct lf_print_file {
    lf_tiff tiff;
    char *path;
    const char *unreadable;
    uint8_t *icc;
    lf_print_light *light; /* NULL: unreadable */
    void *row;             /* for lf_print_file_row */
    uint8_t *above;        /* of a PDF: the row before next_row */
    lf_strip *strip;
    int next_row; /* that the strip decodes next; -1: a strip must be begun */
};

/* ----------------------------------------------------------------------------------- opening -- */

/* Static text, or NULL. */
static const char *what_is_unreadable(const lf_tiff *tiff)
{
    const lf_print_tags *t = &tiff->tags;
    if (t->compression == JPEG || t->compression == OLD_JPEG)
        return "JPEG compression";
    if (t->compression != NONE && t->compression != LZW && t->compression != DEFLATE &&
        t->compression != OLD_DEFLATE)
        return "a compression other than none, LZW and deflate";
    if (t->palette || t->photometric == PALETTE)
        return "a palette";
    if (t->photometric != RGB && t->photometric != INKS)
        return "a colour space other than RGB and CMYK";
    if (t->extra_samples > 0)
        return "an alpha channel or other extra channels";
    if (t->samples != (t->photometric == RGB ? 3 : 4) || t->ink_set != 1)
        return "a number of channels other than 3 for RGB and 4 for CMYK";
    if (t->bits != 8 && t->bits != 16)
        return "a number of bits other than 8 and 16";
    if (t->sample_format != 1)
        return "samples that are not whole numbers";
    if (t->tiled || t->planar != 1)
        return t->tiled ? "tiles instead of strips" : "a plane per channel";
    if (t->fill_order != 1)
        return "bits in reverse order";
    if (t->predictor != 1 && !tiff->is_pdf && (t->predictor != 2 || t->compression == NONE))
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
    file->above = file->tiff.is_pdf ? lf_calloc(1, lf_print_file_raw_bytes(file)) : NULL;
    if (!file->row || (file->tiff.is_pdf && !file->above) ||
        lf_strip_create(&file->tiff, &file->strip) != LF_OK ||
        lf_print_light_create(t->samples, t->bits, file->icc, (size_t)t->icc_bytes, &file->light) !=
            LF_OK)
        return lf_error_set(err, LF_E_NOMEM, file->path, "out of memory");
    return LF_OK;
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
        status = lf_pdf_is(&file->tiff) ? lf_pdf_tags_read(&file->tiff, err)
                                        : lf_tiff_read(&file->tiff, err);
    if (status == LF_OK)
        status = read_profile(file, err);
    if (status == LF_OK) {
        file->unreadable = what_is_unreadable(&file->tiff);
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
    if (file->tiff.fd >= 0)
        close(file->tiff.fd);
    lf_print_light_destroy(file->light);
    lf_strip_destroy(file->strip);
    lf_free(file->row);
    lf_free(file->above);
    lf_free(file->icc);
    lf_free(file->path);
    lf_free(file);
}

/* ------------------------------------------------------------------------------------- facts -- */

const lf_print_tags *lf_print_file_tags(const lf_print_file *file)
{
    return &file->tiff.tags;
}

const lf_print_boxes *lf_print_file_boxes(const lf_print_file *file)
{
    return file->tiff.is_pdf ? &file->tiff.boxes : NULL;
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

/* Undoes the horizontal predictor: each sample is stored as its difference from the one before. */
static void undo_predictor(const lf_print_tags *t, void *row)
{
    const size_t n = (size_t)t->width * (size_t)t->samples, step = (size_t)t->samples;
    uint8_t *row8 = row;
    uint16_t *row16 = row;
    if (t->bits == 8)
        for (size_t i = step; i < n; i++)
            row8[i] = (uint8_t)(row8[i] + row8[i - step]);
    else
        for (size_t i = step; i < n; i++)
            row16[i] = (uint16_t)(row16[i] + row16[i - step]);
}

static void swap_bytes(uint16_t *values, size_t n)
{
    for (size_t i = 0; i < n; i++)
        values[i] = (uint16_t)(values[i] << 8 | values[i] >> 8);
}

/* Skips within a plain strip need no reading. */
static bool begin_row(lf_print_file *file, int y, void *scratch)
{
    const lf_print_tags *t = &file->tiff.tags;
    const size_t bytes = lf_print_file_raw_bytes(file);
    const int first = y / t->rows_per_strip * t->rows_per_strip;
    if (file->next_row < first || file->next_row > y) {
        file->next_row = -1;
        if (!lf_strip_begin(file->strip, y / t->rows_per_strip))
            return false;
        file->next_row = first;
    }
    if (t->compression == NONE)
        return lf_strip_skip(file->strip, (uint64_t)(y - file->next_row) * bytes);
    for (; file->next_row < y; file->next_row++)
        if (!lf_strip_read(file->strip, scratch, bytes))
            return false;
    return true;
}

/* Rows of a PDF are filtered as those of PNG files, and follow from the row above. Averages and
 * Paeth's filter are not quiltrender's. */
static bool read_filtered(lf_print_file *file, int y, uint8_t *out)
{
    const lf_print_tags *t = &file->tiff.tags;
    const size_t bytes = lf_print_file_raw_bytes(file),
                 pixel = (size_t)t->samples * (size_t)t->bits / 8;
    if (file->next_row < 0 || file->next_row > y) {
        file->next_row = -1;
        if (!lf_strip_begin(file->strip, 0))
            return false;
        memset(file->above, 0, bytes);
        file->next_row = 0;
    }
    for (; file->next_row <= y; file->next_row++) {
        uint8_t filter;
        if (!lf_strip_read(file->strip, &filter, 1) || filter > FILTER_ABOVE ||
            !lf_strip_read(file->strip, out, bytes))
            return false;
        for (size_t i = 0; i < bytes && filter != FILTER_NONE; i++)
            out[i] = (uint8_t)(out[i] + (filter == FILTER_ABOVE ? file->above[i]
                                         : i < pixel            ? 0
                                                                : out[i - pixel]));
        memcpy(file->above, out, bytes);
    }
    return true;
}

lf_status lf_print_file_raw(lf_print_file *file, int y, void *out, lf_error *err)
{
    const lf_print_tags *t = &file->tiff.tags;
    const size_t bytes = lf_print_file_raw_bytes(file);
    if (file->unreadable)
        return lf_error_set(err, LF_E_FORMAT, file->path,
                            "has %s; save it as plain RGB or CMYK of 8 or 16 bits",
                            file->unreadable);
    const bool read = file->tiff.is_pdf
                          ? read_filtered(file, y, out)
                          : begin_row(file, y, out) && lf_strip_read(file->strip, out, bytes);
    if (!read) {
        file->next_row = -1;
        return lf_error_set(err, LF_E_FORMAT, file->path,
                            "damaged %s: row %d cannot be read; write the file again",
                            file->tiff.is_pdf ? "PDF" : "TIFF", y);
    }
    file->next_row = (y + 1) % t->rows_per_strip == 0 ? -1 : y + 1;
    if (t->bits == 16 && t->big_endian)
        swap_bytes(out, bytes / 2);
    if (t->predictor == 2)
        undo_predictor(t, out);
    return LF_OK;
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
    char *name = lf_path_beside(path, ".json"), *text = NULL;
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
