/* glTF written by tests: bytes that become a data uri, views and accessors of them in the order in
 * which they are added, and the rest as text with ' for ". Read in the test's own process. */
#ifndef LF_TESTS_GLTF_TEXT_H
#define LF_TESTS_GLTF_TEXT_H

#include "tests/testing.h"

#include <sys/mman.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/mesh_read.h"

/* Files beside the text: none is there. */
lf_status lf_ask_for_file(const char *name, int *out_fd)
{
    (void)name;
    *out_fd = -1;
    return LF_E_IO;
}

lf_status lf_try_for_file(const char *name, int *out_fd)
{
    return lf_ask_for_file(name, out_fd);
}

typedef struct gltf_text {
    unsigned char bytes[8192];
    size_t n;
    int n_views, n_accessors;
    char views[4096], accessors[4096];
} gltf_text;

static inline void LF_PRINTF(2, 3) gltf_say(char text[4096], const char *format, ...)
{
    size_t at = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(text + at, 4096 - at, format, arguments);
    va_end(arguments);
    assert_true(n >= 0 && at + (size_t)n < 4096);
}

/* more: members of the view, each behind a comma. */
static inline int gltf_view(gltf_text *text, const void *data, size_t n, const char *more)
{
    assert_true(text->n + n + 4 < sizeof text->bytes);
    memcpy(text->bytes + text->n, data, n);
    gltf_say(text->views, "%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu%s}",
             text->n_views ? "," : "", text->n, n, more);
    text->n = (text->n + n + 3) / 4 * 4;
    return text->n_views++;
}

static inline int gltf_accessor(gltf_text *text, int view, int type, int count, const char *shape,
                                const char *more)
{
    gltf_say(text->accessors, "%s{'componentType':%d,'count':%d,'type':'%s'",
             text->n_accessors ? "," : "", type, count, shape);
    if (view >= 0)
        gltf_say(text->accessors, ",'bufferView':%d", view);
    gltf_say(text->accessors, "%s}", more);
    return text->n_accessors++;
}

static inline int gltf_put_floats(gltf_text *text, const float *values, int count,
                                  const char *shape)
{
    int each = strcmp(shape, "SCALAR") == 0 ? 1 : strcmp(shape, "MAT4") == 0 ? 16 : shape[3] - '0';
    size_t n = (size_t)count * (size_t)each * sizeof *values;
    return gltf_accessor(text, gltf_view(text, values, n, ""), 5126, count, shape, "");
}

static inline void gltf_base64(const unsigned char *data, size_t n, FILE *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < n; i += 3) {
        uint32_t three = (uint32_t)data[i] << 16 | (uint32_t)(i + 1 < n ? data[i + 1] : 0) << 8 |
                         (i + 2 < n ? data[i + 2] : 0);
        for (int k = 0; k < 4; k++)
            putc(i + (size_t)k > n ? '=' : digits[three >> (18 - 6 * k) & 63], out);
    }
}

/* rest: members of the document, without a comma behind the last. */
static inline lf_status gltf_read_as(const gltf_text *text, const char *rest,
                                     const lf_mesh_desc *desc, lf_mesh_data *out, lf_error *err)
{
    int fd = memfd_create("gltf", 0);
    FILE *file = fdopen(fd, "wb");
    assert_non_null(file);
    fputs("{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"data:;base64,", file);
    gltf_base64(text->bytes, text->n, file);
    fprintf(file, "\",\"byteLength\":%zu}],\"bufferViews\":[", text->n);
    for (const char *c = text->views; *c; c++)
        putc(*c == '\'' ? '"' : *c, file);
    fputs("],\"accessors\":[", file);
    for (const char *c = text->accessors; *c; c++)
        putc(*c == '\'' ? '"' : *c, file);
    fputs("],", file);
    for (const char *c = rest; *c; c++)
        putc(*c == '\'' ? '"' : *c, file);
    fputs("}", file);
    fflush(file);
    lf_status status = lf_gltf_read(desc, fd, out, err);
    fclose(file);
    return status;
}

static inline lf_mesh_desc gltf_desc(void)
{
    return (lf_mesh_desc){
        .file = "folder/a.gltf", .material = -1, .transform = lf_affine_identity()};
}

static inline lf_mesh_data gltf_read(const gltf_text *text, const char *rest)
{
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err = {0};
    if (gltf_read_as(text, rest, &desc, &data, &err) != LF_OK)
        fail_msg("%s", err.what);
    return data;
}

static inline void gltf_assert_refused(const gltf_text *text, const char *rest, const char *words)
{
    lf_mesh_desc desc = gltf_desc();
    lf_mesh_data data = {0};
    lf_error err = {0};
    assert_int_equal(gltf_read_as(text, rest, &desc, &data, &err), LF_E_FORMAT);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" says nothing of \"%s\"", err.what, words);
    lf_mesh_data_finish(&data);
}

static inline bool gltf_warns(const lf_mesh_data *data, const char *words)
{
    for (int i = 0; lf_warnings_at(&data->warnings, i); i++)
        if (strstr(lf_warnings_at(&data->warnings, i), words))
            return true;
    return false;
}

/* A picture of one pixel. */
#define GLTF_PNG                                                                                   \
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADh"  \
    "gGAWjR9awAAAABJRU5ErkJggg=="

#define GLTF_ONE_NODE "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}]"

#endif
