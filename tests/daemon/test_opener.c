/* The queues of the opener: what waits for what, with devices whose closing takes until the test
 * lets it end. */
#include "tests/testing.h"

#include <poll.h>
#include <semaphore.h>

#include "base/alloc.h"
#include "daemon/show/opener.h"

enum { WAIT_MS = 60000, MAX_TASKS = 8 };

typedef struct slow_device {
    lf_device base;
    sem_t *may_end;
} slow_device;

typedef struct desk {
    lf_inbox inbox;
    lf_opener *opener;
    sem_t may_end;
    lf_opener_request *opened[MAX_TASKS]; /* in the order of the inbox */
    int n_opened;
} desk;

static void slow_destroy(lf_device *device)
{
    slow_device *slow = (slow_device *)(void *)device;
    sem_wait(slow->may_end);
    lf_free(slow);
}

static const lf_device_ops slow_panel = {
    .kind = "usb", .is_hardware = true, .destroy = slow_destroy};
static const lf_device_ops slow_files = {.kind = "sim", .destroy = slow_destroy};

static int set_up(void **state)
{
    desk *d = calloc(1, sizeof *d);
    assert_non_null(d);
    assert_int_equal(sem_init(&d->may_end, 0, 0), 0);
    lf_assert_ok(lf_inbox_init(&d->inbox), NULL);
    lf_assert_ok(lf_opener_create(&d->inbox, &d->opener), NULL);
    *state = d;
    return 0;
}

static int tear_down(void **state)
{
    desk *d = *state;
    for (int i = 0; i < MAX_TASKS; i++)
        sem_post(&d->may_end);
    lf_opener_destroy(d->opener);
    lf_inbox_finish(&d->inbox, d);
    for (int i = 0; i < d->n_opened; i++)
        lf_opener_request_destroy(d->opened[i]);
    sem_destroy(&d->may_end);
    free(d);
    return 0;
}

static void take(void *reader, lf_task *task)
{
    desk *d = reader;
    assert_true(d->n_opened < MAX_TASKS);
    d->opened[d->n_opened++] = (lf_opener_request *)(void *)task;
}

static lf_opener_request *make(lf_opener_kind kind, const char *spec)
{
    lf_opener_request *request = lf_opener_request_create(kind);
    assert_non_null(request);
    request->task.done = take;
    snprintf(request->spec, sizeof request->spec, "%s", spec);
    return request;
}

static lf_opener_request *close_slowly(desk *d, const lf_device_ops *ops)
{
    lf_opener_request *request = make(LF_OPENER_CLOSE, "");
    slow_device *slow = lf_calloc(1, sizeof *slow);
    assert_non_null(slow);
    *slow = (slow_device){{ops}, &d->may_end};
    request->device = &slow->base;
    return request;
}

static void await_tasks(desk *d, int n)
{
    while (d->n_opened < n) {
        struct pollfd p = {.fd = d->inbox.event_fd, .events = POLLIN};
        assert_int_equal(poll(&p, 1, WAIT_MS), 1);
        lf_inbox_read(&d->inbox, d);
    }
}

static void nothing_waits_for_a_panel_but_panels(void **state)
{
    desk *d = *state;
    lf_opener_request *close = close_slowly(d, &slow_panel);
    lf_opener_submit(d->opener, close);
    lf_opener_submit(d->opener, make(LF_OPENER_LIST, ""));
    lf_opener_submit(d->opener, make(LF_OPENER_BUTTONS, "LKG-NOBODY"));
    lf_opener_submit(d->opener, make(LF_OPENER_OPEN, "none"));
    await_tasks(d, 3);
    for (int i = 0; i < 3; i++)
        assert_ptr_not_equal(d->opened[i], close);
    sem_post(&d->may_end);
    await_tasks(d, 4);
    assert_ptr_equal(d->opened[3], close);
}

static void what_is_closed_is_closed_before_it_is_opened_again(void **state)
{
    desk *d = *state;
    const struct {
        const lf_device_ops *ops;
        const char *spec;
    } pairs[] = {{&slow_panel, "usb:1-99"}, {&slow_files, "none"}};
    for (size_t i = 0; i < 2; i++) {
        lf_opener_request *close = close_slowly(d, pairs[i].ops),
                          *open = make(LF_OPENER_OPEN, pairs[i].spec);
        lf_opener_submit(d->opener, close);
        lf_opener_submit(d->opener, open);
        assert_false(lf_opener_drain(d->opener, 0));
        sem_post(&d->may_end);
        await_tasks(d, 2 * (int)i + 2);
        assert_ptr_equal(d->opened[2 * i], close);
        assert_ptr_equal(d->opened[2 * i + 1], open);
    }
}

static void auto_is_hardware(void **state)
{
    (void)state;
    assert_int_equal(lf_opener_queue_of("auto"), LF_QUEUE_PANELS);
    assert_int_equal(lf_opener_queue_of("usb:1-1"), LF_QUEUE_PANELS);
    assert_int_equal(lf_opener_queue_of("sim:/tmp/x,stall=1"), LF_QUEUE_FILES);
    assert_int_equal(lf_opener_queue_of("none"), LF_QUEUE_FILES);
    assert_int_equal(lf_opener_queue_of("simulated"), LF_QUEUE_PANELS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_waits_for_a_panel_but_panels, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_closed_is_closed_before_it_is_opened_again, set_up,
                                        tear_down),
        cmocka_unit_test(auto_is_hardware),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
