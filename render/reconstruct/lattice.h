/* The lattices of a reconstruction: cells of the world (place along the epipolar line, row, depth)
 * with sums over the pixels of all views that lie in them; private to render/reconstruct.
 *
 * Level 0 has cells of LF_CELL_SIDE pixels; every level above has cells twice as wide, high and
 * deep. Cells exist where pixels do. Coordinates are in units of a finest cell, whose depth is
 * LF_CELL_DEPTH pixels at the plane Z = D. */
#ifndef LF_RENDER_RECONSTRUCT_LATTICE_H
#define LF_RENDER_RECONSTRUCT_LATTICE_H

#include "render/reconstruct/reconstruct.h"

#define LF_CELL_SIDE 4
#define LF_CELL_DEPTH 16
#define LF_LEVELS 4

/* Features beside the constant. The first three are coordinates, from the middle of a cell or node.
 */
enum { LF_PLACE, LF_ROW, LF_DEPTH, LF_MEDIA, LF_PIVOTS, LF_VIEW, LF_SPREAD, LF_LIGHT, LF_FEATURES };

/* Sums over pixels with weights W and radiance N of one half, on features f of the same or the
 * other half. */
typedef struct lf_moments {
    float w, n[3];
    float wf[LF_FEATURES];
    float wff[LF_FEATURES][LF_FEATURES];
    float nf[3][LF_FEATURES];
} lf_moments;

/* A linear function of features. */
typedef struct lf_plane {
    float constant, slope[LF_FEATURES];
} lf_plane;

enum { LF_HALF_A, LF_HALF_B, LF_BOTH, LF_VARIANTS };

/* What the raw answer N/W, as the level below the finest, needs beyond moments. */
typedef struct lf_raw_sums {
    float cross[2][3];      /* [h] of N_h/W_h N_g, g the other half */
    lf_plane product[2][3]; /* [h] of N_h/W_h W_g f, f of half h */
    float square[3];        /* of N^2/W, both halves pooled */
    float known[3], q, pixels;
} lf_raw_sums;

typedef struct lf_cell {
    int u, z;              /* in units of this level's cells */
    lf_moments half[2][2]; /* [features of][weights of] */
    lf_raw_sums raw;
    /* of the fit; then of the blend with all coarser levels */
    lf_plane node[LF_VARIANTS][3];
    float agreed, total; /* of the shrinkage towards this level (shrink.c) */
    float share;         /* of this level, as it is settled */
    float chosen;        /* what shares have gained by chance here (shown_error.c) */
} lf_cell;

/* The cells of one row of a lattice. */
typedef struct lf_band {
    int u0, nu, z0, nz; /* [z0, z0 + nz) x [u0, u0 + nu) holds them; nu = 0: there are none */
    int *index;         /* [nz][nu] number of a cell, -1: none */
    size_t index_size;  /* allocated */
    lf_cell *cells;
    int n, size; /* cells; allocated */
} lf_band;

typedef struct lf_lattice {
    int n_bands;
    lf_band *bands;
} lf_lattice;

struct lf_reconstruction {
    lf_reconstruct_view view;
    float *shift;
    lf_pool *pool;
    lf_lattice level[LF_LEVELS];
    const struct lf_reconstruct_kernels *kernels;
    pthread_mutex_t lock;
    struct lf_reconstruct_scratch *scratch; /* under the lock: what nobody uses */
    bool ready;
};

/* Whether a row's pixels of this view are summed up: with many views every third, another one in
 * each row. Neighbouring views share their paths, so that the others know next to nothing more. */
static inline bool lf_view_is_fitted(const lf_reconstruction *r, int row, int view)
{
    int step = r->view.n_views / 15 < 3 ? r->view.n_views / 15 : 3;
    return step < 2 || (row + view) % step == 0;
}

/* The number of the cell at (u, z), -1: there is none. */
static inline int lf_band_find(const lf_band *band, int u, int z)
{
    int i = u - band->u0, j = z - band->z0;
    if (i < 0 || i >= band->nu || j < 0 || j >= band->nz)
        return -1;
    return band->index[(size_t)j * (size_t)band->nu + (size_t)i];
}

/* An empty band over these ranges, and room for n cells, all zero. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_band_begin(lf_band *band, int u0, int nu, int z0, int nz);
LF_NODISCARD lf_status lf_band_reserve(lf_band *band);
void lf_band_finish(lf_band *band);
/* Marks a place, to be counted by lf_band_reserve. */
static inline void lf_band_mark(lf_band *band, int u, int z)
{
    band->index[(size_t)(z - band->z0) * (size_t)band->nu + (size_t)(u - band->u0)] = 0;
}

/* Adds the sums of `from` as seen from a place `shift` away: f + shift for the first three
 * features.
 */
void lf_raw_add(lf_raw_sums *to, const lf_raw_sums *from, const float shift[3]);

#endif
