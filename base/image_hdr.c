/* Radiance pictures: G. Ward, "Real Pixels" (Graphics Gems II, 1991) and the format notes of the
 * Radiance manual. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_colours.h"
#include "base/image_formats.h"

#define MAX_HEADER_LINES 1000

/* A buffered reader, because run lengths are read byte by byte. */
typedef struct reader {
    const lf_image_source *source;
    lf_error *err;
    uint64_t offset;
    size_t used, held;
    uint8_t buffer[1 << 16];
} reader;

typedef struct hdr_header {
    int n_scans, n_along;   /* scan lines in the file, and pixels per scan line */
    bool scans_are_columns; /* the first axis was X */
    bool flip_x, flip_y;    /* stored from the right, from the bottom */
    double pixel_height;    /* in pixel widths: the product of all PIXASPECT */
    double gain[3];         /* to undo EXPOSURE and COLORCORR */
    bool xyz;               /* pixels are X, Y, Z */
    bool has_primaries;
    lf_chromaticities primaries;
} hdr_header;

static bool recognises_hdr(const uint8_t *head, size_t n)
{
    return (n >= 10 && memcmp(head, "#?RADIANCE", 10) == 0) ||
           (n >= 6 && memcmp(head, "#?RGBE", 6) == 0);
}

static lf_status fail(const reader *r, const char *what)
{
    return lf_error_set(r->err, LF_E_FORMAT, r->source->where, "Radiance HDR: %s", what);
}

/* The next byte; -1 at the end or on an error. */
static int next(reader *r)
{
    if (r->used == r->held) {
        ssize_t n;
        do
            n = pread(r->source->fd, r->buffer, sizeof r->buffer, (off_t)r->offset);
        while (n < 0 && errno == EINTR);
        if (n <= 0)
            return -1;
        r->offset += (uint64_t)n;
        r->held = (size_t)n;
        r->used = 0;
    }
    return r->buffer[r->used++];
}

static bool next_bytes(reader *r, uint8_t *to, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        int c = next(r);
        if (c < 0)
            return false;
        to[i] = (uint8_t)c;
    }
    return true;
}

/* A line without its end; false: the file ends or the line is too long. */
static bool next_line(reader *r, char *line, size_t size)
{
    size_t n = 0;
    for (;;) {
        int c = next(r);
        if (c < 0 || n + 1 >= size)
            return false;
        if (c == '\n')
            break;
        line[n++] = (char)c;
    }
    while (n > 0 && line[n - 1] == '\r')
        n--;
    line[n] = 0;
    return true;
}

static bool divide_gain(double *gain, double by)
{
    *gain /= by;
    return by > 0 && isfinite(by) && isfinite(*gain);
}

static lf_image_notes *notes_of(const reader *r)
{
    return r->source->meta ? &r->source->meta->notes : NULL;
}

static lf_status take_format(const reader *r, const char *line, hdr_header *h)
{
    h->xyz = strcmp(line + 7, "32-bit_rle_xyze") == 0;
    if (!h->xyz && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
        return lf_error_set(
            r->err, LF_E_FORMAT, r->source->where,
            "Radiance HDR: unsupported %.60s; expected 32-bit_rle_rgbe or 32-bit_rle_xyze", line);
    return LF_OK;
}

static void take_primaries(const reader *r, const char *line, hdr_header *h)
{
    lf_chromaticities *c = &h->primaries;
    h->has_primaries =
        sscanf(line + 10, "%lf %lf %lf %lf %lf %lf %lf %lf", &c->red[0], &c->red[1], &c->green[0],
               &c->green[1], &c->blue[0], &c->blue[1], &c->white[0], &c->white[1]) == 8;
    if (!h->has_primaries)
        lf_image_note(notes_of(r), "PRIMARIES does not have eight numbers; Rec. 709 is used");
}

/* Notes variables of pixels that are not radiance. */
static void note_variable(const reader *r, const char *line)
{
    if (strncmp(line, "GAMMA=", 6) == 0 && fabs(strtod(line + 6, NULL) - 1) > 1e-3)
        lf_image_note(notes_of(r), "ignored %.60s; the values are read as linear light", line);
}

static lf_status take_variable(const reader *r, const char *line, hdr_header *h)
{
    double c[3];
    if (strncmp(line, "FORMAT=", 7) == 0)
        return take_format(r, line, h);
    note_variable(r, line);
    if (strncmp(line, "PRIMARIES=", 10) == 0) {
        take_primaries(r, line, h);
    } else if (strncmp(line, "PIXASPECT=", 10) == 0) {
        h->pixel_height *= strtod(line + 10, NULL);
    } else if (strncmp(line, "EXPOSURE=", 9) == 0) {
        double exposure = strtod(line + 9, NULL);
        for (int i = 0; i < 3; i++)
            if (!divide_gain(&h->gain[i], exposure))
                return fail(r, "EXPOSURE must be a number above 0");
    } else if (strncmp(line, "COLORCORR=", 10) == 0) {
        if (sscanf(line + 10, "%lf %lf %lf", &c[0], &c[1], &c[2]) != 3)
            return fail(r, "COLORCORR must have three numbers");
        for (int i = 0; i < 3; i++)
            if (!divide_gain(&h->gain[i], c[i]))
                return fail(r, "COLORCORR must have three numbers above 0");
    }
    return LF_OK;
}

/* "-Y 512 +X 1024": the first axis runs from scan line to scan line; +y is up and +x is right. */
static lf_status take_resolution(const reader *r, const char *line, hdr_header *h)
{
    char sign[2], axis[2], rest;
    int size[2];
    if (sscanf(line, "%c%c %9d %c%c %9d %c", &sign[0], &axis[0], &size[0], &sign[1], &axis[1],
               &size[1], &rest) != 6)
        return fail(r, "no resolution line such as \"-Y 512 +X 1024\"");
    bool known = (axis[0] == 'Y' && axis[1] == 'X') || (axis[0] == 'X' && axis[1] == 'Y');
    for (int i = 0; i < 2; i++)
        known = known && (sign[i] == '+' || sign[i] == '-');
    if (!known)
        return fail(r, "no resolution line such as \"-Y 512 +X 1024\"");
    h->n_scans = size[0];
    h->n_along = size[1];
    h->scans_are_columns = axis[0] == 'X';
    h->flip_y = sign[h->scans_are_columns ? 1 : 0] == '+';
    h->flip_x = sign[h->scans_are_columns ? 0 : 1] == '-';
    return lf_image_check_shape(r->source, h->scans_are_columns ? h->n_scans : h->n_along,
                                h->scans_are_columns ? h->n_along : h->n_scans, 12, r->err);
}

static lf_status read_header(reader *r, hdr_header *h)
{
    char line[2048];
    *h = (hdr_header){.gain = {1, 1, 1}, .pixel_height = 1};
    for (int i = 0; i < MAX_HEADER_LINES; i++) {
        if (!next_line(r, line, sizeof line))
            return fail(r, "the header does not end");
        if (line[0] == 0) {
            if (!next_line(r, line, sizeof line))
                return fail(r, "no resolution line such as \"-Y 512 +X 1024\"");
            return take_resolution(r, line, h);
        }
        lf_status status = take_variable(r, line, h);
        if (status != LF_OK)
            return status;
    }
    return fail(r, "the header does not end");
}

/* One component of a scan line in the new encoding: a count over 128 is a run, otherwise
 * literals. */
static lf_status read_component(reader *r, uint8_t *to, int n)
{
    int i = 0;
    while (i < n) {
        int count = next(r);
        bool run = count > 128;
        if (run)
            count -= 128;
        if (count <= 0 || count > n - i)
            return fail(r, count < 0 ? "the file ends too early"
                                     : "a run is longer than its scan line");
        int value = 0;
        for (int k = 0; k < count; k++) {
            if (k == 0 || !run)
                value = next(r);
            if (value < 0)
                return fail(r, "the file ends too early");
            to[(size_t)(i + k) * 4] = (uint8_t)value;
        }
        i += count;
    }
    return LF_OK;
}

/* Plain pixels and the old run lengths, in which 1 1 1 n repeats the last pixel, n shifted by 8
 * more for each one in a row. */
static lf_status read_old_scan(reader *r, uint8_t *scan, int n, int n_done)
{
    int shift = 0;
    for (int i = n_done; i < n;) {
        uint8_t *pixel = scan + (size_t)i * 4;
        if (!next_bytes(r, pixel, 4))
            return fail(r, "the file ends too early");
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            shift = 0;
            i++;
            continue;
        }
        int64_t count = shift < 32 ? (int64_t)pixel[3] << shift : INT64_MAX;
        if (i == 0 || count > n - i)
            return fail(r, "a run is longer than its scan line");
        for (int64_t k = 0; k < count; k++)
            memcpy(scan + (size_t)(i + k) * 4, scan + (size_t)(i - 1) * 4, 4);
        i += (int)count;
        shift += 8;
    }
    return LF_OK;
}

static lf_status read_scan(reader *r, uint8_t *scan, int n)
{
    if (!next_bytes(r, scan, 4))
        return fail(r, "the file ends too early");
    bool is_new = n >= 8 && n < 32768 && scan[0] == 2 && scan[1] == 2 && scan[2] < 128;
    if (!is_new) {
        if (scan[0] == 1 && scan[1] == 1 && scan[2] == 1)
            return fail(r, "a run precedes the first pixel");
        return read_old_scan(r, scan, n, 1);
    }
    if ((scan[2] << 8 | scan[3]) != n)
        return fail(r, "a scan line has the wrong length");
    lf_status status = LF_OK;
    for (int c = 0; c < 4 && status == LF_OK; c++)
        status = read_component(r, scan + c, n);
    return status;
}

static void place_scan(const hdr_header *h, int s, const uint8_t *scan, const double scale[256],
                       lf_image32 *out)
{
    for (int i = 0; i < h->n_along; i++) {
        int x = h->scans_are_columns ? s : i, y = h->scans_are_columns ? i : s;
        if (h->flip_x)
            x = out->width - 1 - x;
        if (h->flip_y)
            y = out->height - 1 - y;
        const uint8_t *rgbe = scan + (size_t)i * 4;
        float *to = out->data + ((size_t)y * (size_t)out->width + (size_t)x) * 3;
        for (int c = 0; c < 3; c++)
            to[c] = (float)(rgbe[c] * scale[rgbe[3]] * h->gain[c]);
    }
}

static lf_status read_pixels(reader *r, const hdr_header *h, lf_image32 *out)
{
    double scale[256];
    scale[0] = 0;
    for (int e = 1; e < 256; e++)
        scale[e] = ldexp(1, e - 136);
    uint8_t *scan = lf_calloc((size_t)h->n_along, 4);
    lf_status status = scan ? LF_OK : LF_E_NOMEM;
    if (status == LF_OK)
        status = h->scans_are_columns ? lf_image32_init(out, h->n_scans, h->n_along, 3)
                                      : lf_image32_init(out, h->n_along, h->n_scans, 3);
    if (status != LF_OK)
        (void)lf_error_set(r->err, status, r->source->where, "not enough memory for the image");
    for (int s = 0; s < h->n_scans && status == LF_OK; s++) {
        status = read_scan(r, scan, h->n_along);
        if (status == LF_OK)
            place_scan(h, s, scan, scale, out);
    }
    lf_free(scan);
    return status;
}

/* X, Y, Z have fixed primaries, whatever the header says. */
static lf_image_colours colours_of(const reader *r, const hdr_header *h)
{
    lf_image_colours colours = {0};
    const lf_chromaticities *c = h->xyz ? &lf_xyz : h->has_primaries ? &h->primaries : &lf_rec709;
    if (lf_colours_from(c, NULL, &colours) != LF_OK)
        lf_image_note(notes_of(r), "PRIMARIES are degenerate; Rec. 709 is used");
    return colours;
}

static lf_status read_hdr(const lf_image_source *source, lf_image32 *out, lf_error *err)
{
    reader *r = lf_calloc(1, sizeof *r);
    if (!r)
        return lf_error_set(err, LF_E_NOMEM, source->where, "not enough memory for the image");
    r->source = source;
    r->err = err;
    hdr_header header;
    lf_image32 image = {0};
    lf_status status = read_header(r, &header);
    if (status == LF_OK)
        status = read_pixels(r, &header, &image);
    if (status == LF_OK) {
        lf_image_colours colours = colours_of(r, &header);
        lf_image_settle(source, &colours, &image);
        if (source->meta)
            lf_image_metadata_aspect(source->meta, "PIXASPECT", 1 / header.pixel_height);
    }
    lf_free(r);
    if (status == LF_OK)
        *out = image;
    else
        lf_image32_finish(&image);
    return status;
}

static const char *const endings[] = {".hdr", NULL};

const lf_image_format lf_format_hdr = {.name = "Radiance HDR",
                                       .endings = endings,
                                       .kind = LF_IMAGE_FLOAT,
                                       .recognises = recognises_hdr,
                                       .read32 = read_hdr};
