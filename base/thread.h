/* Threads: single threads, waits with a timeout, a pool for numbered items; and clocks. */
#ifndef LF_BASE_THREAD_H
#define LF_BASE_THREAD_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>

#include "base/status.h"

/* ------------------------------------------------------------------- one thread, and waiting -- */

/* Starts a thread with all signals blocked (the event thread handles them) and a stack of 8 MiB,
 * whatever the system's limit, because readers of meshes and volumes recurse. name: at most 15
 * bytes. The caller joins it. LF_E_NOMEM; *out is then undefined. */
LF_NODISCARD lf_status lf_thread_start(const char *name, void *(*main)(void *), void *context,
                                       pthread_t *out);

/* Makes a condition for lf_cond_wait_until; destroy it with pthread_cond_destroy. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_cond_init(pthread_cond_t *cond);
/* Like pthread_cond_wait, at most until end_ns (lf_time_now_ns); false: this time has come. */
bool lf_cond_wait_until(pthread_cond_t *cond, pthread_mutex_t *lock, uint64_t end_ns);

/* ------------------------------------------------------------------------------------ a crew -- */

/* Worker threads that run numbered items. Which worker runs an item is not determined, so items
 * must be independent. Data that items write must belong to the item (a row), never to the
 * worker. */
typedef struct lf_pool lf_pool;

/* Set to nonzero (by any thread; relaxed memory order is enough) to request an early end. */
typedef atomic_int lf_cancel;

/* Runs on a worker. worker is in [0, n_threads): an index for per-worker scratch. */
typedef void (*lf_pool_fn)(void *context, int item, int worker);

/* CPUs this process may run on (sched_getaffinity), at least 1. */
int lf_cpu_count(void);

/* n_threads 1..256; 0 = lf_cpu_count(). The caller of lf_pool_run also works, as worker 0, so
 * n_threads - 1 threads are started (lf_thread_start, "lf-worker"). They flush denormals (FTZ and
 * DAZ on x86, FZ on arm64), which Embree recommends; lf_pool_run sets this for the caller while it
 * runs. Results therefore do not depend on the thread that runs an item. */
LF_NODISCARD lf_status lf_pool_create(int n_threads, lf_pool **out_pool);
/* Accepts NULL. No run may be in progress. */
void lf_pool_destroy(lf_pool *pool);
int lf_pool_threads(const lf_pool *pool);

/* Runs fn for items 0..n_items-1, each at most once, started in rising order. Returns when all
 * started items have ended. Once cancel (may be NULL) is set, no further item starts. LF_OK, or
 * LF_E_CANCELLED if items were skipped. Does not allocate. Thread: one run at a time per pool.
 *
 * Threads wake each other, two by two, while items are left. So a run with few or short items wakes
 * few of them, and one item runs on the caller alone. */
LF_NODISCARD lf_status lf_pool_run(lf_pool *pool, int n_items, lf_pool_fn fn, void *context,
                                   const lf_cancel *cancel);

/* ------------------------------------------------------------------------------------ clocks -- */

#define LF_NS_PER_S UINT64_C(1000000000)
#define LF_NS_PER_MS UINT64_C(1000000)

/* Monotonic time in seconds and in nanoseconds, and the CPU time of all threads of this process in
 * seconds. */
double lf_time_now(void);
uint64_t lf_time_now_ns(void);
double lf_time_cpu(void);

#endif
