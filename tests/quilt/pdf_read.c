#include "tests/quilt/pdf_read.h"

#include <zlib.h>

#include "base/alloc.h"
#include "base/file.h"
#include "tests/testing.h"

const char *lf_pdf_read_object(const lf_pdf_read *pdf, int object)
{
    char head[32];
    const char *start = strstr(pdf->bytes + pdf->size - 64, "startxref\n");
    assert_non_null(start);
    const long table = atol(start + strlen("startxref\n"));
    assert_true(table > 0 && (size_t)table < pdf->size);
    assert_memory_equal(pdf->bytes + table, "xref\n0 ", 7);
    const char *rows = strchr(pdf->bytes + table + 7, '\n') + 1;
    assert_true(object < atoi(pdf->bytes + table + 7));
    const char *row = rows + 20 * (size_t)object;
    if (row[17] == 'f')
        return NULL;
    assert_memory_equal(row + 10, " 00000 n \n", 10);
    const char *at = pdf->bytes + atoll(row);
    snprintf(head, sizeof head, "%d 0 obj\n", object);
    assert_memory_equal(at, head, strlen(head));
    return at + strlen(head);
}

static double value_of(const char *dictionary, const char *key)
{
    const char *at = strstr(dictionary, key);
    assert_non_null(at);
    return atof(at + strlen(key));
}

static void read_box(const char *page, const char *name, double out[4])
{
    const char *at = strstr(page, name);
    assert_non_null(at);
    assert_int_equal(sscanf(strchr(at, '[') + 1, "%lf %lf %lf %lf", out, out + 1, out + 2, out + 3),
                     4);
}

static void unfilter(unsigned char *rows, int height, size_t row_bytes, size_t pixel)
{
    for (int y = 0; y < height; y++) {
        unsigned char *row = rows + (size_t)y * (row_bytes + 1), *data = row + 1;
        const unsigned char *above = y > 0 ? data - (row_bytes + 1) : NULL;
        assert_true(row[0] <= 2);
        for (size_t i = 0; i < row_bytes; i++)
            data[i] = (unsigned char)(data[i] + (row[0] == 1   ? (i < pixel ? 0 : data[i - pixel])
                                                 : row[0] == 2 ? (above ? above[i] : 0)
                                                               : 0));
    }
}

static void read_image(lf_pdf_read *pdf, const char *image)
{
    pdf->width = (int)value_of(image, "/Width");
    pdf->height = (int)value_of(image, "/Height");
    pdf->bits = (int)value_of(image, "/BitsPerComponent");
    pdf->channels = (int)value_of(image, "/Colors");
    assert_int_equal(value_of(image, "/Predictor"), 15);
    assert_int_equal(value_of(image, "/Columns"), pdf->width);
    assert_non_null(strstr(image, "/Filter /FlateDecode"));
    const long length = atol(lf_pdf_read_object(pdf, (int)value_of(image, "/Length")));
    const char *data = strstr(image, "stream\n") + strlen("stream\n");
    assert_memory_equal(data + length, "\nendstream\nendobj\n", 18);
    const size_t row_bytes = (size_t)pdf->width * (size_t)pdf->channels * (size_t)pdf->bits / 8,
                 n = (size_t)pdf->width * (size_t)pdf->channels * (size_t)pdf->height;
    uLongf size = (uLongf)((row_bytes + 1) * (size_t)pdf->height);
    unsigned char *rows = lf_calloc(size, 1);
    pdf->value = lf_calloc(n, sizeof *pdf->value);
    assert_true(rows && pdf->value);
    const uLongf expected = size;
    /* also compares the check sum */
    assert_int_equal(uncompress(rows, &size, (const unsigned char *)data, (uLong)length), Z_OK);
    assert_int_equal(size, expected);
    unfilter(rows, pdf->height, row_bytes, (size_t)pdf->channels * (size_t)pdf->bits / 8);
    for (size_t i = 0; i < n; i++) {
        const size_t per_row = n / (size_t)pdf->height, y = i / per_row, at = i % per_row;
        const unsigned char *row = rows + y * (row_bytes + 1) + 1;
        pdf->value[i] = pdf->bits == 8 ? row[at] : (uint16_t)(row[2 * at] << 8 | row[2 * at + 1]);
    }
    lf_free(rows);
}

/* The object whose dictionary has this text. */
static const char *find(const lf_pdf_read *pdf, const char *text)
{
    for (int object = 1; object < pdf->n_objects; object++) {
        const char *at = lf_pdf_read_object(pdf, object);
        const char *end = at ? strstr(at, "endobj") : NULL, *found = at ? strstr(at, text) : NULL;
        if (found && (!end || found < end))
            return at;
    }
    return NULL;
}

void lf_pdf_read_file(const char *path, lf_pdf_read *out)
{
    lf_error err;
    *out = (lf_pdf_read){0};
    lf_assert_ok(lf_file_read(path, NULL, 1 << 30, &out->bytes, &out->size, &err), &err);
    assert_memory_equal(out->bytes, "%PDF-1.6\n", 9);
    assert_memory_equal(out->bytes + out->size - 6, "%%EOF\n", 6);
    const char *trailer = out->bytes + out->size - 64;
    while (memcmp(trailer, "trailer\n", 8) != 0)
        trailer--;
    out->n_objects = (int)value_of(trailer, "/Size");
    const char *page = find(out, "/Type /Page /Parent"), *image = find(out, "/Subtype /Image");
    assert_non_null(page);
    read_box(page, "/MediaBox", out->media);
    read_box(page, "/BleedBox", out->bleed);
    read_box(page, "/TrimBox", out->trim);
    if (!image)
        return;
    read_image(out, image);
    const char *content = find(out, " cm /I Do");
    assert_non_null(content);
    double *m = out->matrix;
    assert_int_equal(sscanf(strstr(content, "q "), "q %lf %lf %lf %lf %lf %lf cm", m, m + 1, m + 2,
                            m + 3, m + 4, m + 5),
                     6);
}

void lf_pdf_read_finish(lf_pdf_read *pdf)
{
    lf_free(pdf->bytes);
    lf_free(pdf->value);
    *pdf = (lf_pdf_read){0};
}

int lf_pdf_read_has(const lf_pdf_read *pdf, const char *text)
{
    return memmem(pdf->bytes, pdf->size, text, strlen(text)) ? 1 : 0;
}
