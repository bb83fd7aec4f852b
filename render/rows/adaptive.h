/* Where base samples go: expected counts per pixel, and the map of them that amvpt makes after a
 * uniform pilot; private to render/.
 *
 * The map of a row is made from the pilots of its neighbours only, never from its own. Rows share
 * no random number. So, given its map, a row's sums are the same as under any fixed map, and mis
 * and cv stay unbiased (docs/developer/estimators/adaptive.md, "Why mis and cv stay unbiased"). A
 * map never changes once it is made. */
#ifndef LF_RENDER_ADAPTIVE_H
#define LF_RENDER_ADAPTIVE_H

#include "render/film/film.h"

/* Length of the pilot: native samples per view pixel in each half. */
#define LF_PILOT_SPP 1.0

/* Views and columns of a tile; the last tiles are smaller. */
enum { LF_COUNTS_VIEWS = 3, LF_COUNTS_COLUMNS = 4 };

typedef struct lf_counts {
    int n_views, width, height;
    int tiles_down, tiles_across; /* tiles of views and columns of one row */
    /* [row][tile of views][tile of columns] expected counts, 1 = the uniform count; NULL: all 1 */
    float *tile;
    /* [row][tile of views][tile of columns] the pilot met a delta lobe here; allocated with tile */
    uint8_t *delta;
    /* bit view * width + column in lf_counts_words words per row: 0 = no reader needs the pixel;
     * NULL: all 1 */
    const uint64_t *wanted;
} lf_counts;

/* Sets all tiles to 1. counts must be zeroed or finished. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_counts_init(lf_counts *counts, int n_views, int width, int height);
void lf_counts_finish(lf_counts *counts);
/* Index of the tile in its row that holds a view's column. */
size_t lf_counts_tile(const lf_counts *counts, int view, int column);
/* 64-bit words of `wanted` per row. */
size_t lf_counts_words(const lf_counts *counts);
/* Marks the tile of a pixel that met a delta lobe; counts->delta must not be NULL. */
void lf_counts_mark_delta(const lf_counts *counts, int row, int view, int column);
/* Expected counts of one row, out [view][column]. */
void lf_counts_row(const lf_counts *counts, int row, float *out);

/* Whether the pilot is complete: every row has LF_PILOT_SPP in both halves. */
bool lf_adaptive_ready(const lf_film *film);
/* Makes the map from a film that holds a pilot; uses the pool. LF_E_NOMEM: counts are as before. */
LF_NODISCARD lf_status lf_adaptive_map(const lf_film *film, lf_pool *pool, lf_counts *counts);

#endif
