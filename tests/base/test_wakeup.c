#include "tests/testing.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>

#include "base/thread.h"
#include "base/wakeup.h"

static int wakeup;

static int set_up(void **state)
{
    (void)state;
    wakeup = lf_wakeup_make();
    return wakeup >= 0 ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    return close(wakeup);
}

static bool pending(int timeout_ms)
{
    struct pollfd p = {.fd = wakeup, .events = POLLIN};
    return poll(&p, 1, timeout_ms) == 1;
}

static void a_wakeup_is_pending_until_it_is_cleared(void **state)
{
    (void)state;
    assert_false(pending(0));
    lf_wakeup_signal(wakeup);
    assert_true(pending(0));
    assert_true(pending(0));
    lf_wakeup_clear(wakeup);
    assert_false(pending(0));
}

static void many_signals_are_cleared_at_once_and_clearing_twice_waits_for_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < 1000; i++)
        lf_wakeup_signal(wakeup);
    lf_wakeup_clear(wakeup);
    assert_false(pending(0));
    lf_wakeup_clear(wakeup);
    lf_wakeup_signal(wakeup);
    assert_true(pending(0));
}

static void a_wakeup_that_is_full_is_still_pending_and_nobody_waits(void **state)
{
    (void)state;
    uint64_t full = UINT64_MAX - 1;
    assert_int_equal(write(wakeup, &full, sizeof full), sizeof full);
    lf_wakeup_signal(wakeup);
    assert_true(pending(0));
}

static void programs_that_are_started_do_not_inherit_a_wakeup(void **state)
{
    (void)state;
    assert_true((fcntl(wakeup, F_GETFD) & FD_CLOEXEC) != 0);
}

static void *signal_it(void *context)
{
    lf_wakeup_signal(*(const int *)context);
    return NULL;
}

static void another_thread_wakes_a_poll(void **state)
{
    (void)state;
    pthread_t thread;
    lf_assert_ok(lf_thread_start("signaller", signal_it, &wakeup, &thread), NULL);
    assert_true(pending(-1));
    pthread_join(thread, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_wakeup_is_pending_until_it_is_cleared, set_up, tear_down),
        cmocka_unit_test_setup_teardown(
            many_signals_are_cleared_at_once_and_clearing_twice_waits_for_nothing, set_up,
            tear_down),
        cmocka_unit_test_setup_teardown(a_wakeup_that_is_full_is_still_pending_and_nobody_waits,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(programs_that_are_started_do_not_inherit_a_wakeup, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(another_thread_wakes_a_poll, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
