/* Pivots in media that wait until there are enough of them for lanes
 * (transport/lanes/suffix_batch.h), in place of one suffix each as it comes; private to
 * render/rows/. They are spread over the views in the order in which they came, so that sums on the
 * film do not depend on how many wait at a time.
 */
#ifndef LF_RENDER_QUEUE_H
#define LF_RENDER_QUEUE_H

#include "render/rows/visit.h"
#include "render/transport/lanes/suffix_batch.h"

/* A pivot that waits: what is left of lf_pivot and lf_visit when its turn comes. */
typedef struct lf_queued {
    float x, z, lx, forced_weight, alone;
    int medium, view, column;
} lf_queued;

typedef struct lf_queue {
    _Alignas(LF_CACHE_LINE) lf_suffix_batch batch;
    lf_queued item[LF_BATCH_PIVOTS];
} lf_queue;

/* Takes in a pivot in a medium, whose sampler's numbers it draws at once; flushes when it is full.
 */
void lf_queue_push(lf_queue *queue, lf_visit *visit, int view, int column, const lf_pivot *pivot);

/* Draws the suffixes of all that wait and spreads them. */
void lf_queue_flush(lf_queue *queue, lf_visit *visit);

#endif
