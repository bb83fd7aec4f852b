/* From the event thread to a device's own and back, with the test as both. */
#include "tests/testing.h"

#include <poll.h>

#include "device/handover.h"

enum { WIDTH = 8, HEIGHT = 4 };

static const lf_rect whole = {0, 0, WIDTH, HEIGHT}, part = {2, 1, 3, 2};

static lf_status push(lf_handover *h, const lf_rect *r)
{
    static uint8_t pixels[HEIGHT][WIDTH * 3];
    const lf_image8 frame = {WIDTH, HEIGHT, 3, sizeof pixels[0], pixels[0]};
    memset(pixels, 7, sizeof pixels);
    return lf_handover_push(&h->base, &frame, r, !!r, 1);
}

static bool rings(int fd)
{
    struct pollfd p = {.fd = fd, .events = POLLIN};
    return poll(&p, 1, 0) == 1;
}

static void push_goes_there_and_its_end_comes_back(void **state)
{
    (void)state;
    lf_handover h = {0};
    lf_assert_ok(lf_handover_init(&h, WIDTH, HEIGHT, NULL), NULL);
    lf_device_counters counters;
    assert_int_equal(lf_handover_take(&h), LF_HANDOVER_NOTHING);
    lf_assert_ok(push(&h, &part), NULL);
    assert_true(rings(h.wake_fd));
    assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_BUSY);
    lf_assert_status(push(&h, &part), LF_E_STATE, NULL);
    lf_assert_status(lf_handover_flush(&h.base, 1), LF_E_TIMEOUT, NULL);
    assert_int_equal(lf_handover_take(&h), LF_HANDOVER_PUSH);
    assert_int_equal(lf_handover_take(&h), LF_HANDOVER_NOTHING);
    assert_false(rings(h.wake_fd));
    assert_int_equal(h.n_rects, 1);
    assert_memory_equal(h.rects, &part, sizeof part);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            assert_int_equal(h.picture.data[(size_t)y * h.picture.stride + (size_t)x * 3],
                             x >= 2 && x < 5 && y >= 1 && y < 3 ? 7 : 0);
    assert_false(rings(h.tell_fd));
    lf_handover_end(&h, true, 24);
    assert_true(rings(h.tell_fd));
    lf_assert_ok(lf_handover_flush(&h.base, 0), NULL);
    assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_READY);
    assert_false(rings(h.tell_fd));
    lf_handover_counters(&h.base, &counters);
    assert_int_equal(counters.updates, 1);
    assert_int_equal(counters.bytes, 24);
    lf_handover_finish(&h);
    lf_handover_finish(&h);
}

static void failed_push_is_told_once_and_holds_the_next(void **state)
{
    (void)state;
    lf_handover h = {0};
    lf_assert_ok(lf_handover_init(&h, WIDTH, HEIGHT, NULL), NULL);
    lf_device_counters counters;
    lf_assert_ok(push(&h, NULL), NULL);
    assert_int_equal(lf_handover_take(&h), LF_HANDOVER_PUSH);
    lf_handover_end(&h, false, 99);
    lf_assert_status(push(&h, &whole), LF_E_STATE, NULL);
    assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_RETRY);
    assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_READY);
    lf_assert_ok(push(&h, &whole), NULL);
    lf_handover_counters(&h.base, &counters);
    assert_int_equal(counters.errors, 1);
    assert_int_equal(counters.bytes, 0);
    lf_handover_finish(&h);
}

static void lost_picture_is_told_unless_a_push_is_under_way(void **state)
{
    (void)state;
    lf_handover h = {0};
    lf_assert_ok(lf_handover_init(&h, WIDTH, HEIGHT, NULL), NULL);
    assert_true(lf_handover_lost(&h));
    assert_true(rings(h.tell_fd));
    assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_RETRY);
    lf_assert_ok(push(&h, &part), NULL);
    assert_false(lf_handover_lost(&h));
    assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_BUSY);
    lf_handover_finish(&h);
}

static void what_is_gone_stays_gone(void **state)
{
    (void)state;
    lf_handover h = {0};
    lf_assert_ok(lf_handover_init(&h, WIDTH, HEIGHT, NULL), NULL);
    char problem[256];
    lf_assert_ok(push(&h, &whole), NULL);
    lf_handover_gone(&h);
    assert_true(rings(h.tell_fd));
    lf_assert_status(lf_handover_flush(&h.base, 1000), LF_E_NODEV, NULL);
    for (int i = 0; i < 2; i++)
        assert_int_equal(lf_handover_dispatch(&h.base), LF_DEVICE_GONE);
    lf_assert_status(push(&h, &whole), LF_E_NODEV, NULL);
    lf_handover_problem_set(&h, "bad\n\x1bthing");
    lf_handover_problem(&h, problem);
    assert_string_equal(problem, "bad??thing");
    lf_handover_finish(&h);
}

static void *serve(void *argument)
{
    lf_handover *h = argument;
    struct pollfd p = {.fd = h->wake_fd, .events = POLLIN};
    for (;;) {
        poll(&p, 1, -1);
        lf_handover_word word = lf_handover_take(h);
        if (word == LF_HANDOVER_STOP)
            return NULL;
        if (word == LF_HANDOVER_PUSH)
            lf_handover_end(h, true, 1);
    }
}

static void stopping_waits_for_the_push_under_way(void **state)
{
    (void)state;
    lf_handover h = {0};
    lf_assert_ok(lf_handover_init(&h, WIDTH, HEIGHT, NULL), NULL);
    lf_device_counters counters;
    lf_assert_ok(lf_handover_start(&h, serve, &h, "lf-test", NULL), NULL);
    for (int i = 0; i < 1000; i++) {
        lf_assert_ok(push(&h, &whole), NULL);
        if (i < 999)
            lf_assert_ok(lf_handover_flush(&h.base, 20000), NULL);
    }
    lf_handover_stop(&h);
    lf_handover_counters(&h.base, &counters);
    assert_int_equal(counters.updates, 1000);
    lf_handover_stop(&h);
    lf_handover_finish(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(push_goes_there_and_its_end_comes_back),
        cmocka_unit_test(failed_push_is_told_once_and_holds_the_next),
        cmocka_unit_test(lost_picture_is_told_unless_a_push_is_under_way),
        cmocka_unit_test(what_is_gone_stays_gone),
        cmocka_unit_test(stopping_waits_for_the_push_under_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
