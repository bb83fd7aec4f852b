#include "tests/testing.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>

#include "base/alloc.h"
#include "base/thread.h"

#define N_ITEMS 20000

typedef struct job {
    atomic_int runs[N_ITEMS];
    atomic_int seen_workers[256];
    int n_threads;
    lf_cancel cancel;
    int cancel_at;
    volatile float least, denormal; /* the smallest normal number, and half of it */
    atomic_int arrived, expected;
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

static job *start(int n_threads, lf_pool **out_pool)
{
    lf_assert_ok(lf_pool_create(n_threads, out_pool), NULL);
    return new_job(n_threads);
}

static void end(lf_pool *pool, job *j)
{
    lf_free(j);
    lf_pool_destroy(pool);
}

static void every_item_runs_exactly_once(void **state)
{
    (void)state;
    for (int n_threads = 1; n_threads <= 8; n_threads++) {
        lf_pool *pool;
        job *j = start(n_threads, &pool);
        assert_int_equal(lf_pool_threads(pool), n_threads);
        for (int round = 1; round <= 5; round++) {
            lf_assert_ok(lf_pool_run(pool, N_ITEMS, mark, j, &j->cancel), NULL);
            for (int i = 0; i < N_ITEMS; i++)
                assert_int_equal(atomic_load(&j->runs[i]), round);
        }
        end(pool, j);
    }
}

static void a_cancelled_run_leaves_items_out_and_says_so(void **state)
{
    (void)state;
    lf_pool *pool;
    job *j = start(4, &pool);
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
    end(pool, j);

    lf_assert_ok(lf_pool_create(1, &pool), NULL);
    j = new_job(1);
    j->cancel_at = 9;
    lf_assert_ok(lf_pool_run(pool, 10, mark, j, &j->cancel), NULL);
    end(pool, j);
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

/* Nobody goes on before all have come: a worker that never works would hang here. */
static void wait_for_all(void *context, int item, int worker)
{
    job *j = context;
    (void)item;
    if (atomic_fetch_add(&j->seen_workers[worker], 1) == 0)
        atomic_fetch_add(&j->arrived, 1);
    while (atomic_load(&j->arrived) < j->expected)
        sched_yield();
}

static void all_threads_join_a_run_that_has_an_item_for_each(void **state)
{
    (void)state;
    lf_pool *pool;
    job *j = start(33, &pool);
    for (int round = 0; round < 5; round++) {
        memset(j->seen_workers, 0, sizeof j->seen_workers);
        atomic_store(&j->arrived, 0);
        atomic_store(&j->expected, 33 - round);
        lf_assert_ok(lf_pool_run(pool, 33 - round, wait_for_all, j, NULL), NULL);
        assert_int_equal(atomic_load(&j->arrived), 33 - round);
    }
    end(pool, j);
}

static long times_slept(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_nvcsw;
}

static void a_run_of_one_item_wakes_nobody(void **state)
{
    (void)state;
    lf_pool *pool;
    job *j = start(9, &pool);
    const long before = times_slept();
    for (int i = 0; i < 1000; i++)
        lf_assert_ok(lf_pool_run(pool, 1, mark, j, NULL), NULL);
    assert_true(times_slept() - before < 100);
    assert_int_equal(atomic_load(&j->seen_workers[0]), 1000);
    end(pool, j);
}

/* Half the smallest normal number is denormal: kept, it is not zero, neither as a result nor as
 * what is read. */
static void look_around(void *context, int item, int worker)
{
    (void)item;
    job *j = context;
    volatile float half = j->least * 0.5f, twice = j->denormal * 2.0f;
    if (half != 0.0f || twice != 0.0f)
        atomic_fetch_add(&j->denormals_kept, 1);
    sigset_t blocked;
    pthread_sigmask(SIG_BLOCK, NULL, &blocked);
    if (worker != 0 && (sigismember(&blocked, SIGTERM) != 1 || sigismember(&blocked, SIGHUP) != 1))
        atomic_fetch_add(&j->signals_open, 1);
    wait_for_all(j, item, worker);
}

static void workers_flush_denormals_and_leave_signals_alone(void **state)
{
    (void)state;
    lf_pool *pool;
    job *j = start(4, &pool);
    j->least = 1.1754944e-38f;
    j->denormal = j->least * 0.5f;
    atomic_store(&j->expected, 4);
    lf_assert_ok(lf_pool_run(pool, 40, look_around, j, NULL), NULL);
#if defined(__SSE__) || defined(__aarch64__)
    assert_int_equal(atomic_load(&j->denormals_kept), 0);
    volatile float half = j->least * 0.5f, twice = j->denormal * 2.0f;
    /* the caller has its own mode back, and the test can see the difference */
    assert_true(half != 0.0f && twice == j->least);
#endif
    assert_int_equal(atomic_load(&j->signals_open), 0);
    for (int i = 0; i < 4; i++)
        assert_true(atomic_load(&j->seen_workers[i]) > 0);
    end(pool, j);
}

static void a_run_does_not_allocate(void **state)
{
    (void)state;
    lf_pool *pool;
    job *j = start(3, &pool);
    uint64_t before = lf_alloc_count();
    for (int i = 0; i < 100; i++)
        lf_assert_ok(lf_pool_run(pool, 10, mark, j, NULL), NULL);
    assert_int_equal(lf_alloc_count(), before);
    end(pool, j);
}

typedef struct seen {
    sigset_t blocked;
    char name[16];
    size_t stack_bytes;
} seen;

static void *see(void *context)
{
    seen *s = context;
    pthread_attr_t attributes;
    pthread_sigmask(SIG_BLOCK, NULL, &s->blocked);
    if (pthread_getattr_np(pthread_self(), &attributes) == 0) {
        pthread_attr_getstacksize(&attributes, &s->stack_bytes);
        pthread_attr_destroy(&attributes);
    }
    /* named by who started it, so perhaps a moment later */
    while (pthread_getname_np(pthread_self(), s->name, sizeof s->name) == 0 &&
           strcmp(s->name, "lf-fifteen-byte") != 0)
        sched_yield();
    return context;
}

static void a_started_thread_has_its_name_its_stack_and_no_signals(void **state)
{
    (void)state;
    pthread_t thread;
    seen s = {0};
    void *returned = NULL;
    sigset_t before, after;
    pthread_sigmask(SIG_BLOCK, NULL, &before);
    lf_assert_ok(lf_thread_start("lf-fifteen-byte", see, &s, &thread), NULL);
    pthread_join(thread, &returned);
    assert_ptr_equal(returned, &s);
    assert_string_equal(s.name, "lf-fifteen-byte");
    assert_in_range(s.stack_bytes, 8u << 20, 9u << 20);
    for (int number = 1; number < 32; number++)
        assert_int_equal(sigismember(&s.blocked, number), number != SIGKILL && number != SIGSTOP);

    /* the caller's own mask is as it was */
    pthread_sigmask(SIG_BLOCK, NULL, &after);
    for (int number = 1; number < 32; number++)
        assert_int_equal(sigismember(&after, number), sigismember(&before, number));
}

typedef struct meeting {
    pthread_mutex_t lock;
    pthread_cond_t cond;
    bool come;
} meeting;

static void *come(void *context)
{
    meeting *m = context;
    pthread_mutex_lock(&m->lock);
    m->come = true;
    pthread_cond_signal(&m->cond);
    pthread_mutex_unlock(&m->lock);
    return NULL;
}

static void a_wait_ends_with_the_signal_or_when_its_time_has_come(void **state)
{
    (void)state;
    meeting m = {.lock = PTHREAD_MUTEX_INITIALIZER};
    lf_assert_ok(lf_cond_init(&m.cond), NULL);
    pthread_mutex_lock(&m.lock);
    assert_false(lf_cond_wait_until(&m.cond, &m.lock, lf_time_now_ns())); /* past already */
    uint64_t end = lf_time_now_ns() + 20 * LF_NS_PER_MS;
    while (lf_cond_wait_until(&m.cond, &m.lock, end))
        continue; /* it may wake for nothing */
    assert_true(lf_time_now_ns() >= end);

    pthread_t thread;
    lf_assert_ok(lf_thread_start("comes", come, &m, &thread), NULL);
    bool in_time = true;
    while (!m.come && in_time)
        in_time = lf_cond_wait_until(&m.cond, &m.lock, lf_time_now_ns() + 600 * LF_NS_PER_S);
    assert_true(in_time);
    pthread_mutex_unlock(&m.lock);
    pthread_join(thread, NULL);
    pthread_cond_destroy(&m.cond);
}

static void both_forms_of_the_time_are_of_one_clock(void **state)
{
    (void)state;
    uint64_t before = lf_time_now_ns();
    double between = lf_time_now();
    uint64_t after = lf_time_now_ns();
    assert_true((double)before / 1e9 <= between + 1e-6);
    assert_true(between <= (double)after / 1e9 + 1e-6);
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
        cmocka_unit_test(all_threads_join_a_run_that_has_an_item_for_each),
        cmocka_unit_test(a_run_of_one_item_wakes_nobody),
        cmocka_unit_test(workers_flush_denormals_and_leave_signals_alone),
        cmocka_unit_test(a_run_does_not_allocate),
        cmocka_unit_test(a_started_thread_has_its_name_its_stack_and_no_signals),
        cmocka_unit_test(a_wait_ends_with_the_signal_or_when_its_time_has_come),
        cmocka_unit_test(both_forms_of_the_time_are_of_one_clock),
        cmocka_unit_test(clocks_run_forward),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
