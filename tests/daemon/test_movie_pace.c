/* When frames of a video are due, which are late, and what a pause does. */
#include "tests/testing.h"

#include "base/thread.h"
#include "daemon/media/pace.h"

#define START 1000

static lf_pace at(int rate, int per)
{
    lf_pace pace;
    lf_pace_start(&pace, rate, per, START);
    return pace;
}

static void frames_are_due_at_their_numbers_over_the_rate(void **state)
{
    (void)state;
    const lf_pace ntsc = at(30000, 1001);
    assert_int_equal(lf_pace_due(&ntsc, 0), START);
    assert_int_equal(lf_pace_due(&ntsc, 1), START + 33366666);
    /* no error adds up: after 30,000 frames exactly 1001 s have gone by, and after a year, too */
    assert_int_equal(lf_pace_due(&ntsc, 30000), START + 1001 * LF_NS_PER_S);
    assert_int_equal(lf_pace_due(&ntsc, 945000000), START + UINT64_C(31531500) * LF_NS_PER_S);
    const lf_pace slow = at(1, 4);
    assert_int_equal(lf_pace_due(&slow, 3), START + 12 * LF_NS_PER_S);
}

static void a_frame_waits_until_it_is_due(void **state)
{
    (void)state;
    lf_pace pace = at(10, 1);
    const uint64_t due = lf_pace_due(&pace, 1);
    assert_int_equal(lf_pace_judge(&pace, 1, due - 1, NULL), LF_PACE_WAIT);
    assert_int_equal(lf_pace_judge(&pace, 1, due, NULL), LF_PACE_SHOW);
    /* less than a frame late: shown */
    assert_int_equal(lf_pace_judge(&pace, 2, lf_pace_due(&pace, 3) - 1, NULL), LF_PACE_SHOW);
}

/* After a gap the first late frame is shown, and those that follow at once are dropped until one is
 * in time. */
static void late_frames_are_dropped_until_one_is_in_time(void **state)
{
    (void)state;
    lf_pace pace = at(10, 1);
    const uint64_t now = lf_pace_due(&pace, 4) + LF_NS_PER_MS;
    bool moved = true;
    assert_int_equal(lf_pace_judge(&pace, 1, now, &moved), LF_PACE_SHOW);
    assert_false(moved);
    assert_int_equal(lf_pace_judge(&pace, 2, now, NULL), LF_PACE_DROP);
    assert_int_equal(lf_pace_judge(&pace, 3, now, NULL), LF_PACE_DROP);
    assert_int_equal(lf_pace_judge(&pace, 4, now, NULL), LF_PACE_SHOW);
    assert_int_equal(lf_pace_judge(&pace, 5, now, NULL), LF_PACE_WAIT);
    assert_int_equal(lf_pace_due(&pace, 5), START + LF_NS_PER_S / 2);
}

/* A decoder at half the rate: every frame is late, and every frame is shown. */
static void the_clock_waits_for_a_slow_decoder(void **state)
{
    (void)state;
    lf_pace pace = at(10, 1);
    uint64_t now = START;
    int n_moved = 0;
    for (int k = 1; k < 40; k++) {
        bool moved;
        now += LF_NS_PER_S / 5;
        assert_int_equal(lf_pace_judge(&pace, k, now, &moved), LF_PACE_SHOW);
        n_moved += moved;
        assert_true(now - lf_pace_due(&pace, k) <= LF_PACE_MOST_LAG_NS);
    }
    assert_true(n_moved > 0);
}

/* A slide every four seconds may be a second late. */
static void less_than_a_frame_of_lag_moves_no_clock(void **state)
{
    (void)state;
    lf_pace pace = at(1, 4);
    bool moved = true;
    assert_int_equal(lf_pace_judge(&pace, 1, lf_pace_due(&pace, 1) + LF_NS_PER_S, &moved),
                     LF_PACE_SHOW);
    assert_false(moved);
    assert_int_equal(lf_pace_due(&pace, 2), START + 8 * LF_NS_PER_S);
}

static void nothing_is_due_while_the_clock_is_stopped(void **state)
{
    (void)state;
    lf_pace pace = at(10, 1);
    const uint64_t due = lf_pace_due(&pace, 1), long_after = due + 60 * LF_NS_PER_S;
    lf_pace_pause(&pace, true, due - 10);
    lf_pace_pause(&pace, true, due + 10); /* twice is once */
    assert_int_equal(lf_pace_judge(&pace, 1, long_after, NULL), LF_PACE_WAIT);
    lf_pace_pause(&pace, false, long_after);
    lf_pace_pause(&pace, false, long_after + 5);
    assert_int_equal(lf_pace_judge(&pace, 1, long_after + 9, NULL), LF_PACE_WAIT);
    assert_int_equal(lf_pace_judge(&pace, 1, long_after + 10, NULL), LF_PACE_SHOW);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_due_at_their_numbers_over_the_rate),
        cmocka_unit_test(a_frame_waits_until_it_is_due),
        cmocka_unit_test(late_frames_are_dropped_until_one_is_in_time),
        cmocka_unit_test(the_clock_waits_for_a_slow_decoder),
        cmocka_unit_test(less_than_a_frame_of_lag_moves_no_clock),
        cmocka_unit_test(nothing_is_due_while_the_clock_is_stopped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
