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
    bool hangs;        /* the work does not see that it is cancelled */
    int n_done, n_cancelled, n_stopped, n_refused;
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
    while (!atomic_load(&o->open) && (o->hangs || !atomic_load(&errand->cancel)) &&
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
    assert_true(errand->status == LF_OK || errand->status == LF_E_CANCELLED ||
                errand->status == LF_E_BUSY);
    o->n_refused += errand->status == LF_E_BUSY;
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

static work *make(office *o, int number, uint64_t client)
{
    work *w = lf_calloc(1, sizeof *w);
    assert_non_null(w);
    *w = (work){.errand = {.client = client, .run = run, .stop = stop, .done = on_done},
                .office = o,
                .number = number};
    return w;
}

/* Of client 0 or 1. */
static work *add_one(office *o, int number)
{
    work *w = make(o, number, (uint64_t)number % 2);
    lf_assert_ok(lf_errands_add(o->errands, &w->errand, NULL), NULL);
    return w;
}

/* Two clients in turn. */
static void add(office *o, int n)
{
    for (int i = 0; i < n; i++)
        (void)add_one(o, i);
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

static void what_hangs_after_its_cancellation_keeps_no_turn(void **state)
{
    office *o = *state;
    o->hangs = true;
    add(o, AT_ONCE);
    const work *first = add_one(o, 2), *second = add_one(o, 4);
    assert_false(first->errand.started);
    lf_errands_end_of(o->errands, 1);
    assert_true(first->errand.started);
    assert_false(second->errand.started);
    lf_errands_end_of(o->errands, 0); /* all */
    assert_true(add_one(o, 1)->errand.started);
    atomic_store(&o->open, true);
    read_until(o, 5);
    assert_int_equal(o->n_cancelled, 4);
    assert_int_equal(o->n_refused, 0);
}

/* Adds errands that are cancelled and hang. */
static void hang(office *o, int n)
{
    for (int i = 0; i < n; i++) {
        work *w = make(o, i, 7);
        lf_assert_ok(lf_errands_add(o->errands, &w->errand, NULL), NULL);
        assert_true(w->errand.started);
        lf_errands_end_of(o->errands, 7);
    }
}

static void more_than_some_that_hang_are_refused(void **state)
{
    office *o = *state;
    lf_error err;
    o->hangs = true;
    hang(o, 4 * AT_ONCE);
    work *w = make(o, 0, 0);
    lf_assert_status(lf_errands_add(o->errands, &w->errand, &err), LF_E_BUSY, &err);
    lf_free(w);
    assert_int_equal(lf_errands_count(o->errands), 4 * AT_ONCE);
    atomic_store(&o->open, true);
    read_until(o, 4 * AT_ONCE);
    assert_true(add_one(o, 0)->errand.started); /* they have ended */
    read_until(o, 4 * AT_ONCE + 1);
}

/* One waits for the last thread, and gets it; the next one would wait for ever. */
static void what_waits_for_what_hangs_is_refused(void **state)
{
    office *o = *state;
    o->hangs = true;
    hang(o, 3 * AT_ONCE - 1);
    for (int i = 0; i < AT_ONCE; i++)
        assert_true(add_one(o, 1)->errand.started);
    const work *first = add_one(o, 0), *second = add_one(o, 0);
    assert_false(first->errand.started);
    lf_errands_end_of(o->errands, 1);
    assert_true(first->errand.started);
    assert_false(second->errand.started);
    read_until(o, 1);
    assert_int_equal(o->n_refused, 1);
    assert_int_equal(lf_errands_count_of(o->errands, 0), 1);
    atomic_store(&o->open, true);
    read_until(o, 4 * AT_ONCE + 1);
    assert_int_equal(o->n_refused, 1);
}

#define errand_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        errand_test(few_run_at_once_and_all_are_done),
        errand_test(those_of_a_client_end_without_the_others),
        errand_test(all_end),
        errand_test(what_is_cancelled_while_it_waits_never_begins),
        errand_test(what_hangs_after_its_cancellation_keeps_no_turn),
        errand_test(more_than_some_that_hang_are_refused),
        errand_test(what_waits_for_what_hangs_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
