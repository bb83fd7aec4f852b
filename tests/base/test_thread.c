#include "tests/testing.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>

#include "base/alloc.h"
#include "base/thread.h"

#define N_ITEMS 20000

typedef struct job {
    atomic_int runs[N_ITEMS];
    atomic_int seen_workers[256];
    int n_threads;
    lf_cancel cancel;
    int cancel_at;
    volatile float denormal;
    atomic_int arrived;
    atomic_int denormals_kept, signals_open;
} job;

static void mark(void *context, int item, int worker)
{
    job *j = context;
    atomic_fetch_add(&j->runs[item], 1);
    if (worker < 0 || worker >= j->n_threads)
        abort();
    atomic_fetch_add(&j->seen_workers[worker], 1);
    if (item == j->cancel_at)
        atomic_store(&j->cancel, 1);
    /* the others must not be through before the wish is there */
    while (j->cancel_at >= 0 && item >= N_ITEMS / 2 && !atomic_load(&j->cancel))
        sched_yield();
}

static job *new_job(int n_threads)
{
    job *j = lf_calloc(1, sizeof *j);
    assert_non_null(j);
    j->n_threads = n_threads;
    j->cancel_at = -1;
    return j;
}

static void every_item_runs_exactly_once(void **state)
{
    (void)state;
    for (int n_threads = 1; n_threads <= 8; n_threads++) {
        lf_pool *pool;
        lf_assert_ok(lf_pool_create(n_threads, &pool), NULL);
        assert_int_equal(lf_pool_threads(pool), n_threads);
        job *j = new_job(n_threads);
        for (int round = 1; round <= 5; round++) {
            lf_assert_ok(lf_pool_run(pool, N_ITEMS, mark, j, &j->cancel), NULL);
            for (int i = 0; i < N_ITEMS; i++)
                assert_int_equal(atomic_load(&j->runs[i]), round);
        }
        lf_free(j);
        lf_pool_destroy(pool);
    }
}

static void a_cancelled_run_leaves_items_out_and_says_so(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(4, &pool), NULL);
    job *j = new_job(4);
    j->cancel_at = 100;
    lf_assert_status(lf_pool_run(pool, N_ITEMS, mark, j, &j->cancel), LF_E_CANCELLED, NULL);
    int last = -1;
    for (int i = 0; i < N_ITEMS; i++) {
        int runs = atomic_load(&j->runs[i]);
        assert_in_range(runs, 0, 1);
        if (runs == 1)
            last = i;
    }
    assert_true(last >= 100);
    assert_true(last < N_ITEMS - 1);
    for (int i = 0; i <= last; i++)
        assert_int_equal(atomic_load(&j->runs[i]), 1); /* handed out in rising order: no holes */

    /* nothing at all with the wish set before; everything when it comes with the last item */
    lf_assert_status(lf_pool_run(pool, 10, mark, j, &j->cancel), LF_E_CANCELLED, NULL);
    assert_int_equal(atomic_load(&j->runs[0]), 1);
    lf_free(j);
    lf_pool_destroy(pool);

    lf_assert_ok(lf_pool_create(1, &pool), NULL);
    j = new_job(1);
    j->cancel_at = 9;
    lf_assert_ok(lf_pool_run(pool, 10, mark, j, &j->cancel), NULL);
    lf_free(j);
    lf_pool_destroy(pool);
}

static void an_empty_run_is_fine(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    lf_assert_ok(lf_pool_run(pool, 0, mark, NULL, NULL), NULL);
    lf_pool_destroy(pool);
    lf_pool_destroy(NULL);
}

static void thread_counts_have_limits_and_a_default(void **state)
{
    (void)state;
    lf_pool *pool = NULL;
    lf_assert_status(lf_pool_create(-1, &pool), LF_E_ARG, NULL);
    lf_assert_status(lf_pool_create(257, &pool), LF_E_ARG, NULL);
    assert_null(pool);
    lf_assert_ok(lf_pool_create(0, &pool), NULL);
    int cpus = lf_cpu_count();
    assert_true(cpus >= 1);
    assert_int_equal(lf_pool_threads(pool), cpus < 256 ? cpus : 256);
    lf_pool_destroy(pool);
}

/* Half the smallest normal number is denormal: kept, it is not zero. */
static void look_around(void *context, int item, int worker)
{
    (void)item;
    job *j = context;
    volatile float half = j->denormal * 0.5f;
    if (half != 0.0f)
        atomic_fetch_add(&j->denormals_kept, 1);
    sigset_t blocked;
    pthread_sigmask(SIG_BLOCK, NULL, &blocked);
    if (worker != 0 && (sigismember(&blocked, SIGTERM) != 1 || sigismember(&blocked, SIGHUP) != 1))
        atomic_fetch_add(&j->signals_open, 1);
    /* nobody goes on before all four have come: a worker that never works would hang here */
    if (atomic_fetch_add(&j->seen_workers[worker], 1) == 0)
        atomic_fetch_add(&j->arrived, 1);
    while (atomic_load(&j->arrived) < 4)
        sched_yield();
}

static void workers_flush_denormals_and_leave_signals_alone(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(4, &pool), NULL);
    job *j = new_job(4);
    j->denormal = 1.1754944e-38f;
    lf_assert_ok(lf_pool_run(pool, 40, look_around, j, NULL), NULL);
#if defined(__SSE__) || defined(__aarch64__)
    assert_int_equal(atomic_load(&j->denormals_kept), 0);
    volatile float half = j->denormal * 0.5f;
    assert_true(half != 0.0f); /* the caller has its own mode back, and the test can see the difference */
#endif
    assert_int_equal(atomic_load(&j->signals_open), 0);
    for (int i = 0; i < 4; i++)
        assert_true(atomic_load(&j->seen_workers[i]) > 0);
    lf_free(j);
    lf_pool_destroy(pool);
}

static void a_run_does_not_allocate(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(3, &pool), NULL);
    job *j = new_job(3);
    uint64_t before = lf_alloc_count();
    for (int i = 0; i < 100; i++)
        lf_assert_ok(lf_pool_run(pool, 10, mark, j, NULL), NULL);
    assert_int_equal(lf_alloc_count(), before);
    lf_free(j);
    lf_pool_destroy(pool);
}

static void clocks_run_forward(void **state)
{
    (void)state;
    double now = lf_time_now(), cpu = lf_time_cpu();
    volatile double sink = 0.0;
    while (lf_time_cpu() - cpu < 0.01)
        sink = sink + 1.0;
    assert_true(lf_time_now() > now);
    assert_true(sink > 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_runs_exactly_once),
        cmocka_unit_test(a_cancelled_run_leaves_items_out_and_says_so),
        cmocka_unit_test(an_empty_run_is_fine),
        cmocka_unit_test(thread_counts_have_limits_and_a_default),
        cmocka_unit_test(workers_flush_denormals_and_leave_signals_alone),
        cmocka_unit_test(a_run_does_not_allocate),
        cmocka_unit_test(clocks_run_forward),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
