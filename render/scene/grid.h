/* Building an lf_grid (render/scene/scene.h) from voxels, in two rounds: mark every voxel that is
 * not zero, allocate, set them. Private to render/; also read by C++ (no C11 atomics here). */
#ifndef LF_RENDER_GRID_H
#define LF_RENDER_GRID_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/status.h"

#define LF_GRID_MAX_SIDE (1 << 20)            /* voxels */
#define LF_GRID_MAX_BYTES ((uint64_t)4 << 30) /* of one grid */

typedef struct lf_grid lf_grid;

/* Voxels of the file that no grid holds and that count as 0: how many, and the least of them. */
typedef struct lf_grid_odd {
    double n_negative, least; /* of densities */
    double n_not_finite;
    double background; /* what the file says of all voxels that it does not list; 0: nothing */
    double n_still;    /* velocities that are not finite, of what moves it */
} lf_grid_odd;

/* An empty grid of size voxels (x, y, z), reference count 1. local_to_file: row-major 3x4, from
 * voxel indices of this grid to the file's world. LF_E_NOMEM (limits too), LF_E_FORMAT (size or map
 * out of range). */
LF_NODISCARD lf_status lf_grid_create(const int64_t size[3], const double local_to_file[12],
                                      lf_grid **out_grid, lf_error *err);

/* Announces that the voxels of the box first..last (both included) will be set. */
void lf_grid_mark(lf_grid *grid, const int first[3], const int last[3]);
/* Room for the marked bricks, zeroed. LF_E_NOMEM, err saying how much was wanted. */
LF_NODISCARD lf_status lf_grid_allocate(lf_grid *grid, lf_error *err);
/* Sets the voxels of a marked box. value finite and >= 0. */
void lf_grid_fill(lf_grid *grid, const int first[3], const int last[3], float value);
/* Computes the majorants; no fill after it. */
void lf_grid_finish(lf_grid *grid);

/* In place of marking, allocating, setting and finishing: n bricks as another grid stores them
 * (scene.h), at ascending places of its index. They are copied, and trusted in nothing:
 * LF_E_FORMAT; LF_E_NOMEM. is_signed: of velocities, whose majorants mean nothing. */
LF_NODISCARD lf_status lf_grid_put(lf_grid *grid, size_t n, const uint32_t *places,
                                   const float *values, bool is_signed, lf_error *err);

/* Keeps a finished grid's values in 16 bits from here on. Where all of them are such numbers, as
 * those of files of halves are, no value is changed; others are left alone, or, if it
 * `rounds`, become the nearest such number: within 2^-11 of themselves, 0 below 2^-62 of the
 * largest. Without memory they stay as they are. What single paths find is the same to the bit
 * either way; suffixes in lanes read floats as shares of their brick's largest (lane_scene.h), so
 * that pictures by these differ within what that rounds off. */
void lf_grid_shorten(lf_grid *grid, bool rounds);

/* A new grid that is at each voxel what two others are together; theirs lie in the same places,
 * which need not be as many (LF_E_FORMAT). Neither key nor the names of other grids come along. */
LF_NODISCARD lf_status lf_grid_sum(const lf_grid *a, const lf_grid *b, lf_grid **out_grid,
                                   lf_error *err);

/* Takes a copy of key. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_grid_set_key(lf_grid *grid, const char *key);
/* The same for the names of the file's other grids (scene.h). */
LF_NODISCARD lf_status lf_grid_set_others(lf_grid *grid, const char *others);
void lf_grid_set_odd(lf_grid *grid, const lf_grid_odd *odd);
lf_grid *lf_grid_ref(lf_grid *grid);
/* Accepts NULL. */
void lf_grid_unref(lf_grid *grid);

#ifdef __cplusplus
}
#endif
#endif
