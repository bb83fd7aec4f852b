#include "tests/testing.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>

#include "base/bell.h"
#include "base/thread.h"

static bool rings(int bell, int timeout_ms)
{
    struct pollfd p = {.fd = bell, .events = POLLIN};
    return poll(&p, 1, timeout_ms) == 1;
}

static void a_bell_rings_until_it_is_silenced(void **state)
{
    (void)state;
    int bell = lf_bell_make();
    assert_true(bell >= 0);
    assert_false(rings(bell, 0));
    lf_bell_ring(bell);
    assert_true(rings(bell, 0));
    assert_true(rings(bell, 0));
    lf_bell_silence(bell);
    assert_false(rings(bell, 0));
    close(bell);
}

static void many_rings_are_silenced_at_once_and_silence_twice_waits_for_nothing(void **state)
{
    (void)state;
    int bell = lf_bell_make();
    for (int i = 0; i < 1000; i++)
        lf_bell_ring(bell);
    lf_bell_silence(bell);
    assert_false(rings(bell, 0));
    lf_bell_silence(bell);
    lf_bell_ring(bell);
    assert_true(rings(bell, 0));
    close(bell);
}

static void a_bell_that_is_full_still_rings_and_nobody_waits(void **state)
{
    (void)state;
    int bell = lf_bell_make();
    uint64_t full = UINT64_MAX - 1;
    assert_int_equal(write(bell, &full, sizeof full), sizeof full);
    lf_bell_ring(bell);
    assert_true(rings(bell, 0));
    close(bell);
}

static void programs_that_are_started_do_not_inherit_a_bell(void **state)
{
    (void)state;
    int bell = lf_bell_make();
    assert_true((fcntl(bell, F_GETFD) & FD_CLOEXEC) != 0);
    close(bell);
}

static void *ring_it(void *context)
{
    lf_bell_ring(*(const int *)context);
    return NULL;
}

static void another_thread_wakes_a_poll(void **state)
{
    (void)state;
    int bell = lf_bell_make();
    pthread_t thread;
    lf_assert_ok(lf_thread_start("ringer", ring_it, &bell, &thread), NULL);
    assert_true(rings(bell, -1));
    pthread_join(thread, NULL);
    close(bell);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bell_rings_until_it_is_silenced),
        cmocka_unit_test(many_rings_are_silenced_at_once_and_silence_twice_waits_for_nothing),
        cmocka_unit_test(a_bell_that_is_full_still_rings_and_nobody_waits),
        cmocka_unit_test(programs_that_are_started_do_not_inherit_a_bell),
        cmocka_unit_test(another_thread_wakes_a_poll),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
