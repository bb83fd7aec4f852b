/* What glTF 2.0 says of its own lengths (specification, sections 3.6 and 4.4), before anybody makes
 * room for it. A file that is no such JSON is left to whoever reads it. */
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/reader/reader.h"
#include "render/reader/mesh_read.h"
#include "render/reader/words.h"

#define MOST_ELEMENTS (3 * (json_int_t)LF_MAX_TRIANGLES)
#define JSON_CHUNK 0x4e4f534au
#define BINARY_CHUNK 0x004e4942u

/* A file and where its JSON lies in it; binary: bytes of a GLB's own buffer. */
typedef struct gltf_file {
    uint64_t size, begin, length, binary;
} gltf_file;

static lf_status refuse(lf_error *err, const char *what, uint64_t has, uint64_t room)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "cannot be read as a mesh: %s %llu bytes, where there are %llu", what,
                        (unsigned long long)has, (unsigned long long)room);
}

static bool read_words(int fd, uint64_t at, uint32_t *words, size_t n)
{
    return pread(fd, words, n * sizeof *words, (off_t)at) == (ssize_t)(n * sizeof *words);
}

/* A GLB: 12 bytes, then chunks of a length, a kind, and as many bytes. */
static lf_status find_chunks(int fd, gltf_file *file, lf_error *err)
{
    uint32_t header[3] = {0}, chunk[2];
    (void)read_words(fd, 0, header, 3);
    if (header[2] > file->size)
        return refuse(err, "a GLB file of", header[2], file->size);
    for (uint64_t at = sizeof header, end = header[2];
         at + sizeof chunk <= end && read_words(fd, at, chunk, 2);) {
        at += sizeof chunk;
        if (chunk[0] > end - at)
            return refuse(err, "a chunk of", chunk[0], end - at);
        if (chunk[1] == JSON_CHUNK && file->length == 0) {
            file->begin = at;
            file->length = chunk[0];
        } else if (chunk[1] == BINARY_CHUNK && file->binary == 0) {
            file->binary = chunk[0];
        }
        at += (uint64_t)chunk[0] + (4 - chunk[0] % 4) % 4;
    }
    return LF_OK;
}

/* *out stays NULL where it is no JSON. */
static lf_status load_json(int fd, const gltf_file *file, json_t **out, lf_error *err)
{
    char *text = malloc((size_t)file->length + 1);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (pread(fd, text, (size_t)file->length, (off_t)file->begin) == (ssize_t)file->length)
        *out = json_loadb(text, (size_t)file->length, JSON_DISABLE_EOF_CHECK, NULL);
    free(text);
    return LF_OK;
}

/* Where a text begins that is an object, behind a mark and blanks; its size: nowhere. */
static uint64_t object_at(int fd, uint64_t size)
{
    char begin[256];
    ssize_t n = pread(fd, begin, sizeof begin, 0), at = 0;
    if (n >= 3 && memcmp(begin, "\xef\xbb\xbf", 3) == 0)
        at = 3;
    while (at < n && lf_is_blank(begin[at]))
        at++;
    return at < n && begin[at] == '{' ? (uint64_t)at : size;
}

/* A whole number that is not negative; else what is meant where there is none. */
static uint64_t whole(const json_t *object, const char *key, uint64_t unsaid)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value))
        return unsaid;
    double number = json_number_value(value);
    return number >= 0 && number < 0x1p53 ? (uint64_t)number : UINT64_C(1) << 53;
}

/* Of the file's own part, or of one that is written into it; others are looked at when they are
 * read. */
static lf_status check_buffer(const json_t *buffer, size_t i, const gltf_file *file, lf_error *err)
{
    static const char written[] = ";base64,";
    const char *uri = json_string_value(json_object_get(buffer, "uri")),
               *data = uri && strncmp(uri, "data:", 5) == 0 ? strstr(uri, written) : NULL;
    uint64_t length = whole(buffer, "byteLength", 0),
             room = data ? (strlen(data) - strlen(written)) / 4 * 3 + 3 : file->binary;
    if ((data || (!uri && i == 0)) && length > room)
        return refuse(err, "a buffer of", length, room);
    return LF_OK;
}

static lf_status check_view(const json_t *view, const json_t *buffers, lf_error *err)
{
    const json_t *buffer = json_array_get(buffers, whole(view, "buffer", UINT32_MAX));
    uint64_t end = whole(view, "byteOffset", 0) + whole(view, "byteLength", 0),
             room = whole(buffer, "byteLength", 0);
    return end <= room ? LF_OK : refuse(err, "a part of a buffer that ends after", end, room);
}

static uint64_t element_bytes(const json_t *accessor)
{
    static const struct {
        const char *name;
        unsigned n;
    } shapes[] = {{"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
    const char *type = json_string_value(json_object_get(accessor, "type"));
    uint64_t component = whole(accessor, "componentType", 0), n = 1;
    for (size_t i = 0; type && i < sizeof shapes / sizeof *shapes; i++)
        n = strcmp(type, shapes[i].name) == 0 ? shapes[i].n : n;
    return n * (component == 5126 || component == 5125   ? 4
                : component == 5122 || component == 5123 ? 2
                                                         : 1);
}

static lf_status check_accessor(const json_t *accessor, const json_t *views, lf_error *err)
{
    uint64_t count = whole(accessor, "count", 0), each = element_bytes(accessor);
    if (count > MOST_ELEMENTS)
        return refuse(err, "an accessor of", count * each, MOST_ELEMENTS * each);
    const json_t *view = json_array_get(views, whole(accessor, "bufferView", UINT32_MAX));
    if (!view || count == 0)
        return LF_OK;
    uint64_t stride = whole(view, "byteStride", 0), room = whole(view, "byteLength", 0),
             end = whole(accessor, "byteOffset", 0) + each +
                   (count - 1) * (stride > 0 && stride < 0x1p20 ? stride : each);
    return end <= room ? LF_OK : refuse(err, "an accessor that ends after", end, room);
}

static lf_status check_lengths(const json_t *json, const gltf_file *file, lf_error *err)
{
    const json_t *buffers = json_object_get(json, "buffers"),
                 *views = json_object_get(json, "bufferViews"),
                 *accessors = json_object_get(json, "accessors");
    lf_status status = LF_OK;
    for (size_t i = 0; i < json_array_size(buffers) && status == LF_OK; i++)
        status = check_buffer(json_array_get(buffers, i), i, file, err);
    for (size_t i = 0; i < json_array_size(views) && status == LF_OK; i++)
        status = check_view(json_array_get(views, i), buffers, err);
    for (size_t i = 0; i < json_array_size(accessors) && status == LF_OK; i++)
        status = check_accessor(json_array_get(accessors, i), views, err);
    return status;
}

lf_status lf_gltf_check(int fd, lf_error *err)
{
    struct stat info;
    char first[4] = "";
    json_t *json = NULL;
    if (fstat(fd, &info) != 0)
        return lf_error_set(err, LF_E_IO, LF_HERE, "cannot be read");
    gltf_file file = {.size = (uint64_t)info.st_size};
    (void)!pread(fd, first, sizeof first, 0);
    lf_status status = LF_OK;
    if (memcmp(first, "glTF", sizeof first) == 0) {
        status = find_chunks(fd, &file, err);
    } else {
        file.begin = object_at(fd, file.size);
        file.length = file.size - file.begin;
    }
    if (status == LF_OK && file.length > 0)
        status = load_json(fd, &file, &json, err);
    if (json_is_array(json_object_get(json, "accessors")))
        status = check_lengths(json, &file, err);
    json_decref(json);
    return status;
}
