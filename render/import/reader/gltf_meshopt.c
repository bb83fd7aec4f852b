/* EXT_meshopt_compression, by the library that it was made for. */
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_file.h"

/* A block of 256 vertices takes at least four bytes for each byte of a vertex. */
#define BEST_RATIO 64
#define LEAST_ROOM 4096

typedef struct packed {
    const char *mode, *filter;
    size_t count, stride;
} packed;

static bool is_one_of(const char *text, const char *a, const char *b)
{
    return strcmp(text, a) == 0 || strcmp(text, b) == 0;
}

/* Preconditions of the library. */
static bool fits(const packed *p)
{
    bool vertices = strcmp(p->mode, "ATTRIBUTES") == 0,
         triangles = strcmp(p->mode, "TRIANGLES") == 0, plain = is_one_of(p->filter, "", "NONE"),
         octahedral = strcmp(p->filter, "OCTAHEDRAL") == 0 && (p->stride == 4 || p->stride == 8),
         quaternion = strcmp(p->filter, "QUATERNION") == 0 && p->stride == 8,
         exponential = strcmp(p->filter, "EXPONENTIAL") == 0;
    if (vertices)
        return p->stride >= 4 && p->stride <= 256 && p->stride % 4 == 0 &&
               (plain || octahedral || quaternion || exponential);
    return (triangles || strcmp(p->mode, "INDICES") == 0) && plain &&
           (p->stride == 2 || p->stride == 4) && (!triangles || p->count % 3 == 0);
}

static bool decode(const packed *p, const unsigned char *data, size_t size, unsigned char *out)
{
    if (strcmp(p->mode, "TRIANGLES") == 0)
        return meshopt_decodeIndexBuffer(out, p->count, p->stride, data, size) == 0;
    if (strcmp(p->mode, "INDICES") == 0)
        return meshopt_decodeIndexSequence(out, p->count, p->stride, data, size) == 0;
    if (meshopt_decodeVertexBuffer(out, p->count, p->stride, data, size) != 0)
        return false;
    if (strcmp(p->filter, "OCTAHEDRAL") == 0)
        meshopt_decodeFilterOct(out, p->count, p->stride);
    else if (strcmp(p->filter, "QUATERNION") == 0)
        meshopt_decodeFilterQuat(out, p->count, p->stride);
    else if (strcmp(p->filter, "EXPONENTIAL") == 0)
        meshopt_decodeFilterExp(out, p->count, p->stride);
    return true;
}

lf_status lf_gltf_decompress(const json_t *extension, const unsigned char *data, size_t size,
                             uint64_t view, lf_gltf_bytes *out, lf_error *err)
{
    packed p = {.mode = lf_gltf_text(extension, "mode"),
                .filter = lf_gltf_text(extension, "filter"),
                .count = (size_t)lf_gltf_whole(extension, "count", 0),
                .stride = (size_t)lf_gltf_whole(extension, "byteStride", 0)};
    if (!fits(&p) || p.count == 0 || p.count > (BEST_RATIO * size + LEAST_ROOM) / p.stride)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "bufferViews[%llu]: invalid EXT_meshopt_compression, or too many "
                            "elements for %zu bytes",
                            (unsigned long long)view, size);
    unsigned char *bytes = malloc(p.count * p.stride);
    if (!bytes)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (!decode(&p, data, size, bytes)) {
        free(bytes);
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "bufferViews[%llu]: its EXT_meshopt_compression cannot be decoded",
                            (unsigned long long)view);
    }
    *out = (lf_gltf_bytes){bytes, p.count * p.stride};
    return LF_OK;
}
