/* Reads the chunks of a PNG that define the meaning of pixels (W3C, Portable Network Graphics,
 * third edition, and its registered extensions) from their raw bytes: libpng knows few of them, and
 * substitutes some for others. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/image_colours.h"
#include "base/image_png.h"
#include "base/image_profile.h"
#include "base/number.h"

/* Bytes read of a chunk's data; the rest is skipped. */
enum { HELD = 65536 };

typedef struct walk {
    const lf_image_source *source;
    lf_image_notes *notes;
    uint8_t *data; /* [HELD] */
    size_t n;
    /* only the one with the highest priority counts: cICP, iCCP, sRGB, then these two */
    bool has_cicp, has_icc, has_srgb, has_gamma, has_chromaticities, is_rec709;
    uint32_t gamma;
    uint8_t cicp[4];
    bool has_track;
    double target[3], position[3]; /* of the camera that quiltd writes; NaN: not given */
} walk;

static bool read_at(const lf_image_source *source, uint64_t at, void *to, size_t n)
{
    if (at > source->size_bytes || n > source->size_bytes - at)
        return false;
    if (source->data)
        memcpy(to, source->data + at, n);
    return source->data || pread(source->fd, to, n, (off_t)at) == (ssize_t)n;
}

/* ------------------------------------------------------------------------------------ chunks -- */

static void take_gamma(walk *w)
{
    w->has_gamma = w->n >= 4;
    w->gamma = w->has_gamma ? lf_be32(w->data) : 0;
}

static void take_chromaticities(walk *w)
{
    double v[8];
    for (int i = 0; i < 8; i++)
        v[i] = w->n >= 32 ? lf_be32(w->data + 4 * i) / 1e5 : 0;
    const lf_chromaticities c = {{v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}, {v[0], v[1]}};
    w->has_chromaticities = w->n >= 32;
    w->is_rec709 = lf_is_rec709(&c);
}

static void take_cicp(walk *w)
{
    w->has_cicp = w->n >= 4;
    memcpy(w->cicp, w->data, 4);
}

static void take_icc(walk *w)
{
    w->has_icc = true;
}

static void take_srgb(walk *w)
{
    w->has_srgb = true;
}

static void take_exif(walk *w)
{
    lf_exif_read(w->data, w->n, w->source->meta);
}

static void take_aspect(walk *w)
{
    static const uint8_t unknown[8]; /* ffmpeg's */
    if (w->n >= 9 && memcmp(w->data, unknown, 8) != 0)
        lf_image_metadata_aspect(w->source->meta, "pHYs",
                                 (double)lf_be32(w->data + 4) / lf_be32(w->data));
}

static void note_animation(walk *w)
{
    if (w->n >= 8)
        lf_image_note(w->notes, "animation of %u frames (acTL); only its still image is read",
                      lf_be32(w->data));
}

static void note_stereo(walk *w)
{
    lf_image_note(w->notes, "two views side by side (sTER) are read as one image");
}

static void note_calibration(walk *w)
{
    lf_image_note(w->notes, "ignored pCAL, the unit of the values");
}

static void read_point(const char *text, double out[3])
{
    for (int i = 0; i < 3; i++) {
        text = *text == (i == 0 ? '[' : ',') ? lf_decimal_read(text + 1, ".", &out[i]) : NULL;
        if (!text) {
            out[i] = (double)NAN;
            return;
        }
    }
}

static double distance_of(const walk *w)
{
    const double x = w->target[0] - w->position[0], y = w->target[1] - w->position[1],
                 z = w->target[2] - w->position[2];
    return sqrt(x * x + y * y + z * z);
}

static void take_rate(lf_image_metadata *meta, const char *text)
{
    double rate = 0;
    if (lf_decimal_is(text, &rate) && rate > 0 && rate <= LF_IMAGE_MAX_RATE)
        meta->frame_rate = rate;
}

/* Texts that quiltd writes: the geometry of a picture with depth, and the rate of its frames. */
static void take_text(walk *w)
{
    lf_image_depth *d = &w->source->meta->depth;
    const struct {
        const char *name;
        double *to;
    } numbers[] = {{"quiltd.near", &d->near},   {"quiltd.far", &d->far},
                   {"quiltd.fov_y", &d->fov_y}, {"quiltd.aspect", &d->aspect},
                   {"quiltd.cone", &d->cone},   {"quiltd.views", &d->views},
                   {"quiltd.width", &d->width}, {"quiltd.height", &d->height}};
    char text[256] = "";
    memcpy(text, w->data, w->n < sizeof text - 1 ? w->n : sizeof text - 1);
    const size_t key = strlen(text);
    const char *value = key < sizeof text - 1 ? text + key + 1 : "";
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (strcmp(text, numbers[i].name) == 0 && !lf_decimal_is(value, numbers[i].to))
            *numbers[i].to = strcmp(value, "inf") == 0 ? (double)INFINITY : 0;
    if (strcmp(text, "quiltd.fps") == 0)
        take_rate(w->source->meta, value);
    if (strcmp(text, "quiltd.target") == 0)
        read_point(value, w->target);
    if (strcmp(text, "quiltd.position") == 0)
        read_point(value, w->position);
    if (strcmp(text, "quiltd.placement") == 0)
        d->centred = strcmp(value, "inclusive") == 0 ? 2 : 1;
    w->has_track = w->has_track || strcmp(text, "quiltd.track") == 0;
}

static const struct {
    const char *name;
    void (*take)(walk *w);
} chunks[] = {
    {"gAMA", take_gamma},       {"cHRM", take_chromaticities}, {"cICP", take_cicp},
    {"iCCP", take_icc},         {"sRGB", take_srgb},           {"eXIf", take_exif},
    {"pHYs", take_aspect},      {"acTL", note_animation},      {"sTER", note_stereo},
    {"pCAL", note_calibration}, {"tEXt", take_text},
};

static void walk_chunks(walk *w)
{
    uint8_t head[8];
    uint64_t at = 8;
    while (read_at(w->source, at, head, 8) && memcmp(head + 4, "IEND", 4) != 0) {
        uint32_t length = lf_be32(head);
        for (size_t i = 0; i < sizeof chunks / sizeof *chunks; i++) {
            if (memcmp(head + 4, chunks[i].name, 4) != 0)
                continue;
            w->n = length < HELD ? length : HELD;
            if (read_at(w->source, at + 8, w->data, w->n))
                chunks[i].take(w);
        }
        at += 12 + (uint64_t)length;
    }
}

/* ----------------------------------------------------------------------------------- colours -- */

static void note_colours(const walk *w, const uint8_t *profile, size_t size)
{
    static const uint8_t srgb[4] = {1, 13, 0, 1};
    if (w->has_cicp) {
        if (memcmp(w->cicp, srgb, 4) != 0)
            lf_image_note(w->notes, "cICP %u/%u/%u/%u is not applied; colours are read as sRGB",
                          w->cicp[0], w->cicp[1], w->cicp[2], w->cicp[3]);
    } else if (w->has_icc) {
        if (!profile || !lf_icc_is_srgb(profile, size))
            lf_image_note(w->notes,
                          "the ICC profile (iCCP) is not applied; colours are read as sRGB");
    } else if (!w->has_srgb) {
        /* 1/2.2 approximates sRGB */
        if (w->has_gamma && fabs(w->gamma / 1e5 - 1 / 2.2) > 0.02)
            lf_image_note(w->notes, "gAMA %g is not applied; colours are read as sRGB",
                          w->gamma / 1e5);
        if (w->has_chromaticities && !w->is_rec709)
            lf_image_note(w->notes, "cHRM is not applied; colours are read as Rec. 709");
    }
}

void lf_png_note(const lf_image_source *source, const uint8_t *profile, size_t size)
{
    if (!source->meta)
        return;
    const double none = (double)NAN;
    walk w = {.source = source,
              .notes = &source->meta->notes,
              .data = lf_calloc(HELD, 1),
              .target = {none, none, none},
              .position = {none, none, none}};
    if (!w.data)
        return;
    source->meta->depth = (lf_image_depth){0};
    walk_chunks(&w);
    source->meta->depth.distance = distance_of(&w);
    if (w.has_track || !lf_image_depth_is_valid(&source->meta->depth))
        source->meta->depth = (lf_image_depth){0};
    note_colours(&w, profile, size);
    lf_free(w.data);
}

/* -------------------------------------------------------------------------------------- size -- */

/* Finds the last chunk; the chunks before it may be cut off only with it. */
static bool ends(const lf_image_source *source)
{
    uint8_t head[8], last[4];
    uint64_t at = 8;
    while (read_at(source, at, head, 8)) {
        const uint64_t after = at + 8 + lf_be32(head);
        if (!read_at(source, after, last, 4))
            return false;
        if (memcmp(head + 4, "IEND", 4) == 0)
            return true;
        at = after + 4;
    }
    return false;
}

static lf_status measure(const lf_image_source *source, int *out_width, int *out_height,
                         lf_error *err)
{
    static const uint8_t begin[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    uint8_t head[24];
    if (!read_at(source, 0, head, 8) || memcmp(head, begin, 8) != 0)
        return lf_error_set(err, LF_E_STATE, source->where, "is not a PNG file");
    const bool has_size = read_at(source, 8, head, 16) && memcmp(head + 4, "IHDR", 4) == 0;
    const uint32_t width = has_size ? lf_be32(head + 8) : 0,
                   height = has_size ? lf_be32(head + 12) : 0;
    if (width < 1 || width > LF_IMAGE_MAX_SIDE || height < 1 || height > LF_IMAGE_MAX_SIDE)
        return lf_error_set(err, LF_E_FORMAT, source->where, "PNG: no valid size");
    if (!ends(source))
        return lf_error_set(err, LF_E_FORMAT, source->where, "PNG: the file ends too early");
    *out_width = (int)width;
    *out_height = (int)height;
    return LF_OK;
}

lf_status lf_png_measure(const char *path, const lf_roots *roots, int *out_width, int *out_height,
                         lf_error *err)
{
    lf_image_source source = {.where = path};
    lf_status status =
        lf_file_open(path, roots, LF_IMAGE_MAX_BYTES, &source.fd, &source.size_bytes, err);
    if (status != LF_OK)
        return status;
    status = measure(&source, out_width, out_height, err);
    close(source.fd);
    return status;
}

/* ------------------------------------------------------------------------------------- texts -- */

/* Takes the text of a chunk: its name, NUL, and its value. */
static void take_named(const char *text, size_t n_text, const char *const *names, int n,
                       char (*out)[LF_PNG_TEXT])
{
    const size_t name = strnlen(text, n_text), value = n_text - name > 0 ? n_text - name - 1 : 0;
    for (int i = 0; i < n; i++) {
        if (strncmp(text, names[i], name) != 0 || names[i][name] != '\0')
            continue;
        const size_t kept = value < LF_PNG_TEXT - 1 ? value : LF_PNG_TEXT - 1;
        memcpy(out[i], text + n_text - value, kept);
        out[i][kept] = '\0';
    }
}

static void read_texts(const lf_image_source *source, const char *const *names, int n,
                       char (*out)[LF_PNG_TEXT])
{
    uint8_t head[8];
    char text[LF_PNG_TEXT + 80]; /* names have up to 79 characters */
    uint64_t at = 8;
    while (read_at(source, at, head, 8) && memcmp(head + 4, "IEND", 4) != 0) {
        const uint32_t length = lf_be32(head);
        const size_t held = length < sizeof text ? length : sizeof text;
        if (memcmp(head + 4, "tEXt", 4) == 0 && read_at(source, at + 8, text, held))
            take_named(text, held, names, n, out);
        at += 12 + (uint64_t)length;
    }
}

lf_status lf_png_texts(const char *path, const lf_roots *roots, const char *const *names, int n,
                       char (*out)[LF_PNG_TEXT], lf_error *err)
{
    lf_image_source source = {.where = path};
    int width, height;
    lf_status status =
        lf_file_open(path, roots, LF_IMAGE_MAX_BYTES, &source.fd, &source.size_bytes, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < n; i++)
        out[i][0] = '\0';
    status = measure(&source, &width, &height, err);
    if (status == LF_OK)
        read_texts(&source, names, n, out);
    close(source.fd);
    return status;
}
