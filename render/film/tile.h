/* A tile of one row of the film during resolve (resolve.c), and the control variates of a half in
 * it; private to render/film. */
#ifndef LF_RENDER_FILM_TILE_H
#define LF_RENDER_FILM_TILE_H

#include "render/film/film.h"

/* LF_TILE_BESIDE: columns on either side of a pixel that are used to estimate its brightness. */
enum { LF_TILE_COLUMNS = 16, LF_TILE_VIEWS = 4, LF_TILE_BESIDE = 2 };

/* epsilon of relative errors: they are divided by I^2 + epsilon. */
#define LF_ERROR_EPSILON 1e-2

/* Data of a pixel: means over n; known is B + M/n. */
typedef struct lf_sums {
    float scattered[3], w, w2, known[3], q;
} lf_sums;

typedef struct lf_tile_pixel {
    lf_sums half[2];
    lf_sums pooled;
} lf_tile_pixel;

/* One tile of one row, read once; all later steps use this copy. */
typedef struct lf_tile {
    const lf_film *film;
    lf_film_half half[2];
    const lf_film_known *known; /* NULL if B is sky (1 - q) */
    float n[2];                 /* expected samples of each half; 0 = none */
    float share[2];             /* fraction of all samples */
    float share_known[2];       /* fraction of the samples that q and B are means over */
    int n_halves;
    int row;
    int view0, view1, column0, column1;
    int count;
    /* N/W of the tile: of the halves, and of both; used if weights may cancel */
    double ratio[3][3];
    lf_tile_pixel pixel[LF_TILE_VIEWS * LF_TILE_COLUMNS];
} lf_tile;

/* The divisor of N (lf_film_weight). */
static inline float lf_sums_weight(const lf_sums *s, bool second)
{
    return lf_film_weight(s->w, s->w2, second);
}

/* Regression coefficients of one half over one tile: of N - n q R on R (W - n q) and R (W' - n q).
 */
typedef struct lf_beta {
    double ratio[LF_TILE_VIEWS * LF_TILE_COLUMNS][3]; /* R */
    double lambda[2];
} lf_beta;

/* Computes them from one half; docs/developer/estimators.md, "8. Three estimators". */
void lf_tile_regress(const lf_tile *tile, int half, lf_beta *out);

#endif
