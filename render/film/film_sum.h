/* The sum of one row over many films, in double precision, rounded once; private to render/film/.
 *
 * N, W and W' are sums; q, B, features and albedo are means, weighted by the counts of the visits
 * that computed them (and q); half by half. Marks of holes (lf_film_settle) do not add up: a pixel
 * has one if no film has a weight for it. The additions are made in the order of the calls.
 * Constants and sums that are floats stay exact. Thread: one at a time. */
#ifndef LF_RENDER_FILM_SUM_H
#define LF_RENDER_FILM_SUM_H

#include "render/film/film.h"

/* Vanishes next to any weight. */
#define LF_SUM_MARK 1e-300

typedef struct lf_half_sum {
    /* w: LF_SUM_MARK for each mark; q: the mean so far */
    double n[3], w, w2, q;
} lf_half_sum;

/* Means so far; variance: the square of lf_feature.spread. */
typedef struct lf_feature_sum {
    double weight, nearness, variance, surface, light;
} lf_feature_sum;

typedef struct lf_known_sum {
    double b[3], half[2][3]; /* means of both halves, and of each */
} lf_known_sum;

typedef struct lf_albedo_sum {
    double weight, of[LF_ALBEDO_NUMBERS];
} lf_albedo_sum;

/* Arrays are [view][column]; NULL if the layout has no such data. */
typedef struct lf_film_sum {
    lf_film_layout layout;
    size_t pixels;
    lf_half_sum *half[2];
    lf_feature_sum *feature[2];
    lf_known_sum *known;
    lf_albedo_sum *albedo;
    double n_known[2]; /* of the visits in q, B and features */
    lf_film_row row;   /* the counts so far */
    bool whole;
} lf_film_sum;

/* Bytes of memory of a sum. */
size_t lf_film_sum_bytes(const lf_film_layout *layout);
/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_film_sum_init(lf_film_sum *sum, const lf_film_layout *layout);
void lf_film_sum_finish(lf_film_sum *sum);
/* Starts a row. whole: any of its films has visits that are not coarse; then what coarse visits
 * know does not count. */
void lf_film_sum_begin(lf_film_sum *sum, bool whole);
/* Adds a row of a film of the layout. */
void lf_film_sum_add(lf_film_sum *sum, const lf_film *from, int row);
/* Writes the sum into a row of a film, with its counts. key: random bits of what is in it. False:
 * there are more visits or samples than a row can have. */
bool lf_film_sum_put(const lf_film_sum *sum, uint64_t key, const lf_film *film, int row);

#endif
