/* Accessors of glTF (specification, section 3.6.2): elements as they lie in a buffer, of any type,
 * normalised or not, with others put in place of some. Nothing is copied. One thread. */
#ifndef LF_RENDER_GLTF_ACCESSOR_H
#define LF_RENDER_GLTF_ACCESSOR_H

#include "render/import/reader/gltf_file.h"

/* Numbers that glTF has from GL. */
typedef enum lf_gltf_type {
    LF_GLTF_INT8 = 5120,
    LF_GLTF_UINT8 = 5121,
    LF_GLTF_INT16 = 5122,
    LF_GLTF_UINT16 = 5123,
    LF_GLTF_UINT32 = 5125,
    LF_GLTF_FLOAT = 5126
} lf_gltf_type;

/* Valid as long as the file. */
typedef struct lf_gltf_accessor {
    size_t count; /* 0: there is none */
    unsigned components;
    lf_gltf_type type;
    bool normalised;
    size_t stride;
    const unsigned char *data; /* NULL: all zeros */
    size_t n_sparse;
    lf_gltf_type sparse_type;
    const unsigned char *sparse_places, *sparse_values; /* places ascend */
} lf_gltf_accessor;

/* LF_E_FORMAT: there is no such accessor, or a part of it lies outside of its buffer; LF_E_NOMEM.
 */
LF_NODISCARD lf_status lf_gltf_accessor_open(lf_gltf *gltf, uint64_t number, lf_gltf_accessor *out,
                                             lf_error *err);
/* Whether its elements lie in the file, or are so few that it does not matter: what a mesh is made
 * of must, so that no small file makes a large mesh of nothing. */
bool lf_gltf_is_there(const lf_gltf_accessor *accessor);

/* The components of an element that is there; those beyond n are left out, those that it has not
 * stay as they are. */
void lf_gltf_floats(const lf_gltf_accessor *accessor, size_t element, unsigned n, float *out);
/* The first component of an element of whole numbers. */
uint32_t lf_gltf_integer(const lf_gltf_accessor *accessor, size_t element);

#endif
