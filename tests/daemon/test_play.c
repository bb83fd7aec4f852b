/* Playing without a server, by a clock of the test's own (wrap_test_play): which frames are asked
 * for, and when. */
#include "tests/testing.h"

#include "daemon/parts/play.h"
#include "tests/daemon/own_clock.h"

#define NONE (-1)

typedef struct owner {
    sd_event *event;
    lf_play *play;
    int frame; /* asked for last, and not looked at yet */
    bool refuses;
    int64_t generation;
} owner;

static bool on_due(void *context, int frame)
{
    owner *o = context;
    assert_int_equal(o->frame, NONE); /* one at a time */
    o->frame = o->refuses ? NONE : frame;
    return !o->refuses;
}

static int set_up(void **state)
{
    woken_in = -1;
    static const lf_play_events events = {.due = on_due};
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    o->frame = NONE;
    clock_now = 1000;
    assert_true(sd_event_new(&o->event) >= 0);
    lf_assert_ok(lf_play_create(o->event, &events, o, &o->play), NULL);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_play_destroy(o->play);
    sd_event_unref(o->event);
    free(o);
    return 0;
}

/* The frame that was asked for since the last look. */
static int asked(owner *o)
{
    int frame = o->frame;
    o->frame = NONE;
    return frame;
}

static void begin(owner *o, int from, int to, bool once)
{
    lf_play_begin(o->play, &(lf_play_range){.rate = 10, .from = from, .to = to, .once = once});
}

static void load(owner *o)
{
    lf_play_loaded(o->play, ++o->generation, NULL);
}

static void show(owner *o, lf_level level)
{
    lf_play_shown(o->play, o->generation, level);
}

/* Waits for the timer that was set. */
static void wait_for_timer(owner *o)
{
    assert_true(woken_in >= 0);
    clock_now += woken_in;
    woken_in = -1;
    assert_true(sd_event_run(o->event, 0) >= 0);
}

static void frames_come_in_turn_at_the_rate_of_the_clock(void **state)
{
    owner *o = *state;
    begin(o, 3, 5, false);
    static const int expected[] = {3, 4, 5, 3, 4};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        assert_int_equal(asked(o), expected[i]);
        load(o);
        show(o, LF_LEVEL_COARSE);
        assert_int_equal(asked(o), NONE); /* not before its time */
        lf_assert_close(woken_in, 0.1, 0, 1e-5);
        wait_for_timer(o);
    }
}

static void one_frame_is_on_its_way_and_what_has_passed_is_left_out(void **state)
{
    owner *o = *state;
    begin(o, 0, 9, false);
    assert_int_equal(asked(o), 0);
    clock_now += 0.25;
    show(o, LF_LEVEL_CONVERGED); /* of what was there before */
    assert_int_equal(asked(o), NONE);
    load(o);
    clock_now += 0.5;
    show(o, LF_LEVEL_NONE);
    assert_int_equal(asked(o), NONE);
    show(o, LF_LEVEL_COARSE);
    assert_int_equal(asked(o), 7);
    load(o);
    clock_now += 0.5;
    show(o, LF_LEVEL_COMPLETE);
    assert_int_equal(asked(o), 2); /* 12, from the beginning again */
}

static void a_frame_that_is_not_shown_is_given_up(void **state)
{
    owner *o = *state;
    begin(o, 0, 9, true);
    assert_int_equal(asked(o), 0);
    clock_now += 5; /* the loader's; it counts from what is loaded on */
    load(o);
    assert_int_equal(asked(o), NONE);
    lf_assert_close(woken_in, 3, 0, 1e-5);
    lf_play_shown(o->play, o->generation - 1, LF_LEVEL_CONVERGED); /* the one before */
    assert_int_equal(asked(o), NONE);
    wait_for_timer(o);
    assert_int_equal(asked(o), 9);
}

static void the_last_frame_ends_what_is_played_once(void **state)
{
    owner *o = *state;
    begin(o, 0, 2, true);
    assert_int_equal(lf_play_now(o->play)->to, 2);
    assert_int_equal(asked(o), 0);
    load(o);
    clock_now += 60;
    show(o, LF_LEVEL_COARSE);
    assert_int_equal(asked(o), 2);
    assert_null(lf_play_now(o->play));
    load(o);
    clock_now += 60;
    show(o, LF_LEVEL_COARSE);
    assert_int_equal(asked(o), NONE);
}

static void a_frame_that_cannot_be_loaded_ends_it(void **state)
{
    owner *o = *state;
    lf_error err;
    (void)lf_error_set(&err, LF_E_CANCELLED, "scene", "for a later one");
    begin(o, 0, 9, false);
    assert_int_equal(asked(o), 0);
    lf_play_loaded(o->play, 0, &err);
    assert_null(lf_play_now(o->play));
    o->refuses = true;
    begin(o, 0, 9, false);
    assert_null(lf_play_now(o->play));
    clock_now += 60;
    show(o, LF_LEVEL_COARSE);
    assert_int_equal(asked(o), NONE);
}

static void what_is_stopped_goes_on_when_it_begins_anew(void **state)
{
    owner *o = *state;
    begin(o, 0, 9, false);
    assert_int_equal(asked(o), 0);
    lf_play_stop(o->play);
    assert_null(lf_play_now(o->play));
    clock_now += 0.5;
    begin(o, 4, 9, false); /* frame 0 is still on its way */
    assert_int_equal(asked(o), NONE);
    load(o);
    assert_int_equal(asked(o), 4);
    lf_play_stop(o->play);
    load(o);
    clock_now += 60;
    show(o, LF_LEVEL_CONVERGED);
    assert_int_equal(asked(o), NONE);
}

static void a_file_that_is_read_again_has_its_frame_asked_for_again(void **state)
{
    owner *o = *state;
    begin(o, 0, 9, false);
    assert_int_equal(asked(o), 0);
    load(o);
    show(o, LF_LEVEL_COARSE);
    lf_play_again(o->play);
    assert_int_equal(asked(o), 0);
    load(o);
    lf_play_stop(o->play);
    lf_play_again(o->play);
    assert_int_equal(asked(o), NONE);
}

#define play_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        play_test(frames_come_in_turn_at_the_rate_of_the_clock),
        play_test(one_frame_is_on_its_way_and_what_has_passed_is_left_out),
        play_test(a_frame_that_is_not_shown_is_given_up),
        play_test(the_last_frame_ends_what_is_played_once),
        play_test(a_frame_that_cannot_be_loaded_ends_it),
        play_test(what_is_stopped_goes_on_when_it_begins_anew),
        play_test(a_file_that_is_read_again_has_its_frame_asked_for_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
