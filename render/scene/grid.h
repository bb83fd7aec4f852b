/* Building an lf_grid (render/scene/scene.h) from voxels in two passes: mark every nonzero voxel,
 * allocate, set the values. Private to render/; also read by C++ (no C11 atomics here). */
#ifndef LF_RENDER_GRID_H
#define LF_RENDER_GRID_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/status.h"

#define LF_GRID_MAX_SIDE (1 << 20)            /* voxels */
#define LF_GRID_MAX_BYTES ((uint64_t)4 << 30) /* per grid */

typedef struct lf_grid lf_grid;

/* Invalid voxels of the file, which count as 0: their number, and the smallest value. */
typedef struct lf_grid_odd {
    double n_negative, least; /* negative densities */
    double n_not_finite;
    double background; /* value of all voxels that the file does not list; 0: none */
    double n_still;    /* number of non-finite velocities of the grid that moves it */
} lf_grid_odd;

/* Makes an empty grid of size voxels (x, y, z), reference count 1. local_to_file: row-major 3x4,
 * from voxel indices of this grid to the file's world. LF_E_NOMEM (also beyond the limits),
 * LF_E_FORMAT (size or map out of range). */
LF_NODISCARD lf_status lf_grid_create(const int64_t size[3], const double local_to_file[12],
                                      lf_grid **out_grid, lf_error *err);

/* Announces that the voxels of the box first..last (both inclusive) will be set. */
void lf_grid_mark(lf_grid *grid, const int first[3], const int last[3]);
/* Allocates the marked bricks, zeroed. LF_E_NOMEM; err contains the size. */
LF_NODISCARD lf_status lf_grid_allocate(lf_grid *grid, lf_error *err);
/* Sets the voxels of a marked box. value must be finite and >= 0. */
void lf_grid_fill(lf_grid *grid, const int first[3], const int last[3], float value);
/* Computes the majorants; no fill after this call. */
void lf_grid_finish(lf_grid *grid);

/* Replaces marking, allocating, setting and finishing: n bricks in the layout of another grid
 * (scene.h), at ascending places of its index. They are copied and fully checked: LF_E_FORMAT;
 * LF_E_NOMEM. is_signed: velocities, whose majorants are meaningless. */
LF_NODISCARD lf_status lf_grid_put(lf_grid *grid, size_t n, const uint32_t *places,
                                   const float *values, bool is_signed, lf_error *err);

/* Makes a grid of dense values[z][y][x], finished; the value of voxel (x, y, z) is at [z][y][x].
 * local_to_file as in lf_grid_create. Bricks without a value above 0 are left out. Polls stopped()
 * (may be NULL) and then fails with LF_E_CANCELLED, err unset. LF_E_FORMAT: the first value that is
 * negative or not finite, by its index; otherwise the errors of lf_grid_create. */
LF_NODISCARD lf_status lf_grid_from_array(const int64_t size[3], const double local_to_file[12],
                                          const float *values, bool (*stopped)(void),
                                          lf_grid **out_grid, lf_error *err);

/* Stores a finished grid's values in 16 bits from now on. Values that are exact in 16 bits, as in
 * files of halves, do not change. If some value is not exact, the grid stays as it is unless
 * `rounds` is true; then each value becomes the nearest 16-bit value. The error is within 2^-11 of
 * the value; values below 2^-62 of the largest become 0. Without memory the grid stays as it is.
 * Single paths give bitwise the same results in both forms. Suffixes in lanes read values as
 * fractions of their brick's maximum (lane_scene.h), so their images differ within that rounding.
 */
void lf_grid_shorten(lf_grid *grid, bool rounds);

/* Makes the sum of two grids, voxel by voxel. Both must have the same map; their sizes may differ
 * (LF_E_FORMAT). The new grid has no key and no names of other grids. */
LF_NODISCARD lf_status lf_grid_sum(const lf_grid *a, const lf_grid *b, lf_grid **out_grid,
                                   lf_error *err);

/* Takes a copy of key. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_grid_set_key(lf_grid *grid, const char *key);
/* Takes a copy of the names of the file's other grids (scene.h). LF_E_NOMEM. */
LF_NODISCARD lf_status lf_grid_set_others(lf_grid *grid, const char *others);
void lf_grid_set_odd(lf_grid *grid, const lf_grid_odd *odd);
lf_grid *lf_grid_ref(lf_grid *grid);
/* Accepts NULL. */
void lf_grid_unref(lf_grid *grid);

#ifdef __cplusplus
}
#endif
#endif
