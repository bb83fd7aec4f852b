/* A glTF 2.0 file as bytes and JSON (specification, sections 3.6 and 4.4), and the bytes of its
 * buffers, read when they are asked for: its own, in it as base64, or in files beside it. Every
 * length is held against what is there before room is made for it. One thread. */
#ifndef LF_RENDER_GLTF_FILE_H
#define LF_RENDER_GLTF_FILE_H

#include "base/status.h"
#include "render/import/reader/gltf_json.h"

typedef struct lf_gltf_bytes {
    unsigned char *data;
    size_t size;
} lf_gltf_bytes;

typedef struct lf_gltf {
    int fd;           /* the caller's */
    const char *path; /* borrowed: what names are relative to */
    json_t *json;     /* an object */
    /* where JSON lies in the file, and a GLB's own buffer */
    uint64_t size, begin, length, binary_at, binary;
    bool has_binary;
    size_t n_buffers, n_views;
    lf_gltf_bytes *buffers; /* [n_buffers]; data NULL: not read yet */
    lf_gltf_bytes *views;   /* [n_views]: of those that are compressed, what was in them */
} lf_gltf;

/* A part of a buffer, which goes with the file. */
typedef struct lf_gltf_view {
    const unsigned char *data;
    size_t size, stride; /* stride 0: elements follow each other */
} lf_gltf_view;

/* LF_E_FORMAT: it is no glTF 2.0, says lengths that are not there, or requires an extension that
 * is not known here; LF_E_NOMEM, LF_E_IO. Release with lf_gltf_close in any case. */
LF_NODISCARD lf_status lf_gltf_open(lf_gltf *gltf, int fd, const char *path, lf_error *err);
/* Accepts a zeroed one. */
void lf_gltf_close(lf_gltf *gltf);

/* Whether an extension of this name is read, or told of where it is used. */
bool lf_gltf_knows(const char *extension);

/* What a buffer view holds, decompressed where it is EXT_meshopt_compression. */
LF_NODISCARD lf_status lf_gltf_view_open(lf_gltf *gltf, uint64_t number, lf_gltf_view *out,
                                         lf_error *err);
/* What is behind a uri: base64 in it, or a file by its name. The caller releases out->data with
 * free. least: so many bytes must be there, and only they are read; 0: all, of a file that can be
 * done without (lf_try_for_file). LF_E_PATH: it is not to be had; LF_E_FORMAT, LF_E_NOMEM, LF_E_IO.
 */
LF_NODISCARD lf_status lf_gltf_fetch(const lf_gltf *gltf, const char *uri, uint64_t least,
                                     lf_gltf_bytes *out, lf_error *err);

/* gltf_meshopt.c: what EXT_meshopt_compression says of a view. */
LF_NODISCARD lf_status lf_gltf_decompress(const json_t *extension, const unsigned char *data,
                                          size_t size, uint64_t view, lf_gltf_bytes *out,
                                          lf_error *err);
/* gltf_buffer.c: n bytes of a buffer. */
LF_NODISCARD lf_status lf_gltf_buffer_bytes(lf_gltf *gltf, uint64_t number, uint64_t offset,
                                            uint64_t n, const unsigned char **out, lf_error *err);

#endif
