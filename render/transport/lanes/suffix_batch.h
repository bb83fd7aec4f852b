/* Pivots in media whose suffixes are drawn together, in lanes (suffix.h); private to render/. What
 * a pivot is to whoever spreads it over views is kept by that, under the same number. */
#ifndef LF_RENDER_SUFFIX_BATCH_H
#define LF_RENDER_SUFFIX_BATCH_H

#include "render/transport/lanes/suffix.h"
#include "render/transport/path/suffix_one.h"

/* Pivots, and suffixes of each: one costs about a third of what the rest of a pivot costs
 * (docs/lab/performance.md, "Suffixes in lanes"). */
enum { LF_BATCH_PIVOTS = 1024, LF_BATCH_EACH = 4 };

typedef struct lf_batch_pivot {
    lf_vec3 p, w; /* where, and the way that its ray came */
    int volume;
    uint64_t rng;   /* where the random numbers of its suffixes begin */
    bool has_light; /* set by lf_suffix_batch_add, as is its light */
    lf_light_sample light;
} lf_batch_pivot;

typedef struct lf_suffix_batch {
    const lf_lane_scene *lanes;
    const lf_suffixes *suffixes;
    int n, traced; /* pivots, of which the first so many have been traced */
    int each;      /* suffixes of each, at most LF_BATCH_EACH */
    int most;      /* traced at once: fewer where paths are long, so that visits can be cancelled */
    lf_batch_pivot pivot[LF_BATCH_PIVOTS];
    /* [pivot]: where, volume space, and what of the light is left there, 0..1 in the mean */
    float q[3][LF_BATCH_PIVOTS], left[LF_BATCH_PIVOTS];
    float toward[3][LF_BATCH_PIVOTS]; /* its light, where the scene `has` LF_LANE_SKY */
    uint32_t random[2][LF_BATCH_PIVOTS];
    /* [pivot][suffix] */
    float from[3][LF_BATCH_PIVOTS * LF_BATCH_EACH], wi[3][LF_BATCH_PIVOTS * LF_BATCH_EACH],
        radiance[3][LF_BATCH_PIVOTS * LF_BATCH_EACH], lit[3][LF_BATCH_PIVOTS * LF_BATCH_EACH];
    float escaped[LF_BATCH_PIVOTS * LF_BATCH_EACH];
    uint32_t path_random[2][LF_BATCH_PIVOTS * LF_BATCH_EACH];
    lf_lane_memory memory;
} lf_suffix_batch;

/* Of memory that is all zero; each: suffixes of a pivot. Borrows the rest. */
void lf_suffix_batch_init(lf_suffix_batch *batch, const lf_lane_scene *lanes,
                          const lf_suffixes *suffixes, int each);

/* Forgets all pivots. */
static inline void lf_suffix_batch_clear(lf_suffix_batch *batch)
{
    batch->n = batch->traced = 0;
}

/* Takes in a pivot (all but its light), whose sampler's numbers it draws at once; returns its
 * number. There must be room: */
int lf_suffix_batch_add(lf_suffix_batch *batch, const lf_scene *scene, const lf_batch_pivot *pivot,
                        lf_sampler *sampler);
static inline bool lf_suffix_batch_is_full(const lf_suffix_batch *batch)
{
    return batch->n == LF_BATCH_PIVOTS;
}

/* Draws the suffixes of all that have none yet; they stay until the batch is cleared. How often
 * grids were looked up is counted by the tracer, which answers rays where the scene has surfaces;
 * its random numbers, width and spread are then others. */
void lf_suffix_batch_trace(lf_suffix_batch *batch, lf_tracer *tracer, int max_depth);
/* The same as soon as enough wait. When that is depends on how long paths were before: what is
 * spread when, and so the order of sums, must not. */
void lf_suffix_batch_keep_up(lf_suffix_batch *batch, lf_tracer *tracer, int max_depth);

/* Direction k of pivot `at`, drawn by the phase function and traced, into a suffix that has none.
 */
void lf_suffix_batch_direction(const lf_suffix_batch *batch, const lf_scene *scene, int at, int k,
                               lf_suffix *out);

#endif
