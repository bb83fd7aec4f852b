/* The lattices of a reconstruction: cells of the world (place along the epipolar line, row, depth)
 * with sums over the pixels of all views that lie in them; private to render/reconstruct.
 *
 * Level 0 has cells of LF_CELL_SIDE pixels; every level above has cells twice as wide, high and
 * deep. Cells exist where pixels do. Coordinates are in units of a finest cell, whose depth is
 * LF_CELL_DEPTH pixels at the plane Z = D (or more: LF_MAX_DEPTHS). */
#ifndef LF_RENDER_RECONSTRUCT_LATTICE_H
#define LF_RENDER_RECONSTRUCT_LATTICE_H

#include <stddef.h>

#include "render/reconstruct/reconstruct.h"

#define LF_CELL_SIDE 4
#define LF_CELL_DEPTH 16
/* Deeper cells where there would be more of them behind each other. */
#define LF_MAX_DEPTHS 4096
#define LF_LEVELS 4

/* Features beside the constant. The first three are coordinates, from the middle of a cell or node.
 */
enum { LF_PLACE, LF_ROW, LF_DEPTH, LF_MEDIA, LF_PIVOTS, LF_VIEW, LF_SPREAD, LF_LIGHT, LF_FEATURES };

/* A number a feature: one vector or two, as the machine has them. */
typedef float lf_by_feature __attribute__((vector_size(4 * LF_FEATURES)));

/* Sums over pixels with weights W and radiance N of one half, on features f of the same or the
 * other half. */
typedef struct lf_moments {
    float w, n[3];
    float wf[LF_FEATURES];
    float wff[LF_FEATURES][LF_FEATURES]; /* of sums that were moved the upper triangle (kernel.h) */
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
    float weight[2];        /* [h] of W_g where N_h/W_h is an answer */
    float square[3];        /* of N^2/W, both halves pooled */
    float known[3], albedo[3], q, pixels;
} lf_raw_sums;

typedef struct lf_cell {
    int u, z;              /* in units of this level's cells */
    lf_moments half[2][2]; /* [features of][weights of] */
    lf_raw_sums raw;
    /* of the fit; then of the blend with all coarser levels */
    lf_plane node[LF_VARIANTS][3];
    float agreed, total;      /* of the shrinkage towards this level (shrink.c) */
    float share;              /* of this level, as it is settled */
    bool filled[LF_VARIANTS]; /* the node knows something */
    float own[LF_VARIANTS];   /* share of its own fit that its pivots W allow: W/(W + few) */
    /* what shares have gained by chance here, about and at most (shown_error.h) */
    float chosen, chosen_most;
    float bright; /* share of the bounded fit (bright.h) */
} lf_cell;

/* Of one depth in a band: places [u0, u0 + nu), in the index from `first` on; nu = 0: none. */
typedef struct lf_deck {
    int u0, nu;
    size_t first;
} lf_deck;

/* The cells of one row of a lattice. */
typedef struct lf_band {
    int z0, nz;
    lf_deck *layers; /* [nz] */
    int n_layers;    /* allocated */
    int *index;      /* number of a cell, -1: none */
    size_t n_places, index_size;
    lf_cell *cells;
    int n, size; /* cells; allocated */
} lf_band;

typedef struct lf_lattice {
    int n_bands;
    lf_band *bands;
} lf_lattice;

/* Where N/W' is less noisy than N/W (lf_film_row_second), as a row had it at the last fit: with n
 * samples. */
typedef struct lf_known_second {
    double n[2];
    bool *is; /* [view][column]; NULL: not kept */
} lf_known_second;

struct lf_reconstruction {
    lf_reconstruct_view view;
    float *shift;
    lf_pool *pool;
    lf_lattice level[LF_LEVELS];
    float cell_depth; /* of a finest cell, in pixels at the plane Z = D */
    const lf_past *past;
    lf_past_move move; /* to it; map: from cells to its cells */
    const struct lf_reconstruct_kernels *kernels;
    pthread_mutex_t lock;
    struct lf_reconstruct_scratch *scratch; /* under the lock: what nobody uses */
    struct lf_bright *bright;               /* [level 1's n_bands] */
    lf_known_second *second;                /* [height] */
    struct lf_residual *residual;
    lf_reconstruction *bounded;     /* of what is bounded; NULL: never needed */
    const lf_reconstruction *whole; /* what this is the bounded one of */
    bool ready;
    bool is_bright; /* the last fit goes by the bounded one somewhere */
};

/* Whether a row's pixels of this view are summed up: with many views every third, another one in
 * each row. Neighbouring views share their paths, so that the others know next to nothing more. */
static inline bool lf_view_is_fitted(const lf_reconstruction *r, int row, int view)
{
    int step = r->view.n_views / 15 < 3 ? r->view.n_views / 15 : 3;
    return step < 2 || (row + view) % step == 0;
}

/* Where (u, z) is in the index; -1: nowhere. */
static inline ptrdiff_t lf_band_place(const lf_band *band, int u, int z)
{
    if (z < band->z0 || z - band->z0 >= band->nz)
        return -1;
    const lf_deck *layer = &band->layers[z - band->z0];
    if (u < layer->u0 || u - layer->u0 >= layer->nu)
        return -1;
    return (ptrdiff_t)layer->first + (u - layer->u0);
}

/* The number of the cell at (u, z), -1: there is none. */
static inline int lf_band_find(const lf_band *band, int u, int z)
{
    ptrdiff_t place = lf_band_place(band, u, z);
    return place < 0 ? -1 : band->index[place];
}

/* The n-th of the 27 cells around one: where it is from there, and its tent weight. */
typedef struct lf_around {
    int du, dv, dz;
    float weight;
} lf_around;
static inline lf_around lf_around_at(int n)
{
    int du = n % 3 - 1, dz = n / 3 % 3 - 1, dv = n / 9 - 1;
    return (lf_around){du, dv, dz, (dv ? 0.5f : 1.0f) * (dz ? 0.5f : 1.0f) * (du ? 0.5f : 1.0f)};
}

/* That cell, NULL: there is none; what it counts. */
const lf_cell *lf_cell_around(const lf_lattice *l, int number, const lf_cell *cell, int n,
                              float *weight);

/* How a band is made: begun with the depths [z0, z0 + nz), widened by every place, opened, every
 * place marked; then there is a cell, all zero, wherever there was a mark. All but the inline ones
 * may fail with LF_E_NOMEM; lf_band_finish then, too. */
LF_NODISCARD lf_status lf_band_begin(lf_band *band, int z0, int nz);
static inline void lf_band_widen(lf_band *band, int u, int z)
{
    lf_deck *layer = &band->layers[z - band->z0];
    int end = layer->nu > 0 ? layer->u0 + layer->nu : u + 1;
    layer->u0 = layer->nu > 0 && layer->u0 < u ? layer->u0 : u;
    layer->nu = (end > u + 1 ? end : u + 1) - layer->u0;
}
LF_NODISCARD lf_status lf_band_open(lf_band *band);
static inline void lf_band_mark(lf_band *band, int u, int z)
{
    band->index[lf_band_place(band, u, z)] = 0;
}
LF_NODISCARD lf_status lf_band_reserve(lf_band *band);
void lf_band_finish(lf_band *band);

/* Rounded down, also below 0. */
static inline int lf_half_of(int x)
{
    return x >= 0 ? x / 2 : -((1 - x) / 2);
}

/* Adds the sums of `from` as seen from a place `shift` away: f + shift for the first three
 * features.
 */
void lf_raw_add(lf_raw_sums *to, const lf_raw_sums *from, const float shift[3]);

#endif
