/* array: the type and shape of an array that a client passes in memory (base/passed.h). */
#ifndef LF_BASE_ARRAY_H
#define LF_BASE_ARRAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum lf_array_type { LF_ARRAY_FLOAT32, LF_ARRAY_UINT32, LF_ARRAY_UINT8 } lf_array_type;

#define LF_ARRAY_AXES 3

/* Values in C order and native byte order, without gaps. */
typedef struct lf_array {
    lf_array_type type;
    int n_axes;                    /* 1 to LF_ARRAY_AXES */
    int64_t length[LF_ARRAY_AXES]; /* values along each axis, the slowest first */
} lf_array;

/* The name of a type, "float32"; NULL after the last. */
const char *lf_array_type_name(int index);
/* Bytes of all values; 0: a length is below 1, or they are more than a file can have. */
uint64_t lf_array_bytes(const lf_array *array);
/* Whether an array has the type and shape of `wanted`, in which a length of 0 stands for any. */
bool lf_array_is(const lf_array *array, const lf_array *wanted);
/* "float32 values of shape [8, 3]", with letters for lengths of 0; returns out. */
#define LF_ARRAY_TEXT 96
char *lf_array_text(const lf_array *array, char out[LF_ARRAY_TEXT]);

#endif
