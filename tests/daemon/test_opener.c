/* The lanes of the opener: what waits for what, with devices whose closing takes until the test lets it end. */
#include "tests/testing.h"

#include <poll.h>
#include <semaphore.h>

#include "base/alloc.h"
#include "daemon/opener.h"

enum { WAIT_MS = 60000, MAX_LETTERS = 8 };

typedef struct slow_device {
    lf_device base;
    sem_t *may_end;
} slow_device;

typedef struct desk {
    lf_inbox inbox;
    lf_opener *opener;
    sem_t may_end;
    lf_errand *opened[MAX_LETTERS]; /* in the order of the inbox */
    int n_opened;
} desk;

static void slow_destroy(lf_device *device)
{
    slow_device *slow = (slow_device *)(void *)device;
    sem_wait(slow->may_end);
    lf_free(slow);
}

static const lf_device_ops slow_panel = {.kind = "usb", .destroy = slow_destroy};
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
    for (int i = 0; i < MAX_LETTERS; i++)
        sem_post(&d->may_end);
    lf_opener_destroy(d->opener);
    lf_inbox_finish(&d->inbox, d);
    for (int i = 0; i < d->n_opened; i++)
        lf_errand_destroy(d->opened[i]);
    sem_destroy(&d->may_end);
    free(d);
    return 0;
}

static void take(void *reader, lf_letter *letter)
{
    desk *d = reader;
    assert_true(d->n_opened < MAX_LETTERS);
    d->opened[d->n_opened++] = (lf_errand *)(void *)letter;
}

static lf_errand *make(lf_errand_kind kind, const char *spec)
{
    lf_errand *errand = lf_errand_create(kind);
    assert_non_null(errand);
    errand->letter.open = take;
    snprintf(errand->spec, sizeof errand->spec, "%s", spec);
    return errand;
}

static lf_errand *close_slowly(desk *d, const lf_device_ops *ops)
{
    lf_errand *errand = make(LF_ERRAND_CLOSE, "");
    slow_device *slow = lf_calloc(1, sizeof *slow);
    assert_non_null(slow);
    *slow = (slow_device){{ops}, &d->may_end};
    errand->device = &slow->base;
    return errand;
}

static void await_letters(desk *d, int n)
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
    lf_errand *close = close_slowly(d, &slow_panel);
    lf_opener_queue(d->opener, close);
    lf_opener_queue(d->opener, make(LF_ERRAND_LIST, ""));
    lf_opener_queue(d->opener, make(LF_ERRAND_BUTTONS, "LKG-NOBODY"));
    lf_opener_queue(d->opener, make(LF_ERRAND_OPEN, "none"));
    await_letters(d, 3);
    for (int i = 0; i < 3; i++)
        assert_ptr_not_equal(d->opened[i], close);
    sem_post(&d->may_end);
    await_letters(d, 4);
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
        lf_errand *close = close_slowly(d, pairs[i].ops), *open = make(LF_ERRAND_OPEN, pairs[i].spec);
        lf_opener_queue(d->opener, close);
        lf_opener_queue(d->opener, open);
        assert_false(lf_opener_drain(d->opener, 0));
        sem_post(&d->may_end);
        await_letters(d, 2 * (int)i + 2);
        assert_ptr_equal(d->opened[2 * i], close);
        assert_ptr_equal(d->opened[2 * i + 1], open);
    }
}

static void auto_is_hardware(void **state)
{
    (void)state;
    assert_int_equal(lf_lane_of("auto"), LF_LANE_PANELS);
    assert_int_equal(lf_lane_of("usb:1-1"), LF_LANE_PANELS);
    assert_int_equal(lf_lane_of("sim:/tmp/x,stall=1"), LF_LANE_FILES);
    assert_int_equal(lf_lane_of("none"), LF_LANE_FILES);
    assert_int_equal(lf_lane_of("simulated"), LF_LANE_PANELS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_waits_for_a_panel_but_panels, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_closed_is_closed_before_it_is_opened_again, set_up, tear_down),
        cmocka_unit_test(auto_is_hardware),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
