/* What the picture lacks in tiles of single views; private to render/reconstruct.
 * docs/developer/reconstruction-extensions.md, "What tiles lack", has the formulas.
 *
 * Cells of the lattice hold all views together, and features say little of what moves with the eye:
 * a lamp mirrored in a gloss, a caustic. So what is shown is compared with what was found, in tiles
 * of each view, from large ones to such of LF_RESIDUAL_SIDE pixels, and multiplied by what they
 * lack as far as the halves agree on it. */
#ifndef LF_RENDER_RECONSTRUCT_RESIDUAL_H
#define LF_RENDER_RECONSTRUCT_RESIDUAL_H

#include "render/reconstruct/moments.h"

/* That of a finest cell, so that a band of level 0 holds one row of tiles; the largest are eight
 * times as wide. */
#define LF_RESIDUAL_SIDE LF_CELL_SIDE
#define LF_RESIDUAL_LEVELS 4

/* Sums over pixels that both halves have seen. */
typedef struct lf_residual_sums {
    float found[2][3], expected[2][3]; /* of halves: N; W R, R as it is shown */
    float shown[3], known[3];          /* q R; B */
    float pixels;
} lf_residual_sums;

typedef struct lf_residual_tile {
    union {
        lf_residual_sums sums;
        /* of the finest, when all is settled: what `lacks` is to be in its mean */
        float wanted[LF_VARIANTS][3];
    };
    /* Of the finest, by what R is multiplied in all, of halves and of both; of larger ones, by how
     * much that changes. Less 1. */
    float lacks[LF_VARIANTS][3];
    float agreed, total, share;
} lf_residual_tile;

typedef struct lf_residual {
    int across[LF_RESIDUAL_LEVELS], down[LF_RESIDUAL_LEVELS];
    lf_residual_tile *tiles[LF_RESIDUAL_LEVELS]; /* [view][down][across] */
    double
        *chosen; /* [view]: what shares have gained by chance, in relMSE of a pixel and channel */
} lf_residual;

/* Nothing is known of its tiles. NULL: no memory. */
lf_residual *lf_residual_create(const lf_reconstruct_view *view);
/* Accepts NULL. */
void lf_residual_destroy(lf_residual *residual);

/* 1. What was found and what is shown in the tiles of a band of level 0. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_residual_sum(lf_reconstruction *r, const lf_film *film, int number);
/* 2. From the largest tiles to the finest, for each view: what they lack; when that is known of all
 * views, how much of it is taken; and then it is. */
void lf_residual_weigh(lf_reconstruction *r, int level, int view);
void lf_residual_share(lf_reconstruction *r, int level, int view);
void lf_residual_take(lf_reconstruction *r, int level, int view);

/* What R of columns [0, width) of one view and row is multiplied by, as `variant` says; false, and
 * out untouched: by nothing. */
bool lf_residual_row(const lf_reconstruction *r, int row, int view, int variant, float (*out)[3]);

/* Sum of `chosen` of all views. */
double lf_residual_chosen(const lf_reconstruction *r);

#endif
