/* Buffers of glTF: a GLB's own, base64, files next to it. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_file.h"

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

static lf_status too_short(const char *what, uint64_t has, uint64_t room, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "cannot be read as a mesh: %s needs %llu bytes but has %llu", what,
                        (unsigned long long)has, (unsigned long long)room);
}

static lf_status read_part(int fd, uint64_t at, uint64_t n, lf_gltf_bytes *out, lf_error *err)
{
    unsigned char *data = malloc((size_t)n + 1);
    size_t got = 0;
    if (!data)
        return no_memory(err);
    while (got < n) {
        ssize_t part = pread(fd, data + got, (size_t)n - got, (off_t)(at + got));
        if (part <= 0) {
            free(data);
            return lf_error_set(err, LF_E_IO, LF_HERE, "a buffer cannot be read");
        }
        got += (size_t)part;
    }
    *out = (lf_gltf_bytes){data, (size_t)n};
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- uris -- */

/* -1: no such digit. */
static int digit_of(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

static lf_status decode_base64(const char *text, lf_gltf_bytes *out, lf_error *err)
{
    size_t length = strlen(text), n = 0;
    uint32_t bits = 0;
    int n_bits = 0;
    unsigned char *data = malloc(length / 4 * 3 + 4);
    if (!data)
        return no_memory(err);
    for (const char *at = text; *at && *at != '='; at++) {
        int digit = digit_of(*at);
        if (digit < 0) {
            free(data);
            return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                                "byte %zu of a data URI is not a base64 digit",
                                (size_t)(at - text));
        }
        bits = bits << 6 | (uint32_t)digit;
        n_bits += 6;
        if (n_bits >= 8) {
            n_bits -= 8;
            data[n++] = (unsigned char)(bits >> n_bits & 0xff);
        }
    }
    *out = (lf_gltf_bytes){data, n};
    return LF_OK;
}

static int hexadecimal(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* Decodes %20 and similar in a uri, in place. */
static void decode_percent(char *name)
{
    char *to = name;
    for (const char *from = name; *from; to++) {
        int high = from[0] == '%' ? hexadecimal(from[1]) : -1,
            low = high >= 0 ? hexadecimal(from[2]) : -1;
        bool escaped = low >= 0 && (high || low);
        *to = escaped ? (char)(unsigned char)(16 * high + low) : *from;
        from += escaped ? 3 : 1;
    }
    *to = '\0';
}

/* Opens the decoded file name; if it does not exist, the name as it is. */
static lf_status open_file(const lf_gltf *gltf, const char *uri, bool needed, int *out_fd,
                           lf_error *err)
{
    char *folder = lf_path_folder(gltf->path), *name = lf_strdup(uri), *path = NULL;
    lf_status status = LF_E_NOMEM;
    if (folder && name) {
        decode_percent(name);
        path = lf_path_join(folder, name);
    }
    if (path)
        status = needed ? lf_ask_for_file(path, out_fd) : lf_try_for_file(path, out_fd);
    if (status != LF_OK)
        status =
            lf_error_set(err, status == LF_E_NOMEM ? LF_E_NOMEM : LF_E_PATH, LF_HERE,
                         status == LF_E_NOMEM ? "out of memory"
                                              : "the file \"%.200s\" is missing or may not be read",
                         uri);
    lf_free(folder);
    lf_free(name);
    lf_free(path);
    return status;
}

static lf_status fetch_file(const lf_gltf *gltf, const char *uri, uint64_t least,
                            lf_gltf_bytes *out, lf_error *err)
{
    struct stat info;
    int fd;
    lf_status status = open_file(gltf, uri, least > 0, &fd, err);
    if (status != LF_OK)
        return status;
    uint64_t size = fstat(fd, &info) == 0 ? (uint64_t)info.st_size : 0;
    status = size < least ? too_short("a buffer", least, size, err)
                          : read_part(fd, 0, least > 0 ? least : size, out, err);
    close(fd);
    return status;
}

lf_status lf_gltf_fetch(const lf_gltf *gltf, const char *uri, uint64_t least, lf_gltf_bytes *out,
                        lf_error *err)
{
    static const char written[] = ";base64,";
    if (strncmp(uri, "data:", 5) != 0)
        return fetch_file(gltf, uri, least, out, err);
    const char *text = strstr(uri, written);
    lf_gltf_bytes bytes;
    if (!text)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "a data URI is not in base64");
    lf_status status = decode_base64(text + strlen(written), &bytes, err);
    if (status == LF_OK && bytes.size < least) {
        free(bytes.data);
        status = too_short("a buffer", least, bytes.size, err);
    }
    if (status == LF_OK)
        *out = bytes;
    return status;
}

/* ----------------------------------------------------------------------------------- buffers -- */

static lf_status load_buffer(lf_gltf *gltf, size_t number, lf_error *err)
{
    const json_t *buffer = lf_gltf_element(gltf->json, "buffers", number);
    lf_gltf_bytes *out = &gltf->buffers[number];
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    uint64_t length = lf_gltf_whole(buffer, "byteLength", 0);
    if (length == 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "buffers[%zu] has no byteLength", number);
    if (uri) {
        lf_status status = lf_gltf_fetch(gltf, uri, length, out, err);
        return status == LF_E_PATH ? LF_E_FORMAT : status;
    }
    if (number > 0 || !gltf->has_binary)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "buffers[%zu] has no uri, and the file has no binary chunk for it",
                            number);
    return length > gltf->binary ? too_short("a buffer", length, gltf->binary, err)
                                 : read_part(gltf->fd, gltf->binary_at, length, out, err);
}

lf_status lf_gltf_buffer_bytes(lf_gltf *gltf, uint64_t number, uint64_t offset, uint64_t n,
                               const unsigned char **out, lf_error *err)
{
    lf_status status = LF_OK;
    if (number >= gltf->n_buffers)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "buffers[%llu] does not exist; the file has %zu",
                            (unsigned long long)number, gltf->n_buffers);
    lf_gltf_bytes *buffer = &gltf->buffers[number];
    if (!buffer->data)
        status = load_buffer(gltf, (size_t)number, err);
    if (status != LF_OK)
        return status;
    if (offset > buffer->size || n > buffer->size - offset)
        return too_short("the buffer of a buffer view", offset + n, buffer->size, err);
    *out = buffer->data + offset;
    return LF_OK;
}

static lf_status open_compressed(lf_gltf *gltf, const json_t *extension, size_t number,
                                 lf_error *err)
{
    const unsigned char *data;
    uint64_t size = lf_gltf_whole(extension, "byteLength", 0);
    lf_status status =
        lf_gltf_buffer_bytes(gltf, lf_gltf_whole(extension, "buffer", LF_GLTF_NONE),
                             lf_gltf_whole(extension, "byteOffset", 0), size, &data, err);
    return status == LF_OK ? lf_gltf_decompress(extension, data, (size_t)size, number,
                                                &gltf->views[number], err)
                           : status;
}

lf_status lf_gltf_view_open(lf_gltf *gltf, uint64_t number, lf_gltf_view *out, lf_error *err)
{
    const json_t *view = lf_gltf_element(gltf->json, "bufferViews", number),
                 *compressed = lf_gltf_extension(view, "EXT_meshopt_compression");
    lf_gltf_view found = {.stride = (size_t)lf_gltf_whole(view, "byteStride", 0)};
    lf_status status = LF_OK;
    if (!view)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "bufferViews[%llu] does not exist; the file has %zu",
                            (unsigned long long)number, gltf->n_views);
    if (found.stride > 65536)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "bufferViews[%llu] has a byteStride of %zu; expected at most 65536",
                            (unsigned long long)number, found.stride);
    if (compressed) {
        if (!gltf->views[number].data)
            status = open_compressed(gltf, compressed, (size_t)number, err);
        found.data = gltf->views[number].data;
        found.size = gltf->views[number].size;
        found.stride = (size_t)lf_gltf_whole(compressed, "byteStride", 0);
    } else {
        found.size = (size_t)lf_gltf_whole(view, "byteLength", 0);
        status = lf_gltf_buffer_bytes(gltf, lf_gltf_whole(view, "buffer", LF_GLTF_NONE),
                                      lf_gltf_whole(view, "byteOffset", 0), found.size, &found.data,
                                      err);
    }
    if (status == LF_OK)
        *out = found;
    return status;
}
