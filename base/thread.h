/* A fixed crew of worker threads that run numbered items. Which worker runs which item is not determined, so items must
 * be independent; everything that items write must belong to the item (a row), never to the worker. */
#ifndef LF_BASE_THREAD_H
#define LF_BASE_THREAD_H

#include <stdatomic.h>

#include "base/status.h"

typedef struct lf_pool lf_pool;

/* Set to nonzero (by any thread, memory order relaxed is enough) to ask for an early end. */
typedef atomic_int lf_cancel;

/* Runs on a worker. worker is in [0, n_threads): an index for per-worker scratch. */
typedef void (*lf_pool_fn)(void *context, int item, int worker);

/* CPUs this process may run on (sched_getaffinity), at least 1. */
int lf_cpu_count(void);

/* n_threads 1..256; 0 = lf_cpu_count(). The calling thread of lf_pool_run works too, as worker 0, so n_threads - 1 threads
 * are started, named "lf-worker", all signals blocked, denormals flushed (FTZ and DAZ on x86, FZ on arm64: Embree wants it;
 * results then do not depend on which thread ran an item: lf_pool_run sets it for the caller while it runs). */
LF_NODISCARD lf_status lf_pool_create(int n_threads, lf_pool **out_pool);
/* Accepts NULL. No run may be in progress. */
void lf_pool_destroy(lf_pool *pool);
int lf_pool_threads(const lf_pool *pool);

/* Runs fn for items 0..n_items-1, each at most once, handed out in rising order; returns when all that were started have
 * ended. With cancel (may be NULL) set, no further item is started. LF_OK, or LF_E_CANCELLED when items were left out.
 * Does not allocate. Thread: one run at a time on a pool. */
LF_NODISCARD lf_status lf_pool_run(lf_pool *pool, int n_items, lf_pool_fn fn, void *context, const lf_cancel *cancel);

/* Monotonic time in seconds, and this process's CPU time in seconds (all threads). */
double lf_time_now(void);
double lf_time_cpu(void);

#endif
