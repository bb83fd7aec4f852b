/* EXR files byte by byte, for tests that need what no library writes: any attribute, part and
 * channel. Pixels lie in them as plain scan lines, every one of the same numbers but the first, or
 * of a function. After "OpenEXR File Layout" (openexr.com). */
#ifndef LF_TESTS_BASE_EXR_BYTES_H
#define LF_TESTS_BASE_EXR_BYTES_H

#include "tests/base/pictures.h"

enum { EXR_BYTES = 1 << 20, EXR_CHANNELS = 8 };
enum { EXR_UINT, EXR_HALF, EXR_FLOAT };

typedef struct exr_attribute_bytes {
    const char *name, *type;
    const void *data;
    int size;
} exr_attribute_bytes;

typedef struct exr_part_bytes {
    const char *channels[EXR_CHANNELS]; /* in ascending order; NULL behind the last */
    float value[EXR_CHANNELS];          /* of every pixel */
    float first[EXR_CHANNELS];          /* of the first, where `odd` */
    bool odd;
    /* NULL, or the number of channel c at a pixel, in place of these */
    float (*at)(int c, int x, int y);
    int type;         /* of all channels */
    int display[4];   /* x0, y0, x1, y1, ends included; all 0: as the data window */
    int data[4];      /* all 0: 0 0 3 2 */
    int order;        /* line order: 1 = the last line comes first */
    bool deep;        /* says so; has no pixels */
    const char *name; /* of a part of several */
    exr_attribute_bytes attributes[4];
} exr_part_bytes;

typedef struct exr_file_bytes {
    unsigned char data[EXR_BYTES];
    size_t n;
} exr_file_bytes;

static inline void exr_put(exr_file_bytes *f, const void *data, size_t n)
{
    assert_true(f->n + n <= EXR_BYTES);
    memcpy(f->data + f->n, data, n);
    f->n += n;
}

static inline void exr_put_int(exr_file_bytes *f, int32_t value)
{
    exr_put(f, &value, 4);
}

static inline void exr_put_attribute(exr_file_bytes *f, const char *name, const char *type,
                                     const void *data, size_t size)
{
    exr_put(f, name, strlen(name) + 1);
    exr_put(f, type, strlen(type) + 1);
    exr_put_int(f, (int32_t)size);
    exr_put(f, data, size);
}

static inline const int *exr_window(const exr_part_bytes *part, bool display)
{
    static const int usual[4] = {0, 0, 3, 2};
    const int *data = part->data[2] ? part->data : usual;
    return display && part->display[2] ? part->display : data;
}

static inline void exr_put_channels(exr_file_bytes *f, const exr_part_bytes *part)
{
    unsigned char list[512];
    size_t n = 0;
    for (int c = 0; part->channels[c]; c++) {
        const int32_t words[4] = {part->type, 0, 1, 1};
        size_t length = strlen(part->channels[c]) + 1;
        memcpy(list + n, part->channels[c], length);
        memcpy(list + n + length, words, 16);
        n += length + 16;
    }
    list[n++] = 0;
    exr_put_attribute(f, "channels", "chlist", list, n);
}

static inline void exr_put_header(exr_file_bytes *f, const exr_part_bytes *part)
{
    const char *storage = part->deep ? "deepscanline" : "scanlineimage";
    const unsigned char none = 0, order = (unsigned char)part->order;
    const float one = 1, centre[2] = {0, 0};
    const int32_t lines = exr_window(part, false)[3] - exr_window(part, false)[1] + 1, version = 1;
    exr_put_channels(f, part);
    exr_put_attribute(f, "compression", "compression", &none, 1);
    exr_put_attribute(f, "dataWindow", "box2i", exr_window(part, false), 16);
    exr_put_attribute(f, "displayWindow", "box2i", exr_window(part, true), 16);
    exr_put_attribute(f, "lineOrder", "lineOrder", &order, 1);
    if (part->name || part->deep) {
        if (part->name)
            exr_put_attribute(f, "name", "string", part->name, strlen(part->name));
        exr_put_attribute(f, "type", "string", storage, strlen(storage));
        exr_put_attribute(f, "version", "int", &version, 4);
        exr_put_attribute(f, "chunkCount", "int", &lines, 4);
        if (part->deep)
            exr_put_attribute(f, "maxSamplesPerPixel", "int", &version, 4);
    }
    bool aspect = false;
    for (int i = 0; i < 4 && part->attributes[i].name; i++) {
        const exr_attribute_bytes *a = &part->attributes[i];
        exr_put_attribute(f, a->name, a->type, a->data, (size_t)a->size);
        aspect = aspect || strcmp(a->name, "pixelAspectRatio") == 0;
    }
    if (!aspect)
        exr_put_attribute(f, "pixelAspectRatio", "float", &one, 4);
    exr_put_attribute(f, "screenWindowCenter", "v2f", centre, 8);
    exr_put_attribute(f, "screenWindowWidth", "float", &one, 4);
    exr_put(f, &none, 1);
}

static inline void exr_put_number(exr_file_bytes *f, int type, float value)
{
    const uint32_t whole = (uint32_t)value;
    ImfHalf half;
    ImfFloatToHalf(value, &half);
    if (type == EXR_HALF)
        exr_put(f, &half, 2);
    else
        exr_put(f, type == EXR_UINT ? (const void *)&whole : (const void *)&value, 4);
}

static inline float exr_number_of(const exr_part_bytes *part, int c, int x, int y)
{
    const int *w = exr_window(part, false);
    if (part->at)
        return part->at(c, x, y);
    return part->odd && x == w[0] && y == w[1] ? part->first[c] : part->value[c];
}

static inline void exr_put_line(exr_file_bytes *f, const exr_part_bytes *part, int y)
{
    const int *w = exr_window(part, false);
    int width = w[2] - w[0] + 1, n = 0;
    while (part->channels[n])
        n++;
    exr_put_int(f, y);
    exr_put_int(f, n * width * (part->type == EXR_HALF ? 2 : 4));
    for (int c = 0; c < n; c++)
        for (int x = 0; x < width; x++)
            exr_put_number(f, part->type, exr_number_of(part, c, x + w[0], y));
}

/* A file of one part, or of several, which have names. */
static inline void exr_write(const char *path, const exr_part_bytes *parts, int n)
{
    static exr_file_bytes f;
    const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01}, none = 0;
    size_t table[4] = {0};
    f.n = 0;
    assert_true(n <= 4);
    exr_put(&f, magic, 4);
    exr_put_int(&f, 2 | (n > 1 ? 0x1000 : 0) | (parts[0].deep ? 0x800 : 0));
    for (int i = 0; i < n; i++)
        exr_put_header(&f, &parts[i]);
    if (n > 1)
        exr_put(&f, &none, 1);
    for (int i = 0; i < n; i++) {
        const int *w = exr_window(&parts[i], false);
        table[i] = f.n;
        for (int y = w[1]; y <= w[3]; y++)
            exr_put(&f, (const uint64_t[]){0}, 8);
    }
    for (int i = 0; i < n; i++) {
        const int *w = exr_window(&parts[i], false);
        for (int k = w[1]; k <= w[3] && !parts[i].deep; k++) {
            int y = parts[i].order == 1 ? w[3] + w[1] - k : k;
            const uint64_t at = f.n;
            memcpy(f.data + table[i] + 8 * (size_t)(y - w[1]), &at, 8);
            if (n > 1)
                exr_put_int(&f, i);
            exr_put_line(&f, &parts[i], y);
        }
    }
    lf_picture_write(path, f.data, f.n);
}

#endif
