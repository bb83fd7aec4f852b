/* Sums to which any thread may add at any time, independent of the order: exact integer multiples
 * of a unit; private to render/. Integrators whose paths leave their row collect N and W of a pass
 * in them. Four numbers per view pixel, 32 bytes. */
#ifndef LF_RENDER_SPLAT_H
#define LF_RENDER_SPLAT_H

#include <stdatomic.h>

#include "render/film/film.h"
#include "render/transport/path/track.h"

typedef struct lf_splat {
    atomic_uint_least64_t sum[4]; /* N, then W; signed, in two's complement */
} lf_splat;

/* [row][view][column] */
typedef struct lf_splats {
    size_t row; /* splats per row */
    int height;
    lf_splat *at;
    double unit;          /* radiance of one step of N; the step of W is LF_SPLAT_WEIGHT */
    atomic_llong dropped; /* additions that were too large or NaN */
    atomic_llong rounds;  /* overflows upwards minus overflows downwards */
} lf_splats;

#define LF_SPLAT_WEIGHT 0x1p-32
/* LF_SPLAT_PILOT: the largest radiance of a pilot, in steps. It is low in relation to the cost of
 * rounding, to leave room for radiance that a pilot misses. LF_SPLAT_MOST: limit of one addition,
 * 2^34 times as much. A pixel holds another eight times that. */
#define LF_SPLAT_PILOT 0x1p26
#define LF_SPLAT_MOST 0x1p60

/* Allocates for a film of this layout. LF_E_NOMEM. lf_splats_scale sets the unit from the largest
 * radiance of a pilot; 0: the pilot found no light. */
LF_NODISCARD lf_status lf_splats_init(lf_splats *splats, const lf_film_layout *layout);
void lf_splats_scale(lf_splats *splats, float largest);
/* The number of contributions lost to dropped additions or overflow. Overflows in both directions
 * cancel. */
int64_t lf_splats_lost(const lf_splats *splats);
/* Their memory in bytes. */
int64_t lf_splats_bytes(const lf_splats *splats);
void lf_splats_finish(lf_splats *splats);

/* Adds a weight and weighted radiance (below 0 if a control variate is too large) to a view pixel
 * [view][column] of a row. The tracer's random numbers round it up or down in proportion: unbiased
 * and independent of the order. Any thread. */
void lf_splats_add(lf_splats *splats, lf_tracer *tracer, int row, size_t pixel, lf_vec3 n,
                   double weight);

/* Moves a row into sums, which must be zeroed, and clears it. */
void lf_splats_take(lf_splats *splats, int row, const lf_film_sums *out);
/* Sets all to 0. */
void lf_splats_clear(lf_splats *splats);

#endif
