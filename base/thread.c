#include "base/thread.h"

#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include "base/alloc.h"

#define MAX_THREADS 256
#define STACK_BYTES (8u << 20)
/* Workers that the caller of a run wakes, and each worker that joins it. With 2, a short run wakes
 * few, and 64 are awake after six steps. */
#define FAN 2

typedef struct worker {
    lf_pool *pool;
    int index; /* 1..n_started; 0 is the caller of lf_pool_run */
    pthread_t thread;
} worker;

struct lf_pool {
    /* immutable after create */
    int n_threads;
    int n_started; /* n_threads - 1 once create succeeded */
    bool has_lock, has_wake, has_idle;
    worker *workers;

    pthread_mutex_t lock;
    pthread_cond_t wake; /* signals that a run wants workers, or stop */
    pthread_cond_t idle; /* signals that n_busy became 0 */
    /* under lock */
    int n_wanted; /* workers that may still join the run; 0: there is none */
    int n_busy;   /* workers in the run */
    bool stop;

    /* written under lock before a run is announced, constant during it */
    lf_pool_fn fn;
    void *context;
    const lf_cancel *cancel;
    int64_t n_items;
    /* relaxed, because it only hands out numbers; the lock publishes the items' results */
    atomic_int_fast64_t next;
};

/* ------------------------------------------------------------------- one thread, and waiting -- */

lf_status lf_thread_start(const char *name, void *(*main)(void *), void *context, pthread_t *out)
{
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes) != 0)
        return LF_E_NOMEM;
    pthread_attr_setstacksize(&attributes, STACK_BYTES);
    /* a thread inherits the signal mask */
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    bool started = pthread_create(out, &attributes, main, context) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attributes);
    if (!started)
        return LF_E_NOMEM;
    pthread_setname_np(*out, name);
    return LF_OK;
}

lf_status lf_cond_init(pthread_cond_t *cond)
{
    pthread_condattr_t monotonic;
    if (pthread_condattr_init(&monotonic) != 0)
        return LF_E_NOMEM;
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    bool made = pthread_cond_init(cond, &monotonic) == 0;
    pthread_condattr_destroy(&monotonic);
    return made ? LF_OK : LF_E_NOMEM;
}

bool lf_cond_wait_until(pthread_cond_t *cond, pthread_mutex_t *lock, uint64_t end_ns)
{
    struct timespec end = {.tv_sec = (time_t)(end_ns / LF_NS_PER_S),
                           .tv_nsec = (long)(end_ns % LF_NS_PER_S)};
    return pthread_cond_timedwait(cond, lock, &end) != ETIMEDOUT;
}

/* ------------------------------------------------------------------------------------ a crew -- */

int lf_cpu_count(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return CPU_COUNT(&set);
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 && n < 65536 ? (int)n : 1;
}

/* Flushes denormals, on input and output; returns the previous setting. */
#ifdef __SSE__
static unsigned int flush_denormals(void)
{
    unsigned int before = _mm_getcsr();
    _mm_setcsr(before | 0x8040u);
    return before;
}

static void restore_denormals(unsigned int before)
{
    _mm_setcsr(before);
}
#elif defined(__aarch64__)
static unsigned int flush_denormals(void)
{
    unsigned int before = __builtin_aarch64_get_fpcr();
    __builtin_aarch64_set_fpcr(before | 1u << 24);
    return before;
}

static void restore_denormals(unsigned int before)
{
    __builtin_aarch64_set_fpcr(before);
}
#else
static unsigned int flush_denormals(void)
{
    return 0;
}

static void restore_denormals(unsigned int before)
{
    (void)before;
}
#endif

static void work(lf_pool *pool, int index)
{
    for (;;) {
        if (pool->cancel && atomic_load_explicit(pool->cancel, memory_order_relaxed))
            return;
        int64_t item = atomic_fetch_add_explicit(&pool->next, 1, memory_order_relaxed);
        if (item >= pool->n_items)
            return;
        pool->fn(pool->context, (int)item, index);
    }
}

/* Wakes up to FAN of the workers that a run still wants. */
static void call_some(lf_pool *pool, int n_wanted)
{
    for (int i = 0; i < n_wanted && i < FAN; i++)
        pthread_cond_signal(&pool->wake);
}

static void *worker_main(void *argument)
{
    const worker *self = argument;
    lf_pool *pool = self->pool;
    flush_denormals();
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (!pool->stop && pool->n_wanted == 0)
            pthread_cond_wait(&pool->wake, &pool->lock);
        if (pool->stop)
            break;
        const int n_wanted = --pool->n_wanted;
        pool->n_busy++;
        pthread_mutex_unlock(&pool->lock);
        call_some(pool, n_wanted);
        work(pool, self->index);
        pthread_mutex_lock(&pool->lock);
        pool->n_wanted = 0;
        if (--pool->n_busy == 0)
            pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static lf_status start_workers(lf_pool *pool)
{
    lf_status status = LF_OK;
    while (pool->n_started < pool->n_threads - 1 && status == LF_OK) {
        worker *w = &pool->workers[pool->n_started];
        w->pool = pool;
        w->index = pool->n_started + 1;
        status = lf_thread_start("lf-worker", worker_main, w, &w->thread);
        pool->n_started += status == LF_OK;
    }
    return status;
}

lf_status lf_pool_create(int n_threads, lf_pool **out_pool)
{
    if (n_threads < 0 || n_threads > MAX_THREADS)
        return LF_E_ARG;
    if (n_threads == 0)
        n_threads = lf_cpu_count() < MAX_THREADS ? lf_cpu_count() : MAX_THREADS;
    lf_pool *pool = lf_calloc(1, sizeof *pool);
    if (!pool)
        return LF_E_NOMEM;
    pool->n_threads = n_threads;
    pool->workers = lf_calloc((size_t)n_threads, sizeof *pool->workers);
    pool->has_lock = pthread_mutex_init(&pool->lock, NULL) == 0;
    pool->has_wake = pthread_cond_init(&pool->wake, NULL) == 0;
    pool->has_idle = pthread_cond_init(&pool->idle, NULL) == 0;
    if (!pool->workers || !pool->has_lock || !pool->has_wake || !pool->has_idle ||
        start_workers(pool) != LF_OK) {
        lf_pool_destroy(pool);
        return LF_E_NOMEM;
    }
    *out_pool = pool;
    return LF_OK;
}

void lf_pool_destroy(lf_pool *pool)
{
    if (!pool)
        return;
    if (pool->n_started > 0) {
        pthread_mutex_lock(&pool->lock);
        pool->stop = true;
        pthread_cond_broadcast(&pool->wake);
        pthread_mutex_unlock(&pool->lock);
    }
    for (int i = 0; i < pool->n_started; i++)
        pthread_join(pool->workers[i].thread, NULL);
    if (pool->has_idle)
        pthread_cond_destroy(&pool->idle);
    if (pool->has_wake)
        pthread_cond_destroy(&pool->wake);
    if (pool->has_lock)
        pthread_mutex_destroy(&pool->lock);
    lf_free(pool->workers);
    lf_free(pool);
}

int lf_pool_threads(const lf_pool *pool)
{
    return pool->n_threads;
}

lf_status lf_pool_run(lf_pool *pool, int n_items, lf_pool_fn fn, void *context,
                      const lf_cancel *cancel)
{
    if (n_items <= 0)
        return LF_OK;
    const int n_wanted = n_items - 1 < pool->n_started ? n_items - 1 : pool->n_started;
    pthread_mutex_lock(&pool->lock);
    pool->fn = fn;
    pool->context = context;
    pool->cancel = cancel;
    pool->n_items = n_items;
    atomic_store_explicit(&pool->next, 0, memory_order_relaxed);
    pool->n_wanted = n_wanted;
    pthread_mutex_unlock(&pool->lock);
    call_some(pool, n_wanted);

    unsigned int before = flush_denormals();
    work(pool, 0);
    restore_denormals(before);

    pthread_mutex_lock(&pool->lock);
    pool->n_wanted = 0;
    while (pool->n_busy > 0)
        pthread_cond_wait(&pool->idle, &pool->lock);
    int64_t handed_out = atomic_load_explicit(&pool->next, memory_order_relaxed);
    pthread_mutex_unlock(&pool->lock);
    return handed_out < n_items ? LF_E_CANCELLED : LF_OK;
}

/* ------------------------------------------------------------------------------------ clocks -- */

static double seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

uint64_t lf_time_now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * LF_NS_PER_S + (uint64_t)t.tv_nsec;
}

double lf_time_now(void)
{
    return seconds(CLOCK_MONOTONIC);
}

double lf_time_cpu(void)
{
    return seconds(CLOCK_PROCESS_CPUTIME_ID);
}
