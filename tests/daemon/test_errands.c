/* Errands: each on a thread of its own, few at once, in their order, whatever is cancelled. */
#include "tests/testing.h"

#include <poll.h>
#include <stdatomic.h>

#include "base/alloc.h"
#include "daemon/threads/errands.h"

enum { AT_ONCE = 2, N = 5 };

typedef struct office office;

typedef struct work {
    lf_errand errand;
    office *office;
    int number;
} work;

struct office {
    lf_inbox inbox;
    lf_errands *errands;
    pthread_t reader;
    atomic_int begun, most, now;
    atomic_bool open;  /* the work goes on */
    atomic_bool first; /* the work of the first errand goes on */
    int n_done, n_cancelled, n_stopped;
};

static lf_status run(lf_errand *errand, lf_error *err)
{
    const work *w = (const work *)(void *)errand;
    office *o = w->office;
    const int now = atomic_fetch_add(&o->now, 1) + 1;
    int most = atomic_load(&o->most);
    while (now > most && !atomic_compare_exchange_weak(&o->most, &most, now)) {
    }
    atomic_fetch_add(&o->begun, 1);
    while (!atomic_load(&o->open) && !atomic_load(&errand->cancel) &&
           !(w->number == 0 && atomic_load(&o->first)))
        sched_yield();
    atomic_fetch_sub(&o->now, 1);
    if (pthread_equal(pthread_self(), o->reader))
        return lf_error_set(err, LF_E_IO, "", "not a thread of its own");
    return atomic_load(&errand->cancel) ? lf_error_set(err, LF_E_CANCELLED, "", "cancelled")
                                        : LF_OK;
}

static void stop(lf_errand *errand)
{
    ((work *)(void *)errand)->office->n_stopped++;
}

static void on_done(void *context, lf_errand *errand)
{
    office *o = context;
    assert_true(errand->status == LF_OK || errand->status == LF_E_CANCELLED);
    o->n_cancelled += errand->status == LF_E_CANCELLED;
    o->n_done++;
    lf_free(errand);
}

static int set_up(void **state)
{
    office *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->reader = pthread_self();
    lf_assert_ok(lf_inbox_init(&o->inbox), NULL);
    lf_assert_ok(lf_errands_create("errand", AT_ONCE, o, &o->inbox, &o->errands), NULL);
    return 0;
}

static int tear_down(void **state)
{
    office *o = *state;
    assert_int_equal(lf_errands_count(o->errands), 0);
    lf_errands_destroy(o->errands);
    lf_inbox_finish(&o->inbox, o);
    free(o);
    return 0;
}

/* Two clients in turn: 0 and 1. */
static void add(office *o, int n)
{
    for (int i = 0; i < n; i++) {
        work *w = lf_calloc(1, sizeof *w);
        assert_non_null(w);
        *w =
            (work){.errand = {.client = (uint64_t)i % 2, .run = run, .stop = stop, .done = on_done},
                   .office = o,
                   .number = i};
        lf_assert_ok(lf_errands_add(o->errands, &w->errand, NULL), NULL);
    }
}

static void read_until(office *o, int n_done)
{
    while (o->n_done < n_done) {
        struct pollfd ready = {o->inbox.event_fd, POLLIN, 0};
        assert_int_equal(poll(&ready, 1, 600000), 1);
        lf_inbox_read(&o->inbox, o);
    }
}

static void await_begun(office *o, int n)
{
    while (atomic_load(&o->begun) < n)
        sched_yield();
}

static void few_run_at_once_and_all_are_done(void **state)
{
    office *o = *state;
    add(o, N);
    assert_int_equal(lf_errands_count(o->errands), N);
    assert_int_equal(lf_errands_count_of(o->errands, 1), 2);
    await_begun(o, AT_ONCE);
    assert_int_equal(o->n_done, 0);
    atomic_store(&o->open, true);
    read_until(o, N);
    assert_int_equal(o->n_cancelled, 0);
    assert_int_equal(atomic_load(&o->begun), N);
    assert_int_equal(atomic_load(&o->most), AT_ONCE);
}

static void those_of_a_client_end_without_the_others(void **state)
{
    office *o = *state;
    add(o, N);
    await_begun(o, AT_ONCE);
    lf_errands_end_of(o->errands, 1); /* 1 runs, 3 waits */
    lf_errands_end_of(o->errands, 1); /* twice is no more */
    assert_int_equal(o->n_done, 0);   /* later */
    read_until(o, 2);
    assert_int_equal(o->n_cancelled, 2);
    assert_true(o->n_stopped >= 1);
    assert_int_equal(lf_errands_count_of(o->errands, 1), 0);
    await_begun(o, AT_ONCE + 1); /* 2 took the place of 1 */
    atomic_store(&o->open, true);
    read_until(o, N);
    assert_int_equal(o->n_cancelled, 2);
    assert_int_equal(atomic_load(&o->begun), N - 1); /* 3 never began */
}

static void all_end(void **state)
{
    office *o = *state;
    add(o, N);
    await_begun(o, AT_ONCE);
    lf_errands_end(o->errands);
    read_until(o, N);
    assert_int_equal(o->n_cancelled, N);
    assert_int_equal(atomic_load(&o->begun), AT_ONCE);
}

/* The first one has ended, which nobody has read yet. */
static void what_is_cancelled_while_it_waits_never_begins(void **state)
{
    office *o = *state;
    struct pollfd ready = {o->inbox.event_fd, POLLIN, 0};
    add(o, N);
    await_begun(o, AT_ONCE);
    atomic_store(&o->first, true);
    assert_int_equal(poll(&ready, 1, 600000), 1);
    lf_errands_end(o->errands);
    read_until(o, N);
    assert_int_equal(o->n_cancelled, N - 1);
    assert_int_equal(atomic_load(&o->begun), AT_ONCE);
}

#define errand_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        errand_test(few_run_at_once_and_all_are_done),
        errand_test(those_of_a_client_end_without_the_others),
        errand_test(all_end),
        errand_test(what_is_cancelled_while_it_waits_never_begins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
