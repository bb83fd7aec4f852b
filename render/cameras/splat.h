/* Sums that anybody may add to at any time, and that do not depend on the order: whole numbers of a
 * unit, which add up exactly; private to render/. A pass of an integrator whose paths leave their
 * row of the film gathers N and W in them. Four numbers a view pixel, 32 bytes. */
#ifndef LF_RENDER_SPLAT_H
#define LF_RENDER_SPLAT_H

#include <stdatomic.h>

#include "render/film/film.h"
#include "render/transport/path/track.h"

typedef struct lf_splat {
    atomic_uint_least64_t sum[4]; /* N, then W; with a sign, in two's complement */
} lf_splat;

/* [row][view][column] */
typedef struct lf_splats {
    size_t row; /* splats of one */
    int height;
    lf_splat *at;
    double unit;          /* radiance for a step of N; W's is LF_SPLAT_WEIGHT */
    atomic_llong dropped; /* what was too much for one addition, or no number */
    atomic_llong rounds;  /* sums that went round upwards less those that did downwards */
} lf_splats;

#define LF_SPLAT_WEIGHT 0x1p-32
/* Steps that the largest radiance of a pilot is, few beside what rounding costs, so that there is
 * room for what a pilot misses; and those that are too many for one addition: 2^34 times as much. A
 * pixel holds another eight times that. */
#define LF_SPLAT_PILOT 0x1p26
#define LF_SPLAT_MOST 0x1p60

/* For such a film; largest: what a pilot found, 0: nothing. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_splats_init(lf_splats *splats, const lf_film_layout *layout);
void lf_splats_scale(lf_splats *splats, float largest);
/* Numbers that are lost to what was dropped or went round; sums that go round both ways cancel. */
int64_t lf_splats_lost(const lf_splats *splats);
/* What they take. */
int64_t lf_splats_bytes(const lf_splats *splats);
void lf_splats_finish(lf_splats *splats);

/* Adds a weight and radiance, weighted (below 0 where a control says too much), to a view pixel
 * [view][column] of a row, rounded up or down at random in proportion by the tracer's numbers:
 * without bias, and the same in whatever order. Any thread. */
void lf_splats_add(lf_splats *splats, lf_tracer *tracer, int row, size_t pixel, lf_vec3 n,
                   double weight);

/* Moves a row into sums, which are zeroed for it, and leaves it empty. */
void lf_splats_take(lf_splats *splats, int row, const lf_film_sums *out);
/* Forgets all. */
void lf_splats_clear(lf_splats *splats);

#endif
