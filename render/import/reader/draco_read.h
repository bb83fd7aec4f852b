/* KHR_draco_mesh_compression; private to render/import/reader. The C interface of its one C++ file:
 * no exception and no library type crosses it. */
#ifndef LF_RENDER_DRACO_READ_H
#define LF_RENDER_DRACO_READ_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/status.h"

/* An attribute by its number in the compressed data, and its decoded data. */
typedef struct lf_draco_attribute {
    uint32_t id;
    unsigned components;
    unsigned type;       /* of a component: the GL constant, as in glTF */
    unsigned bytes;      /* of an element */
    unsigned char *data; /* [n_points], free */
} lf_draco_attribute;

typedef struct lf_draco_mesh {
    size_t n_points, n_triangles;
    uint32_t *triangles; /* [n_triangles][3], below n_points; free */
} lf_draco_mesh;

/* Decodes a mesh and n of its attributes. LF_E_FORMAT: not a Draco mesh, no such attribute, or more
 * than `most` points or triangles; LF_E_NOMEM. The caller owns pointers that are not NULL, also
 * after a failure. */
LF_NODISCARD lf_status lf_draco_read(const unsigned char *data, size_t size, size_t most,
                                     lf_draco_attribute *attributes, size_t n, lf_draco_mesh *out,
                                     lf_error *err);

#ifdef __cplusplus
}
#endif
#endif
