/* The page of a PDF that quiltrender wrote, read without a library: one image under one matrix. All
 * references are followed through the table of objects, and checked against the file. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"
#include "quilt/proof/print_tags.h"

#define TEXT_BYTES 2048  /* of a dictionary */
#define TAIL_BYTES 64    /* from "startxref" to the end */
#define MAX_OBJECTS 4096 /* quiltrender's have a dozen */
/* More than deflate can expand a byte. */
#define MAX_GROWTH 1100

typedef struct reader {
    lf_tiff *tiff;
    uint64_t table, n_objects; /* entries of 20 bytes */
    char text[TEXT_BYTES + 1]; /* of the object that was read last, up to its data */
    uint64_t data_at;          /* 0: it has none */
} reader;

static lf_status refuse(const lf_tiff *tiff, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, tiff->where,
                        "a PDF that quiltrender did not write, or that is damaged: %s; write it "
                        "again",
                        what);
}

/* Text of at most `most` bytes from a place on. */
static bool read_text(const lf_tiff *tiff, uint64_t at, size_t most, char *out)
{
    const uint64_t left = at < tiff->size ? tiff->size - at : 0;
    const size_t n = left < most ? (size_t)left : most;
    out[n] = '\0';
    return n > 0 && lf_tiff_bytes(tiff, at, out, n);
}

static const char *skip_blanks(const char *at)
{
    while (*at == ' ' || *at == '\n' || *at == '[')
        at++;
    return at;
}

/* What follows a key of a dictionary; NULL: it does not have it. */
static const char *value_of(const char *dictionary, const char *key)
{
    const size_t n = strlen(key);
    for (const char *at = strstr(dictionary, key); at; at = strstr(at + 1, key))
        if (at[n] == ' ' || at[n] == '\n' || at[n] == '[')
            return skip_blanks(at + n);
    return NULL;
}

static bool take_whole(const char *dictionary, const char *key, uint64_t most, uint64_t *out)
{
    const char *at = value_of(dictionary, key);
    uint64_t value;
    if (!at || !lf_whole_read(at, &value) || value > most)
        return false;
    *out = value;
    return true;
}

/* n numbers with blanks between them; returns the text behind them, NULL: they are not there. */
static const char *take_numbers(const char *at, int n, double *out)
{
    for (int i = 0; i < n && at; i++) {
        at = lf_decimal_read(skip_blanks(at), ".", &out[i]);
        if (at && !isfinite(out[i]))
            return NULL;
    }
    return at;
}

/* ------------------------------------------------------------------------------- the objects -- */

static bool read_object(reader *r, uint64_t object)
{
    char entry[21], head[32];
    uint64_t at;
    if (object >= r->n_objects || !read_text(r->tiff, r->table + 20 * object, 20, entry) ||
        entry[17] != 'n' || !lf_whole_read(entry, &at) ||
        !read_text(r->tiff, at, TEXT_BYTES, r->text))
        return false;
    const int n = snprintf(head, sizeof head, "%llu 0 obj\n", (unsigned long long)object);
    if (strncmp(r->text, head, (size_t)n) != 0)
        return false;
    char *end = strstr(r->text, "endobj"), *data = strstr(r->text, "stream\n");
    r->data_at = 0;
    if (data && (!end || data < end)) {
        r->data_at = at + (uint64_t)(data - r->text) + sizeof "stream\n" - 1;
        *data = '\0';
    } else if (end) {
        *end = '\0';
    }
    return data || end;
}

/* Reads the object that a key of the present one refers to. */
static bool follow(reader *r, const char *key)
{
    uint64_t object;
    return take_whole(r->text, key, MAX_OBJECTS, &object) && read_object(r, object);
}

/* Where the data of the present object lie; they must be inside the file. */
static bool take_data(const reader *r, uint64_t length, uint64_t *out_at)
{
    if (r->data_at == 0 || length > r->tiff->size - r->data_at)
        return false;
    *out_at = r->data_at;
    return true;
}

/* The end of the file leads to its catalogue. */
static bool read_tail(reader *r)
{
    char tail[TAIL_BYTES + 1], table[TEXT_BYTES + 1];
    const uint64_t size = r->tiff->size;
    if (size < TAIL_BYTES || !read_text(r->tiff, size - TAIL_BYTES, TAIL_BYTES, tail))
        return false;
    const char *start = strstr(tail, "startxref\n"), *rows;
    if (!start || !(rows = lf_whole_read(start + strlen("startxref\n"), &r->table)) ||
        strcmp(rows, "\n%%EOF\n") != 0 || !read_text(r->tiff, r->table, TEXT_BYTES, table) ||
        strncmp(table, "xref\n0 ", 7) != 0 || !(rows = lf_whole_read(table + 7, &r->n_objects)) ||
        *rows != '\n' || r->n_objects > MAX_OBJECTS)
        return false;
    r->table += (uint64_t)(rows + 1 - table);
    return read_text(r->tiff, r->table + 20 * r->n_objects, TEXT_BYTES, r->text) &&
           strncmp(r->text, "trailer\n", 8) == 0;
}

/* --------------------------------------------------------------------------------- the parts -- */

/* Takes the profile of the present object. */
static bool take_profile(const reader *r)
{
    lf_tiff *tiff = r->tiff;
    return take_whole(r->text, "/Length", LF_PRINT_FILE_MAX_PROFILE, &tiff->tags.icc_bytes) &&
           take_data(r, tiff->tags.icc_bytes, &tiff->icc_at);
}

/* The catalogue is the present object. */
static bool read_intent(reader *r)
{
    lf_print_boxes *boxes = &r->tiff->boxes;
    if (!value_of(r->text, "/OutputIntents"))
        return true;
    if (!follow(r, "/OutputIntents"))
        return false;
    boxes->has_intent = strstr(r->text, "/S /GTS_PDFX") && value_of(r->text, "/DestOutputProfile");
    return !boxes->has_intent || (follow(r, "/DestOutputProfile") && take_profile(r));
}

static bool read_boxes(reader *r)
{
    lf_print_boxes *boxes = &r->tiff->boxes;
    const char *media = value_of(r->text, "/MediaBox"), *trim = value_of(r->text, "/TrimBox"),
               *bleed = value_of(r->text, "/BleedBox");
    boxes->turned = value_of(r->text, "/Rotate") || value_of(r->text, "/UserUnit");
    return media && trim && bleed && take_numbers(media, 4, boxes->media) &&
           take_numbers(trim, 4, boxes->trim) && take_numbers(bleed, 4, boxes->bleed);
}

/* The page's content, which is the present object, paints the image and nothing else. */
static bool read_matrix(const reader *r)
{
    char text[TEXT_BYTES + 1];
    uint64_t length, at;
    if (!take_whole(r->text, "/Length", TEXT_BYTES, &length) || !take_data(r, length, &at) ||
        !read_text(r->tiff, at, (size_t)length, text) || strncmp(text, "q ", 2) != 0)
        return false;
    const char *end = take_numbers(text + 2, 6, r->tiff->boxes.matrix);
    return end && strcmp(end, " cm /I Do Q\n") == 0;
}

static int colours_of(const char *image)
{
    const char *space = value_of(image, "/ColorSpace");
    if (!space)
        return 0;
    return strncmp(space, "/ICCBased", 9) == 0 || strncmp(space, "/DeviceRGB", 10) == 0 ? 2
           : strncmp(space, "/DeviceCMYK", 11) == 0                                     ? 5
                                                                                        : 1;
}

/* The image is the present object. */
static bool read_image(reader *r)
{
    lf_tiff *tiff = r->tiff;
    lf_print_tags *tags = &tiff->tags;
    uint64_t width, height, bits, channels, predictor, length = 0;
    if (!take_whole(r->text, "/Width", LF_PRINT_FILE_MAX_SIDE, &width) ||
        !take_whole(r->text, "/Height", LF_PRINT_FILE_MAX_SIDE, &height) ||
        !take_whole(r->text, "/BitsPerComponent", 16, &bits) ||
        !take_whole(r->text, "/Colors", 4, &channels) ||
        !take_whole(r->text, "/Predictor", 15, &predictor) || predictor != LF_PREDICTOR_PNG ||
        width < 1 || height < 1 || channels < 1 || (bits != 8 && bits != 16) ||
        !strstr(r->text, "/Filter /FlateDecode") || value_of(r->text, "/SMask") ||
        value_of(r->text, "/Decode"))
        return false;
    tags->width = (int)width;
    tags->height = tags->rows_per_strip = (int)height;
    tags->bits = (int)bits;
    tags->samples = (int)channels;
    tags->photometric = colours_of(r->text);
    tiff->boxes.interpolated = !strstr(r->text, "/Interpolate false");
    const uint64_t data = r->data_at;
    const char *space = value_of(r->text, "/ColorSpace");
    const bool has_profile = space && strncmp(space, "/ICCBased", 9) == 0;
    char image[sizeof r->text];
    memcpy(image, r->text, sizeof image);
    if (!follow(r, "/Length") || data == 0)
        return false;
    const char *number = strchr(r->text, '\n');
    if (!number || !lf_whole_read(number + 1, &length) || length > tiff->size - data)
        return false;
    tiff->offsets = (lf_tiff_list){.at = data, .count = 1};
    tiff->byte_counts = (lf_tiff_list){.at = length, .count = 1};
    memcpy(r->text, image, sizeof image);
    return !has_profile || (follow(r, "/ICCBased") && take_profile(r));
}

/* Dots per inch, without the rounding of the page's size. */
static void set_dpi(lf_tiff *tiff)
{
    const double size[2] = {tiff->boxes.matrix[0], tiff->boxes.matrix[3]};
    const int pixels[2] = {tiff->tags.width, tiff->tags.height};
    for (int i = 0; i < 2; i++) {
        if (!(size[i] > 0.0))
            continue;
        const double dpi = pixels[i] * 72.0 / size[i], rounded = round(1e4 * dpi) / 1e4;
        tiff->tags.dpi[i] =
            rounded > 0.0 && fabs(pixels[i] * 72.0 / rounded - size[i]) <= LF_PDF_ROUNDING ? rounded
                                                                                           : dpi;
    }
}

bool lf_pdf_is(const lf_tiff *tiff)
{
    char head[5];
    return lf_tiff_bytes(tiff, 0, head, sizeof head) && memcmp(head, "%PDF-", sizeof head) == 0;
}

lf_status lf_pdf_tags_read(lf_tiff *tiff, lf_error *err)
{
    reader r = {.tiff = tiff};
    tiff->is_pdf = true;
    tiff->tags = (lf_print_tags){.ink_set = 1,
                                 .compression = 8,
                                 .predictor = LF_PREDICTOR_PNG,
                                 .planar = 1,
                                 .orientation = 1,
                                 .sample_format = 1,
                                 .fill_order = 1,
                                 .unit = 2,
                                 .n_strips = 1,
                                 .big_endian = true,
                                 .file_bytes = tiff->size};
    if (!read_tail(&r))
        return refuse(tiff, "its end", err);
    char trailer[sizeof r.text], page[sizeof r.text];
    uint64_t n_pages = 0;
    memcpy(trailer, r.text, sizeof trailer);
    if (follow(&r, "/Info"))
        tiff->boxes.says_x = strstr(r.text, "/GTS_PDFXVersion (PDF/X-4)");
    memcpy(r.text, trailer, sizeof trailer);
    if (!follow(&r, "/Root") || !read_intent(&r))
        return refuse(tiff, "its output intent", err);
    memcpy(r.text, trailer, sizeof trailer);
    if (!follow(&r, "/Root") || !follow(&r, "/Pages") ||
        !take_whole(r.text, "/Count", MAX_OBJECTS, &n_pages) || !follow(&r, "/Kids") ||
        !read_boxes(&r))
        return refuse(tiff, "its page", err);
    tiff->tags.more_pages = n_pages != 1;
    memcpy(page, r.text, sizeof page);
    if (!follow(&r, "/Contents") || !read_matrix(&r))
        return refuse(tiff, "it paints more than one image", err);
    memcpy(r.text, page, sizeof page);
    if (!follow(&r, "/I") || !read_image(&r))
        return refuse(tiff, "its image", err);
    const double raster =
        (double)tiff->tags.width * tiff->tags.height * tiff->tags.samples * (tiff->tags.bits / 8.0);
    if (raster > MAX_GROWTH * (double)tiff->size)
        return refuse(tiff, "it is shorter than its pixels", err);
    set_dpi(tiff);
    return LF_OK;
}
