/* The worker: tasks are done in order on a thread of its own and come back through the inbox,
 * whatever happens. */
#include "tests/testing.h"

#include <poll.h>
#include <stdatomic.h>

#include "base/thread.h"
#include "daemon/threads/worker.h"

enum { N_TASKS = 20 };

typedef struct work {
    lf_task task; /* first */
    int number;
    bool done, dropped, opened;
} work;

typedef struct office {
    lf_inbox inbox;
    lf_worker *worker;
    work works[N_TASKS];
    int n_opened;
    int opened[N_TASKS];
    pthread_t reader;
    bool same_thread; /* an work was done by the reader's thread */
    atomic_bool shut; /* works wait until it is open */
    atomic_bool ending;
    pid_t ender; /* the thread that ends the worker */
    atomic_int begun;
} office;

static work *work_of(lf_task *task)
{
    return (work *)(void *)task;
}

static void run(void *context, lf_task *task)
{
    office *o = context;
    atomic_fetch_add(&o->begun, 1);
    o->same_thread = o->same_thread || pthread_equal(pthread_self(), o->reader);
    while (atomic_load(&o->shut))
        sched_yield();
    work_of(task)->done = true;
}

static void drop(void *context, lf_task *task)
{
    (void)context;
    work_of(task)->dropped = true;
}

static void opened(void *reader, lf_task *task)
{
    office *o = reader;
    work_of(task)->opened = true;
    o->opened[o->n_opened++] = work_of(task)->number;
}

static office *open_office(void)
{
    office *o = calloc(1, sizeof *o);
    assert_non_null(o);
    o->reader = pthread_self();
    lf_assert_ok(lf_inbox_init(&o->inbox), NULL);
    lf_assert_ok(lf_worker_create("lf-test", run, drop, o, &o->inbox, &o->worker), NULL);
    for (int i = 0; i < N_TASKS; i++)
        o->works[i] = (work){.task.done = opened, .number = i};
    return o;
}

static void close_office(office *o)
{
    lf_worker_destroy(o->worker);
    lf_inbox_finish(&o->inbox, o);
    free(o);
}

/* Reads until so many tasks were opened. */
static void read_until(office *o, int n)
{
    struct pollfd p = {.fd = o->inbox.event_fd, .events = POLLIN};
    while (o->n_opened < n) {
        assert_int_equal(poll(&p, 1, 60000), 1);
        lf_inbox_read(&o->inbox, o);
    }
}

static void letters_are_done_elsewhere_and_come_back_in_order(void **state)
{
    (void)state;
    office *o = open_office();
    for (int i = 0; i < N_TASKS; i++)
        lf_worker_queue(o->worker, &o->works[i].task);
    read_until(o, N_TASKS);
    for (int i = 0; i < N_TASKS; i++) {
        assert_int_equal(o->opened[i], i);
        assert_true(o->works[i].done);
        assert_false(o->works[i].dropped);
    }
    assert_false(o->same_thread);
    assert_int_equal(lf_worker_pending(o->worker), 0);
    close_office(o);
}

static void a_letter_may_be_queued_again_once_it_has_come_back(void **state)
{
    (void)state;
    office *o = open_office();
    for (int i = 0; i < 5; i++) {
        lf_worker_queue(o->worker, &o->works[0].task);
        read_until(o, i + 1);
    }
    assert_int_equal(atomic_load(&o->begun), 5);
    close_office(o);
}

static void what_is_pending_counts_the_one_under_way(void **state)
{
    (void)state;
    office *o = open_office();
    atomic_store(&o->shut, true);
    for (int i = 0; i < 3; i++)
        lf_worker_queue(o->worker, &o->works[i].task);
    while (atomic_load(&o->begun) == 0)
        sched_yield();
    assert_int_equal(lf_worker_pending(o->worker), 3);
    assert_false(lf_worker_drain(o->worker, lf_time_now() + 0.02));
    assert_false(lf_worker_drain(o->worker, lf_time_now() - 1)); /* past already */
    atomic_store(&o->shut, false);
    assert_true(lf_worker_drain(o->worker, lf_time_now() + 600));
    assert_int_equal(lf_worker_pending(o->worker), 0);
    assert_true(lf_worker_drain(o->worker, lf_time_now() - 1)); /* there is nothing to wait for */
    read_until(o, 3);
    close_office(o);
}

static bool is_asleep(pid_t thread)
{
    char path[64], name[32], state = 0;
    snprintf(path, sizeof path, "/proc/self/task/%d/stat", thread);
    FILE *file = fopen(path, "re");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%*d %31s %c", name, &state), 2);
    fclose(file);
    return state == 'S';
}

/* Opens the gate when the end has been asked for: whoever asked sleeps then, waiting for the
 * worker's thread. */
static void *open_at_the_end(void *context)
{
    office *o = context;
    while (!atomic_load(&o->ending) || !is_asleep(o->ender))
        sched_yield();
    atomic_store(&o->shut, false);
    return NULL;
}

static void at_the_end_the_one_under_way_is_done_and_the_others_are_dropped(void **state)
{
    (void)state;
    office *o = open_office();
    pthread_t opener;
    o->ender = gettid();
    atomic_store(&o->shut, true);
    for (int i = 0; i < 3; i++)
        lf_worker_queue(o->worker, &o->works[i].task);
    while (atomic_load(&o->begun) == 0)
        sched_yield();
    lf_assert_ok(lf_thread_start("opener", open_at_the_end, o, &opener), NULL);
    atomic_store(&o->ending, true);
    lf_worker_destroy(o->worker);
    o->worker = NULL;
    pthread_join(opener, NULL);
    assert_true(o->works[0].done && !o->works[0].dropped);
    assert_true(!o->works[1].done && o->works[1].dropped);
    assert_true(!o->works[2].done && o->works[2].dropped);
    /* and all of them come back */
    assert_int_equal(o->n_opened, 0);
    lf_inbox_read(&o->inbox, o);
    assert_int_equal(o->n_opened, 3);
    for (int i = 0; i < 3; i++)
        assert_int_equal(o->opened[i], i);
    close_office(o);
}

/* Of an inbox that is read in turns: all of them, in order, and its descriptor tells of the rest.
 */
static void an_inbox_is_read_in_turns(void **state)
{
    (void)state;
    office o = {0};
    assert_int_equal(lf_inbox_init(&o.inbox), LF_OK);
    struct pollfd ready = {.fd = o.inbox.event_fd, .events = POLLIN};
    for (int i = 0; i < N_TASKS; i++) {
        o.works[i] = (work){.task = {.done = opened}, .number = i};
        lf_inbox_post(&o.inbox, &o.works[i].task);
    }
    for (int turn = 1; turn <= 3; turn++) {
        assert_int_equal(poll(&ready, 1, 0), 1);
        lf_inbox_read_some(&o.inbox, &o, 6);
        assert_int_equal(o.n_opened, 6 * turn);
    }
    assert_int_equal(poll(&ready, 1, 0), 1);
    lf_inbox_read_some(&o.inbox, &o, 6);
    assert_int_equal(o.n_opened, N_TASKS);
    assert_int_equal(poll(&ready, 1, 0), 0);
    for (int i = 0; i < N_TASKS; i++)
        assert_int_equal(o.opened[i], i);
    /* and one that was read to its end takes more */
    lf_inbox_post(&o.inbox, &o.works[0].task);
    o.n_opened = 0;
    lf_inbox_finish(&o.inbox, &o);
    assert_int_equal(o.n_opened, 1);
}

static void no_worker_is_nothing_to_destroy(void **state)
{
    (void)state;
    lf_worker_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(letters_are_done_elsewhere_and_come_back_in_order),
        cmocka_unit_test(a_letter_may_be_queued_again_once_it_has_come_back),
        cmocka_unit_test(what_is_pending_counts_the_one_under_way),
        cmocka_unit_test(at_the_end_the_one_under_way_is_done_and_the_others_are_dropped),
        cmocka_unit_test(an_inbox_is_read_in_turns),
        cmocka_unit_test(no_worker_is_nothing_to_destroy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
