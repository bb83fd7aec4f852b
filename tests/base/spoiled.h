/* Files of every kind that is read from outside, whole, small and made here, and how they are
 * spoiled: cut off, or with random bytes changed. All fail the running test when anything goes
 * wrong. */
#ifndef LF_TESTS_SPOILED_H
#define LF_TESTS_SPOILED_H

#include "tests/testing.h"

typedef struct lf_bytes {
    unsigned char *data; /* released with free */
    size_t n;
} lf_bytes;

/* How it is come by. */
typedef enum lf_spoiled_use {
    LF_SPOILED_MESH,
    LF_SPOILED_GRID, /* of the name "density" */
    LF_SPOILED_SKY,
    LF_SPOILED_QUILT,
    LF_SPOILED_PROFILE,     /* ICC */
    LF_SPOILED_CALIBRATION, /* of a panel of 96 x 128 pixels */
} lf_spoiled_use;

typedef struct lf_spoiled_kind {
    const char *name; /* of the file that is opened */
    const char *file; /* that is spoiled: the same, or one that it names */
    lf_spoiled_use use;
    lf_bytes (*make)(void); /* the file that is spoiled, whole */
} lf_spoiled_kind;

/* A row without a name is the last. b.obj is made as a.obj is, and names a.mtl. */
extern const lf_spoiled_kind lf_spoiled_kinds[];

lf_bytes lf_bytes_read(const char *path);
void lf_bytes_write(const char *path, const void *data, size_t n);
/* The i-th spoiled version into path: the first n_cuts are cut off, evenly; others have 1 to 8
 * bytes changed, by lf_test_seed(). */
void lf_spoil(const lf_bytes *whole, int i, int n_cuts, const char *path);

#endif
