/* A tile of one row of the film, as it is resolved (resolve.c), and what the control variates of a
 * half do in it; private to render/film. */
#ifndef LF_RENDER_FILM_TILE_H
#define LF_RENDER_FILM_TILE_H

#include "render/film/film.h"

/* BESIDE: columns to either side of a pixel that are asked how bright it is. */
enum { LF_TILE_COLUMNS = 16, LF_TILE_VIEWS = 4, LF_TILE_BESIDE = 2 };

/* What errors are relative to: I^2 and this. */
#define LF_ERROR_EPSILON 1e-2

/* What a pixel holds: means over n; known is B + M/n. */
typedef struct lf_sums {
    float scattered[3], w, w2, known[3], q;
} lf_sums;

typedef struct lf_tile_pixel {
    lf_sums half[2];
    lf_sums pooled;
} lf_tile_pixel;

/* One tile of one row, read once; everything else works on this copy. */
typedef struct lf_tile {
    const lf_film *film;
    lf_film_half half[2];
    const lf_film_known *known; /* NULL where B is sky (1 - q) */
    float n[2];                 /* expected samples of each half; 0 = it has none */
    float share[2];             /* of all samples */
    float share_known[2];       /* of those whose q and B count */
    int n_halves;
    int row;
    int view0, view1, column0, column1;
    int count;
    double ratio[3][3]; /* N/W of the tile: of the halves, and of both; where weights may cancel */
    lf_tile_pixel pixel[LF_TILE_VIEWS * LF_TILE_COLUMNS];
} lf_tile;

/* What N is divided by (lf_film_weight). */
static inline float lf_sums_weight(const lf_sums *s, bool second)
{
    return lf_film_weight(s->w, s->w2, second);
}

/* Coefficients of one half over one tile: of N - n q R on R (W - n q) and R (W' - n q). */
typedef struct lf_beta {
    double ratio[LF_TILE_VIEWS * LF_TILE_COLUMNS][3]; /* R */
    double lambda[2];
} lf_beta;

/* What one half says they are; docs/developer/estimators.md, "8. Three estimators". */
void lf_tile_regress(const lf_tile *tile, int half, lf_beta *out);

#endif
