/* Where base samples go: expected counts per pixel, and the map that amvpt makes of them behind a
 * uniform pilot; private to render/.
 *
 * The map of a row is made from the pilots of its neighbours alone, never from its own: rows share
 * no random number, so that given its map a row's sums are what they would be under any fixed map,
 * and mis and cv stay unbiased (docs/developer/estimators/adaptive.md, "Why mis and cv stay
 * unbiased"). Frozen once it is made. */
#ifndef LF_RENDER_ADAPTIVE_H
#define LF_RENDER_ADAPTIVE_H

#include "render/film/film.h"

/* Native samples a view pixel of each half that make a pilot. */
#define LF_PILOT_SPP 1.0

/* Views and columns of a tile; those at the end are smaller. */
enum { LF_COUNTS_VIEWS = 3, LF_COUNTS_COLUMNS = 4 };

typedef struct lf_counts {
    int n_views, width, height;
    int tiles_down, tiles_across; /* tiles of views and columns of one row */
    /* [row][tile of views][tile of columns] expected counts, 1 = as many as without a map; NULL: 1
     */
    float *tile;
    /* [row][tile of views][tile of columns] the pilot met a delta lobe here; with tile */
    uint8_t *delta;
    /* bit view * width + column of row's lf_counts_words: 0 = nobody reads that pixel; NULL: all */
    const uint64_t *wanted;
} lf_counts;

/* LF_E_NOMEM; counts must be zeroed or finished. All tiles are 1. */
LF_NODISCARD lf_status lf_counts_init(lf_counts *counts, int n_views, int width, int height);
void lf_counts_finish(lf_counts *counts);
/* The tile of its row that holds a view's column. */
size_t lf_counts_tile(const lf_counts *counts, int view, int column);
/* 64-bit words of a row of wanted. */
size_t lf_counts_words(const lf_counts *counts);
/* A delta lobe was met; counts->delta must be there. */
void lf_counts_mark_delta(const lf_counts *counts, int row, int view, int column);
/* One row, out [view][column]. */
void lf_counts_row(const lf_counts *counts, int row, float *out);

/* True when the pilot is complete: every row has LF_PILOT_SPP in both halves. */
bool lf_adaptive_ready(const lf_film *film);
/* Makes the map from a film that holds a pilot; uses the pool. LF_E_NOMEM: counts as they were. */
LF_NODISCARD lf_status lf_adaptive_map(const lf_film *film, lf_pool *pool, lf_counts *counts);

#endif
