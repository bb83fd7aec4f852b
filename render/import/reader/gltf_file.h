/* A glTF 2.0 file as bytes and JSON (specification, sections 3.6 and 4.4), and the bytes of its
 * buffers, which are read on demand: from the file, from base64 in it, or from files next to it.
 * Every length is checked against the data before memory is allocated for it. One thread. */
#ifndef LF_RENDER_GLTF_FILE_H
#define LF_RENDER_GLTF_FILE_H

#include "base/status.h"
#include "render/import/reader/gltf_json.h"

typedef struct lf_gltf_bytes {
    unsigned char *data;
    size_t size;
} lf_gltf_bytes;

typedef struct lf_gltf {
    int fd;           /* owned by the caller */
    const char *path; /* borrowed: names are relative to it */
    json_t *json;     /* an object */
    /* position of the JSON in the file, and of a GLB's own buffer */
    uint64_t size, begin, length, binary_at, binary;
    bool has_binary;
    size_t n_buffers, n_views;
    lf_gltf_bytes *buffers; /* [n_buffers]; data NULL: not read yet */
    lf_gltf_bytes *views;   /* [n_views]: decompressed data of compressed ones */
} lf_gltf;

/* A part of a buffer, valid as long as the file. */
typedef struct lf_gltf_view {
    const unsigned char *data;
    size_t size, stride; /* stride 0: tightly packed */
} lf_gltf_view;

/* LF_E_FORMAT: not glTF 2.0, lengths beyond the data, or an unsupported required extension;
 * LF_E_NOMEM, LF_E_IO. Release with lf_gltf_close, also after a failure. */
LF_NODISCARD lf_status lf_gltf_open(lf_gltf *gltf, int fd, const char *path, lf_error *err);
/* Accepts a zeroed struct. */
void lf_gltf_close(lf_gltf *gltf);

/* Whether an extension of this name is supported, or reported where it is used. */
bool lf_gltf_knows(const char *extension);

/* The data of a buffer view, decompressed if it uses EXT_meshopt_compression. */
LF_NODISCARD lf_status lf_gltf_view_open(lf_gltf *gltf, uint64_t number, lf_gltf_view *out,
                                         lf_error *err);
/* The data of a uri: base64 in it, or a file. The caller releases out->data with free. least > 0:
 * the file must have this many bytes, and only these are read. 0: the whole of an optional file
 * (lf_try_for_file). LF_E_PATH: not accessible; LF_E_FORMAT, LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_gltf_fetch(const lf_gltf *gltf, const char *uri, uint64_t least,
                                     lf_gltf_bytes *out, lf_error *err);

/* gltf_meshopt.c: decodes a view by its EXT_meshopt_compression object. */
LF_NODISCARD lf_status lf_gltf_decompress(const json_t *extension, const unsigned char *data,
                                          size_t size, uint64_t view, lf_gltf_bytes *out,
                                          lf_error *err);
/* gltf_buffer.c: n bytes of a buffer. */
LF_NODISCARD lf_status lf_gltf_buffer_bytes(lf_gltf *gltf, uint64_t number, uint64_t offset,
                                            uint64_t n, const unsigned char **out, lf_error *err);

#endif
