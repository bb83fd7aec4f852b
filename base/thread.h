/* Threads: one for a task, waits that have an end, a fixed crew for numbered items; and the clocks.
 */
#ifndef LF_BASE_THREAD_H
#define LF_BASE_THREAD_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>

#include "base/status.h"

/* ------------------------------------------------------------------- one thread, and waiting -- */

/* Starts a thread with all signals blocked (they belong to the event thread) and a stack of 8 MiB,
 * whatever the limits say: readers of meshes and volumes recurse. name: at most 15 bytes. The
 * caller joins it. LF_E_NOMEM, *out is then undefined. */
LF_NODISCARD lf_status lf_thread_start(const char *name, void *(*main)(void *), void *context,
                                       pthread_t *out);

/* A condition that can be waited for with an end; destroyed by pthread_cond_destroy. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_cond_init(pthread_cond_t *cond);
/* As pthread_cond_wait, until end_ns (lf_time_now_ns) at the latest: false when that has come. */
bool lf_cond_wait_until(pthread_cond_t *cond, pthread_mutex_t *lock, uint64_t end_ns);

/* ------------------------------------------------------------------------------------ a crew -- */

/* Worker threads that run numbered items. Which worker runs which item is not determined, so items
 * must be independent; everything that items write must belong to the item (a row), never to the
 * worker. */
typedef struct lf_pool lf_pool;

/* Set to nonzero (by any thread, memory order relaxed is enough) to ask for an early end. */
typedef atomic_int lf_cancel;

/* Runs on a worker. worker is in [0, n_threads): an index for per-worker scratch. */
typedef void (*lf_pool_fn)(void *context, int item, int worker);

/* CPUs this process may run on (sched_getaffinity), at least 1. */
int lf_cpu_count(void);

/* n_threads 1..256; 0 = lf_cpu_count(). The calling thread of lf_pool_run works too, as worker 0,
 * so n_threads - 1 threads are started (lf_thread_start, "lf-worker"), denormals flushed (FTZ and
 * DAZ on x86, FZ on arm64: Embree wants it; results then do not depend on which thread ran an item:
 * lf_pool_run sets it for the caller while it runs). */
LF_NODISCARD lf_status lf_pool_create(int n_threads, lf_pool **out_pool);
/* Accepts NULL. No run may be in progress. */
void lf_pool_destroy(lf_pool *pool);
int lf_pool_threads(const lf_pool *pool);

/* Runs fn for items 0..n_items-1, each at most once, handed out in rising order; returns when all
 * that were started have ended. With cancel (may be NULL) set, no further item is started. LF_OK,
 * or LF_E_CANCELLED when items were left out. Does not allocate. Thread: one run at a time on a
 * pool. */
LF_NODISCARD lf_status lf_pool_run(lf_pool *pool, int n_items, lf_pool_fn fn, void *context,
                                   const lf_cancel *cancel);

/* ------------------------------------------------------------------------------------ clocks -- */

#define LF_NS_PER_S UINT64_C(1000000000)
#define LF_NS_PER_MS UINT64_C(1000000)

/* Monotonic time, in seconds and in nanoseconds, and this process's CPU time in seconds (all
 * threads). */
double lf_time_now(void);
uint64_t lf_time_now_ns(void);
double lf_time_cpu(void);

#endif
