/* Corrections per tile of single views; private to render/reconstruct.
 * docs/developer/reconstruction-extensions.md, "What tiles lack", has the formulas.
 *
 * Cells of the lattice contain all views together, and features describe little of light that moves
 * with the eye: a light mirrored in a gloss, a caustic. So the shown values are compared with the
 * received radiance, in tiles of each view, from large ones to tiles of LF_RESIDUAL_SIDE pixels.
 * They are multiplied by the ratio as far as the halves agree on it. */
#ifndef LF_RENDER_RECONSTRUCT_RESIDUAL_H
#define LF_RENDER_RECONSTRUCT_RESIDUAL_H

#include "render/reconstruct/moments.h"

/* Side of a finest cell, so that a band of level 0 contains one row of tiles; the largest tiles are
 * eight times as wide. */
#define LF_RESIDUAL_SIDE LF_CELL_SIDE
#define LF_RESIDUAL_LEVELS 4

/* Sums over pixels that both halves have visited. */
typedef struct lf_residual_sums {
    float found[2][3], expected[2][3]; /* per half: N; W R, with R as shown */
    float shown[3], known[3];          /* q R; B */
    float pixels;
} lf_residual_sums;

/* What only a fit needs of a tile. */
typedef union lf_residual_fitted {
    lf_residual_sums sums;
    /* of the finest tiles, after settling: the required mean of `lacks` */
    float wanted[LF_VARIANTS][3];
} lf_residual_fitted;

typedef struct lf_residual_tile {
    /* Of the finest tiles, the total factor of R, for each half and for both; of larger ones, the
     * change of this factor. Minus 1. */
    float lacks[LF_VARIANTS][3];
    float agreed, total, share;
} lf_residual_tile;

typedef struct lf_residual {
    int across[LF_RESIDUAL_LEVELS], down[LF_RESIDUAL_LEVELS];
    lf_residual_tile *tiles[LF_RESIDUAL_LEVELS];    /* [view][down][across]; > 0: during a fit */
    lf_residual_fitted *fitted[LF_RESIDUAL_LEVELS]; /* of these tiles, during a fit */
    double *chosen; /* [view]: gain of the shares by chance, in relMSE of a pixel and channel */
} lf_residual;

/* All tiles are unknown. NULL: no memory. */
lf_residual *lf_residual_create(const lf_reconstruct_view *view);
/* Accepts NULL. */
void lf_residual_destroy(lf_residual *residual);
/* Memory that only a fit needs: before its steps, and after them also if one has failed.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_residual_begin(lf_residual *residual, int n_views);
void lf_residual_end(lf_residual *residual);

/* 1. The received and shown sums in the tiles of a band of level 0. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_residual_sum(lf_reconstruction *r, const lf_film *film, int number);
/* 2. From the largest tiles to the finest, for each view: lf_residual_weigh computes the ratios;
 * when all views are done, lf_residual_share computes how much of them is applied, and
 * lf_residual_take applies it. */
void lf_residual_weigh(lf_reconstruction *r, int level, int view);
void lf_residual_share(lf_reconstruction *r, int level, int view);
void lf_residual_take(lf_reconstruction *r, int level, int view);

/* The factors of R for columns [0, width) of one view and row, for `variant`; false, with out
 * untouched: no factor. */
bool lf_residual_row(const lf_reconstruction *r, int row, int view, int variant, float (*out)[3]);

/* Sum of `chosen` over all views. */
double lf_residual_chosen(const lf_reconstruction *r);

#endif
