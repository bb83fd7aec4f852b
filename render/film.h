/* The film: what passes leave behind, and the three answers; private to render/.
 *
 * Row-major by epipolar row: [row][half][view][column]. All targets of a base path lie in its row and a row belongs to one
 * thread, so there are no atomics and no locks, and the sums do not depend on the number of threads. Two independent
 * halves; per view pixel and half (docs/estimators.md, "The film"):
 *
 *     N  radiance of pivots, weighted        W  prefix weights,      E = n q      W' directional weights, E = n q
 *     B  known light, mean                   q  pivot probability, mean           M  native delta lobes
 *
 * and per row and half the count n, in native samples a view pixel (a real number: expected, not tallied). Rows that were never visited
 * since lf_film_clear are not touched and cost no memory. */
#ifndef LF_RENDER_FILM_H
#define LF_RENDER_FILM_H

#include "render/render.h"

/* What scattering left in one view pixel: 16 bytes that are written together. */
typedef struct lf_film_scattered {
    float n[3], w;
} lf_film_scattered;

typedef struct lf_film_known {
    float b[3], q;
} lf_film_known;

/* One half of one row; arrays [view][column]. */
typedef struct lf_film_half {
    lf_film_scattered *scattered;
    lf_film_known *known;
    float *w2;          /* W'; NULL where no lobe depends on the view */
    float (*native)[3]; /* M; NULL without delta lobes */
} lf_film_half;

typedef struct lf_film_row {
    double n[2];   /* expected native samples a view pixel in each half */
    double passes; /* n times views, both halves */
    uint32_t visits[2];
    /* Left by the last resolve: */
    double relative_error; /* sum over view pixels of var / (I^2 + epsilon), < 0 = not known */
    int64_t holes;
} lf_film_row;

typedef struct lf_film {
    int n_views, width, height;
    bool has_w2, has_native;
    size_t row_bytes;    /* both halves */
    unsigned char *data; /* mapped, [height][row_bytes] */
    size_t data_bytes;
    lf_film_row *rows; /* [height] */
} lf_film;

/* film must be zeroed or finished. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_init(lf_film *film, int n_views, int width, int height, bool has_w2, bool has_native);
void lf_film_finish(lf_film *film);
/* Nothing has been visited. Touches only the row headers. */
void lf_film_clear(lf_film *film);
lf_film_half lf_film_at(const lf_film *film, int row, int half);
/* Zeroes a row's sums before its first visit. */
void lf_film_row_begin(lf_film *film, int row);

/* See lf_renderer_resolve_row. */
lf_status lf_film_resolve_row(const lf_film *film, lf_estimator estimator, int row, float *out, uint8_t *flags);

#endif
