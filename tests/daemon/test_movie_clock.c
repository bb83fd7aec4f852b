/* When frames of a video are due, which are late, and what a pause does. */
#include "tests/testing.h"

#include "base/thread.h"
#include "daemon/media/movie_clock.h"

#define START 1000

static lf_movie_clock at(int rate, int per)
{
    lf_movie_clock clock;
    lf_movie_clock_start(&clock, rate, per, START);
    return clock;
}

static void frames_are_due_at_their_numbers_over_the_rate(void **state)
{
    (void)state;
    const lf_movie_clock ntsc = at(30000, 1001);
    assert_int_equal(lf_movie_clock_due(&ntsc, 0), START);
    assert_int_equal(lf_movie_clock_due(&ntsc, 1), START + 33366666);
    /* no error adds up: after 30,000 frames exactly 1001 s have gone by, and after a year, too */
    assert_int_equal(lf_movie_clock_due(&ntsc, 30000), START + 1001 * LF_NS_PER_S);
    assert_int_equal(lf_movie_clock_due(&ntsc, 945000000),
                     START + UINT64_C(31531500) * LF_NS_PER_S);
    const lf_movie_clock slow = at(1, 4);
    assert_int_equal(lf_movie_clock_due(&slow, 3), START + 12 * LF_NS_PER_S);
}

static void a_frame_waits_until_it_is_due(void **state)
{
    (void)state;
    lf_movie_clock clock = at(10, 1);
    const uint64_t due = lf_movie_clock_due(&clock, 1);
    assert_int_equal(lf_movie_clock_judge(&clock, 1, due - 1, NULL), LF_CLOCK_WAIT);
    assert_int_equal(lf_movie_clock_judge(&clock, 1, due, NULL), LF_CLOCK_SHOW);
    /* less than a frame late: shown */
    assert_int_equal(lf_movie_clock_judge(&clock, 2, lf_movie_clock_due(&clock, 3) - 1, NULL),
                     LF_CLOCK_SHOW);
}

/* After a gap the first late frame is shown, and those that follow at once are dropped until one is
 * in time. */
static void late_frames_are_dropped_until_one_is_in_time(void **state)
{
    (void)state;
    lf_movie_clock clock = at(10, 1);
    const uint64_t now = lf_movie_clock_due(&clock, 4) + LF_NS_PER_MS;
    bool moved = true;
    assert_int_equal(lf_movie_clock_judge(&clock, 1, now, &moved), LF_CLOCK_SHOW);
    assert_false(moved);
    assert_int_equal(lf_movie_clock_judge(&clock, 2, now, NULL), LF_CLOCK_DROP);
    assert_int_equal(lf_movie_clock_judge(&clock, 3, now, NULL), LF_CLOCK_DROP);
    assert_int_equal(lf_movie_clock_judge(&clock, 4, now, NULL), LF_CLOCK_SHOW);
    assert_int_equal(lf_movie_clock_judge(&clock, 5, now, NULL), LF_CLOCK_WAIT);
    assert_int_equal(lf_movie_clock_due(&clock, 5), START + LF_NS_PER_S / 2);
}

/* A decoder at half the rate: every frame is late, and every frame is shown. */
static void the_clock_waits_for_a_slow_decoder(void **state)
{
    (void)state;
    lf_movie_clock clock = at(10, 1);
    uint64_t now = START;
    int n_moved = 0;
    for (int k = 1; k < 40; k++) {
        bool moved;
        now += LF_NS_PER_S / 5;
        assert_int_equal(lf_movie_clock_judge(&clock, k, now, &moved), LF_CLOCK_SHOW);
        n_moved += moved;
        assert_true(now - lf_movie_clock_due(&clock, k) <= LF_CLOCK_MOST_LAG_NS);
    }
    assert_true(n_moved > 0);
}

/* A slide every four seconds may be a second late. */
static void less_than_a_frame_of_lag_moves_no_clock(void **state)
{
    (void)state;
    lf_movie_clock clock = at(1, 4);
    bool moved = true;
    assert_int_equal(
        lf_movie_clock_judge(&clock, 1, lf_movie_clock_due(&clock, 1) + LF_NS_PER_S, &moved),
        LF_CLOCK_SHOW);
    assert_false(moved);
    assert_int_equal(lf_movie_clock_due(&clock, 2), START + 8 * LF_NS_PER_S);
}

static void nothing_is_due_while_the_clock_is_stopped(void **state)
{
    (void)state;
    lf_movie_clock clock = at(10, 1);
    const uint64_t due = lf_movie_clock_due(&clock, 1), long_after = due + 60 * LF_NS_PER_S;
    lf_movie_clock_pause(&clock, true, due - 10);
    lf_movie_clock_pause(&clock, true, due + 10); /* twice is once */
    assert_int_equal(lf_movie_clock_judge(&clock, 1, long_after, NULL), LF_CLOCK_WAIT);
    lf_movie_clock_pause(&clock, false, long_after);
    lf_movie_clock_pause(&clock, false, long_after + 5);
    assert_int_equal(lf_movie_clock_judge(&clock, 1, long_after + 9, NULL), LF_CLOCK_WAIT);
    assert_int_equal(lf_movie_clock_judge(&clock, 1, long_after + 10, NULL), LF_CLOCK_SHOW);
}

static void a_late_frame_may_begin_anew(void **state)
{
    (void)state;
    lf_movie_clock clock = at(10, 1);
    const uint64_t due = lf_movie_clock_due(&clock, 5);
    lf_movie_clock_resume(&clock, 5, due - 10); /* it is in time */
    assert_int_equal(lf_movie_clock_due(&clock, 5), due);
    lf_movie_clock_resume(&clock, 5, due + LF_NS_PER_S);
    assert_int_equal(lf_movie_clock_due(&clock, 5), due + LF_NS_PER_S);
    lf_movie_clock_pause(&clock, true, due + 2 * LF_NS_PER_S);
    lf_movie_clock_resume(&clock, 5, due + 9 * LF_NS_PER_S);
    lf_movie_clock_pause(&clock, false, due + 10 * LF_NS_PER_S);
    assert_int_equal(lf_movie_clock_due(&clock, 5), due + 10 * LF_NS_PER_S);
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
        cmocka_unit_test(a_late_frame_may_begin_anew),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
