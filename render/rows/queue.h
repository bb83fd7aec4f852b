/* Pivots in media that wait until there are enough of them for lanes (transport/suffix.h), in place
 * of one suffix each as it comes; private to render/rows/. They are spread over the views in the
 * order in which they came, so that sums on the film do not depend on how many wait at a time. */
#ifndef LF_RENDER_QUEUE_H
#define LF_RENDER_QUEUE_H

#include "render/rows/visit.h"

/* Pivots, and suffixes of each: one costs about a third of what the rest of a pivot costs
 * (docs/performance.md, "Suffixes in lanes"). */
enum { LF_QUEUE_PIVOTS = 1024, LF_QUEUE_EACH = 4 };
/* Of a queue that does not know yet how long paths are. */
enum { LF_QUEUE_FIRST = 64 };

/* A pivot that waits: what is left of lf_pivot and lf_visit when its turn comes. */
typedef struct lf_queued {
    lf_vec3 p, w;
    float x, z, lx, boost, alone;
    int medium, volume, view, column;
    bool has_light;
    lf_light_sample light;
    lf_vec3 wi;
    uint64_t rng; /* of the tracer */
} lf_queued;

typedef struct lf_queue {
    const lf_lane_scene *lanes;
    const lf_suffixes *suffixes;
    int n, each;  /* pivots that wait, and suffixes of each, at most LF_QUEUE_EACH */
    int64_t most; /* that may wait: fewer where paths are long, so that visits can be cancelled */
    lf_queued item[LF_QUEUE_PIVOTS];
    /* [pivot]: where, volume space, and what of the light is left there */
    float q[3][LF_QUEUE_PIVOTS], left[LF_QUEUE_PIVOTS];
    float toward[3][LF_QUEUE_PIVOTS]; /* its light, where the scene `has` more than directions */
    uint32_t random[2][LF_QUEUE_PIVOTS];
    /* [pivot][suffix] */
    float from[3][LF_QUEUE_PIVOTS * LF_QUEUE_EACH], wi[3][LF_QUEUE_PIVOTS * LF_QUEUE_EACH],
        radiance[3][LF_QUEUE_PIVOTS * LF_QUEUE_EACH], lit[3][LF_QUEUE_PIVOTS * LF_QUEUE_EACH];
    float escaped[LF_QUEUE_PIVOTS * LF_QUEUE_EACH];
    uint32_t path_random[2][LF_QUEUE_PIVOTS * LF_QUEUE_EACH];
    lf_lane_memory memory;
} lf_queue;

/* Takes in a pivot in a medium, whose sampler's numbers it draws at once; flushes when it is full.
 */
void lf_queue_push(lf_queue *queue, lf_visit *visit, int view, int column, const lf_pivot *pivot);

/* Draws the suffixes of all that wait and spreads them. */
void lf_queue_flush(lf_queue *queue, lf_visit *visit);

#endif
