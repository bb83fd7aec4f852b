/* The lattices of a reconstruction: cells of the world (place along the epipolar line, row, depth)
 * with sums over the pixels of all views that lie in them; private to render/reconstruct.
 *
 * Level 0 has cells of LF_CELL_SIDE pixels; every higher level has cells twice as wide, high and
 * deep. Cells exist only where there are pixels. Coordinates are in units of a finest cell, whose
 * depth is LF_CELL_DEPTH pixels at the plane Z = D (or more: LF_MAX_DEPTHS). */
#ifndef LF_RENDER_RECONSTRUCT_LATTICE_H
#define LF_RENDER_RECONSTRUCT_LATTICE_H

#include <stddef.h>

#include "render/reconstruct/reconstruct.h"

#define LF_CELL_SIDE 4
#define LF_CELL_DEPTH 16
/* Limit of cells in depth; beyond it cells are deeper. */
#define LF_MAX_DEPTHS 4096
#define LF_LEVELS 4

/* Features besides the constant. The first three are coordinates, relative to the middle of a cell
 * or node. */
enum { LF_PLACE, LF_ROW, LF_DEPTH, LF_MEDIA, LF_PIVOTS, LF_VIEW, LF_SPREAD, LF_LIGHT, LF_FEATURES };

/* One number per feature, in one or two vectors of the machine. */
typedef float lf_by_feature __attribute__((vector_size(4 * LF_FEATURES)));

/* Sums over pixels with weights W and radiance N of one half, and features f of the same or the
 * other half. */
typedef struct lf_moments {
    float w, n[3];
    float wf[LF_FEATURES];
    /* after lf_reconstruct_kernels.move only the upper triangle */
    float wff[LF_FEATURES][LF_FEATURES];
    float nf[3][LF_FEATURES];
} lf_moments;

/* A linear function of features. */
typedef struct lf_plane {
    float constant, slope[LF_FEATURES];
} lf_plane;

enum { LF_HALF_A, LF_HALF_B, LF_BOTH, LF_VARIANTS };

/* Sums besides moments for the raw result N/W, which acts as the level below the finest. */
typedef struct lf_raw_sums {
    float cross[2][3];      /* [h] of N_h/W_h N_g, g the other half */
    lf_plane product[2][3]; /* [h] of N_h/W_h W_g f, f of half h */
    float weight[2];        /* [h] of W_g where N_h/W_h is valid */
    float square[3];        /* of N^2/W, both halves pooled */
    float known[3], albedo[3], q, pixels;
} lf_raw_sums;

/* What a cell is fitted to: most of a fit's memory, which only exists during the fit. */
typedef struct lf_cell_sums {
    lf_moments half[2][2]; /* [features of][weights of] the halves */
    lf_raw_sums raw;
} lf_cell_sums;

typedef struct lf_cell {
    int u, z; /* in units of this level's cells */
    /* of the fit; then of the blend with all coarser levels */
    lf_plane node[LF_VARIANTS][3];
    float agreed, total;      /* of the shrinkage towards this level (shrink.c) */
    float share;              /* of this level, after settling */
    bool filled[LF_VARIANTS]; /* the node is valid */
    float own[LF_VARIANTS];   /* share of its own fit that its pivots W allow: W/(W + few) */
    /* gain of the shares by chance here, estimate and upper bound (shown_error.h) */
    float chosen, chosen_most;
    float bright;  /* share of the bounded fit (bright.h) */
    float seen[4]; /* W and N of both halves */
} lf_cell;

/* One depth of a band: places [u0, u0 + nu), in the index from `first` on; nu = 0: none. */
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
    lf_cell_sums *sums; /* of the cells, in their order; NULL: no fit goes on */
    int n, size;        /* cells; allocated */
    int sums_size;      /* allocated */
} lf_band;

typedef struct lf_lattice {
    int n_bands;
    lf_band *bands;
} lf_lattice;

/* Where N/W' is less noisy than N/W (lf_film_row_second), for a row at the last fit, with n
 * samples. */
typedef struct lf_known_second {
    double n[2];
    bool *is; /* [view][column]; NULL: not stored */
} lf_known_second;

struct lf_reconstruction {
    lf_reconstruct_view view;
    float *shift;
    lf_pool *pool;
    lf_lattice level[LF_LEVELS];
    float cell_depth; /* of a finest cell, in pixels at the plane Z = D */
    const lf_past *past;
    lf_past_move move; /* to the past's coordinates; map: from cells to its cells */
    const struct lf_reconstruct_kernels *kernels;
    pthread_mutex_t lock;
    struct lf_reconstruct_scratch *scratch; /* under the lock: unused ones */
    struct lf_bright *bright;               /* [level 1's n_bands] */
    lf_known_second *second;                /* [height] */
    struct lf_residual *residual;
    lf_reconstruction *bounded;     /* of bounded values; NULL: never needed */
    const lf_reconstruction *whole; /* the reconstruction that this is the bounded one of */
    bool ready;
    bool is_bright; /* the last fit uses the bounded one somewhere */
};

/* Whether a row's pixels of this view are included in the sums. With many views only every third
 * is, a different one in each row: neighbouring views share their paths, so that the others add
 * almost no information. */
static inline bool lf_view_is_fitted(const lf_reconstruction *r, int row, int view)
{
    int step = r->view.n_views / 15 < 3 ? r->view.n_views / 15 : 3;
    return step < 2 || (row + view) % step == 0;
}

/* Index of (u, z); -1: outside. */
static inline ptrdiff_t lf_band_place(const lf_band *band, int u, int z)
{
    if (z < band->z0 || z - band->z0 >= band->nz)
        return -1;
    const lf_deck *layer = &band->layers[z - band->z0];
    if (u < layer->u0 || u - layer->u0 >= layer->nu)
        return -1;
    return (ptrdiff_t)layer->first + (u - layer->u0);
}

/* The number of the cell at (u, z), -1: no cell. */
static inline int lf_band_find(const lf_band *band, int u, int z)
{
    ptrdiff_t place = lf_band_place(band, u, z);
    return place < 0 ? -1 : band->index[place];
}

/* The n-th of the 27 cells around one: its offset, and its tent weight. */
typedef struct lf_around {
    int du, dv, dz;
    float weight;
} lf_around;
static inline lf_around lf_around_at(int n)
{
    int du = n % 3 - 1, dz = n / 3 % 3 - 1, dv = n / 9 - 1;
    return (lf_around){du, dv, dz, (dv ? 0.5f : 1.0f) * (dz ? 0.5f : 1.0f) * (du ? 0.5f : 1.0f)};
}

/* That cell, NULL: no cell; *weight: its weight. */
const lf_cell *lf_cell_around(const lf_lattice *l, int number, const lf_cell *cell, int n,
                              float *weight);
/* The sums of that cell. */
const lf_cell_sums *lf_sums_around(const lf_lattice *l, int number, const lf_cell *cell, int n,
                                   float *weight);

/* Steps to make a band: begin with the depths [z0, z0 + nz), widen by every place, open, mark every
 * place, reserve. Then every marked place has a zeroed cell and sums. The functions that are not
 * inline may fail with LF_E_NOMEM; call lf_band_finish also then. */
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
/* Returns the memory of the sums, at the end of a fit. */
void lf_band_drop_sums(lf_band *band);
/* Hands the memory of the sums, whose fit is over, on to another fit. */
void lf_band_lend_sums(lf_band *to, lf_band *from);
void lf_band_finish(lf_band *band);

/* Rounded down, also for negative x. */
static inline int lf_half_of(int x)
{
    return x >= 0 ? x / 2 : -((1 - x) / 2);
}

/* Adds the sums of `from`, translated by `shift`: f + shift for the first three features. */
void lf_raw_add(lf_raw_sums *to, const lf_raw_sums *from, const float shift[3]);

#endif
