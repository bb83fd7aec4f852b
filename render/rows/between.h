/* A row without paths, between two that have some: where these change little, nothing is looked for
 * between them; private to render/rows. */
#ifndef LF_RENDER_BETWEEN_H
#define LF_RENDER_BETWEEN_H

#include "render/film/film.h"
#include "render/plane/rig.h"

/* Fans of a coarse visit: in every column that this divides, and in the last. */
#define LF_UNSCATTERED_COARSE 4
#define LF_MAX_CHUNKS (LF_MAX_VIEW_SIDE / LF_UNSCATTERED_COARSE + 1)

/* The two rows, arrays [view][column]; known NULL: it is not stored. */
typedef struct lf_between {
    const float *q[2];
    const lf_packed_feature *feature[2];
    const lf_film_known *known[2];
    bool tinted; /* the film keeps albedo: what surfaces are like between is not known */
} lf_between;

/* false: there are none that have been visited, at most LF_UNSCATTERED_COARSE rows apart. */
bool lf_between_find(const lf_film *film, int row, lf_between *out);
/* Where both change little from one fan to the next and from row to row: bit g of smooth[i] is that
 * of the views from g * LF_LANES on, in the columns from fan i up to the next. Whether they do
 * everywhere. */
bool lf_between_mark(const lf_between *rows, const lf_rig *rig, uint32_t smooth[LF_MAX_CHUNKS]);

#endif
