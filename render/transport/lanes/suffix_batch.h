/* Pivots in media whose suffixes are traced together, in lanes (suffix.h); private to render/. The
 * code that spreads pivots over the views keeps its own data under the same number. */
#ifndef LF_RENDER_SUFFIX_BATCH_H
#define LF_RENDER_SUFFIX_BATCH_H

#include "render/transport/lanes/suffix.h"
#include "render/transport/path/suffix_one.h"

/* Pivots, and suffixes per pivot. One suffix costs about a third of the other work for a pivot
 * (docs/lab/performance.md, "Suffixes in lanes"). */
enum { LF_BATCH_PIVOTS = 1024, LF_BATCH_EACH = 4 };

typedef struct lf_batch_pivot {
    lf_vec3 p, w; /* position, and direction of travel of its ray */
    int volume;
    uint64_t rng;   /* start of the random numbers of its suffixes */
    bool has_light; /* set by lf_suffix_batch_add, together with light */
    lf_light_sample light;
} lf_batch_pivot;

typedef struct lf_suffix_batch {
    const lf_lane_scene *lanes;
    const lf_suffixes *suffixes;
    int n, traced; /* number of pivots; the first `traced` of them have been traced */
    int each;      /* suffixes per pivot, at most LF_BATCH_EACH */
    int most; /* number traced at once: fewer if paths are long, so that visits can be cancelled */
    lf_batch_pivot pivot[LF_BATCH_PIVOTS];
    /* [pivot]: position, volume space, and transmittance towards the light, mean in 0..1 */
    float q[3][LF_BATCH_PIVOTS], left[LF_BATCH_PIVOTS];
    float toward[3][LF_BATCH_PIVOTS]; /* direction to its light, if the scene `has` LF_LANE_SKY */
    uint32_t random[2][LF_BATCH_PIVOTS];
    /* [pivot][suffix] */
    float from[3][LF_BATCH_PIVOTS * LF_BATCH_EACH], wi[3][LF_BATCH_PIVOTS * LF_BATCH_EACH],
        radiance[3][LF_BATCH_PIVOTS * LF_BATCH_EACH], lit[3][LF_BATCH_PIVOTS * LF_BATCH_EACH];
    float escaped[LF_BATCH_PIVOTS * LF_BATCH_EACH];
    uint32_t path_random[2][LF_BATCH_PIVOTS * LF_BATCH_EACH];
    lf_lane_memory memory;
} lf_suffix_batch;

/* Initialises zeroed memory; each: suffixes per pivot. Borrows the other arguments. */
void lf_suffix_batch_init(lf_suffix_batch *batch, const lf_lane_scene *lanes,
                          const lf_suffixes *suffixes, int each);

/* Removes all pivots. */
static inline void lf_suffix_batch_clear(lf_suffix_batch *batch)
{
    batch->n = batch->traced = 0;
}

/* Adds a pivot (without its light), draws its sampler's numbers at once and returns its number. The
 * batch must not be full. */
int lf_suffix_batch_add(lf_suffix_batch *batch, const lf_scene *scene, const lf_batch_pivot *pivot,
                        lf_sampler *sampler);
static inline bool lf_suffix_batch_is_full(const lf_suffix_batch *batch)
{
    return batch->n == LF_BATCH_PIVOTS;
}

/* Traces the suffixes of all untraced pivots; they stay until the batch is cleared. The tracer
 * counts the grid look-ups, and traces rays in scenes with surfaces. This changes its random
 * numbers, width and spread. */
void lf_suffix_batch_trace(lf_suffix_batch *batch, lf_tracer *tracer, int max_depth);
/* lf_suffix_batch_trace as soon as enough pivots wait. The time of tracing depends on the lengths
 * of earlier paths, so the order in which pivots are spread and summed must not depend on it. */
void lf_suffix_batch_keep_up(lf_suffix_batch *batch, lf_tracer *tracer, int max_depth);

/* Direction k of pivot `at`, drawn by the phase function and traced, into a suffix without a
 * direction. */
void lf_suffix_batch_direction(const lf_suffix_batch *batch, const lf_scene *scene, int at, int k,
                               lf_suffix *out);

#endif
