/* Pivots in media that wait until lanes can trace their suffixes together
 * (transport/lanes/suffix_batch.h), instead of one suffix at a time; private to render/rows/. They
 * are spread over the views in the order of arrival, so the film's sums do not depend on the
 * queue's length. */
#ifndef LF_RENDER_QUEUE_H
#define LF_RENDER_QUEUE_H

#include "render/rows/visit.h"
#include "render/transport/lanes/suffix_batch.h"

/* A waiting pivot: the parts of lf_pivot and lf_visit that are needed later. */
typedef struct lf_queued {
    float x, z, lx, forced_weight, alone;
    int medium, view, column;
} lf_queued;

typedef struct lf_queue {
    _Alignas(LF_CACHE_LINE) lf_suffix_batch batch;
    lf_queued item[LF_BATCH_PIVOTS];
} lf_queue;

/* Adds a pivot in a medium and draws its sampler's numbers at once. Flushes a full queue. */
void lf_queue_push(lf_queue *queue, lf_visit *visit, int view, int column, const lf_pivot *pivot);

/* Traces the suffixes of all waiting pivots and spreads them. */
void lf_queue_flush(lf_queue *queue, lf_visit *visit);

#endif
