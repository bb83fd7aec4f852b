/* Accessors of glTF (specification, section 3.6.2): elements of any type in a buffer, normalised or
 * not, with sparse replacements. Nothing is copied. One thread. */
#ifndef LF_RENDER_GLTF_ACCESSOR_H
#define LF_RENDER_GLTF_ACCESSOR_H

#include "render/import/reader/gltf_file.h"

/* GL constants used by glTF. */
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
    size_t count; /* 0: no accessor */
    unsigned components;
    lf_gltf_type type;
    bool normalised;
    size_t stride;
    const unsigned char *data; /* NULL: all zeros */
    size_t n_sparse;
    lf_gltf_type sparse_type;
    const unsigned char *sparse_places, *sparse_values; /* places are ascending */
} lf_gltf_accessor;

/* LF_E_FORMAT: no such accessor, or a part of it lies outside of its buffer; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gltf_accessor_open(lf_gltf *gltf, uint64_t number, lf_gltf_accessor *out,
                                             lf_error *err);
/* Whether its elements are stored in the file, or are negligibly few. Required for mesh data, so
 * that a small file cannot declare a large empty mesh. */
bool lf_gltf_is_there(const lf_gltf_accessor *accessor);

/* The components of an element that is stored. Components beyond n are dropped; missing ones leave
 * out unchanged. */
void lf_gltf_floats(const lf_gltf_accessor *accessor, size_t element, unsigned n, float *out);
/* The first component of an element of integers. */
uint32_t lf_gltf_integer(const lf_gltf_accessor *accessor, size_t element);

#endif
