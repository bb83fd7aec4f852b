/* Rows without paths between two rows with paths: if these two differ little, nothing is computed
 * between them. Private to render/rows. */
#ifndef LF_RENDER_BETWEEN_H
#define LF_RENDER_BETWEEN_H

#include "render/film/film.h"
#include "render/plane/rig.h"

/* Column spacing of fans in a coarse visit; the last column also has a fan. */
#define LF_UNSCATTERED_COARSE 4
#define LF_MAX_CHUNKS (LF_MAX_VIEW_SIDE / LF_UNSCATTERED_COARSE + 1)

/* The two rows, arrays [view][column]; known NULL: not stored. */
typedef struct lf_between {
    const float *q[2];
    const lf_packed_feature *feature[2];
    const lf_film_known *known[2];
    const lf_film *film;
    int row[2];
    bool tinted; /* the film stores albedo, which cannot be interpolated from the two rows */
} lf_between;

/* false: no two visited rows lie around this one, at most LF_UNSCATTERED_COARSE rows apart. Else
 * they are open until lf_between_close. */
bool lf_between_find(const lf_film *film, int row, lf_between *out);
void lf_between_close(const lf_between *rows);
/* Marks where both rows change little, from one fan to the next and from row to row. Bit g of
 * smooth[i]: views from g * LF_LANES on, columns from fan i to the next. Returns whether all bits
 * are set. */
bool lf_between_mark(const lf_between *rows, const lf_rig *rig, uint32_t smooth[LF_MAX_CHUNKS]);

#endif
