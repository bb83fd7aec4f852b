/* The slideshow without a server, by a clock of the test's own (wrap_test_playlist): which files
 * are asked for, and when. */
#include "tests/daemon/playlist_owner.h"

static void entries_come_in_turn_each_for_its_time(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    assert_string_equal(asked(o), ""); /* until it is played */
    lf_playlist_play(o->list, -1);
    assert_true(is_playing(o));
    for (int i = 0; i < 7; i++) {
        const char name[2] = {(char)('a' + i % 3), '\0'};
        shows(o, name);
        assert_int_equal(index_of(o), i % 3);
        assert_string_equal(asked(o), ""); /* not before its time */
        wait_for(o, 1 + i % 3);
    }
}

/* Each load has a turn of its own, also one that takes the place of another. */
static void turns_count_what_is_to_be_loaded(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    assert_int_equal(lf_playlist_now(o->list).turn, 0);
    lf_playlist_play(o->list, -1);
    assert_int_equal(lf_playlist_now(o->list).turn, 1);
    lf_playlist_step(o->list, 1); /* while the first is loaded */
    assert_int_equal(lf_playlist_now(o->list).turn, 2);
    lf_playlist_pause(o->list, true);
    lf_playlist_play(o->list, 1);
    assert_int_equal(lf_playlist_now(o->list).turn, 3);
    lf_playlist_stop(o->list);
    assert_int_equal(lf_playlist_now(o->list).turn, 3);
}

static void the_time_counts_from_the_first_coarse_frame(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    lf_playlist_play(o->list, -1);
    assert_string_equal(asked(o), "a");
    clock_now += 50;
    load(o);
    clock_now += 50;
    show(o, LF_LEVEL_NONE);
    lf_playlist_shown(o->list, o->generation - 1, LF_LEVEL_CONVERGED); /* what was there before */
    assert_true(timer() < 0);
    show(o, LF_LEVEL_COARSE);
    lf_assert_close(timer(), 1, 0, 1e-5);
    clock_now += 0.5;
    show(o, LF_LEVEL_COMPLETE);                                     /* the same image */
    lf_playlist_shown(o->list, o->generation + 1, LF_LEVEL_COARSE); /* a camera move */
    assert_true(timer() < 0);
}

static void a_frame_that_is_shown_before_the_load_is_told_counts(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    lf_playlist_play(o->list, -1);
    assert_string_equal(asked(o), "a");
    lf_playlist_shown(o->list, o->generation + 1, LF_LEVEL_COARSE);
    assert_true(timer() < 0);
    load(o);
    lf_assert_close(timer(), 1, 0, 1e-5);
}

static void without_loop_the_last_entry_is_the_end(void **state)
{
    owner *o = *state;
    set(o, "ab", false);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    wait_for(o, 1);
    shows(o, "b");
    const int n = o->n_changed;
    wait_for(o, 2);
    assert_false(is_playing(o));
    assert_int_equal(index_of(o), 1);
    assert_int_equal(o->n_changed, n + 1);
    assert_string_equal(asked(o), "");
    lf_playlist_play(o->list, -1); /* from the start */
    assert_string_equal(asked(o), "a");
}

static void a_loop_of_one_entry_is_loaded_once(void **state)
{
    owner *o = *state;
    set(o, "a", true);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    assert_true(timer() < 0);
    assert_true(is_playing(o));
    lf_playlist_step(o->list, 1);
    assert_string_equal(asked(o), "");
    set(o, "ab", true); /* another entry, and it goes on */
    wait_for(o, 1);
    assert_string_equal(asked(o), "b");
}

static void entries_that_fail_are_skipped_with_one_line_each(void **state)
{
    owner *o = *state;
    const int before = count_lines("entry 1 is skipped: file: is damaged");
    set(o, "abc", true);
    lf_playlist_play(o->list, -1);
    for (int i = 0; i < 3; i++) {
        shows(o, "a");
        wait_for(o, 1);
        fails(o, "b");
        shows(o, "c");
        wait_for(o, 3);
    }
    assert_int_equal(count_lines("entry 1 is skipped: file: is damaged"), before + 1);
    shows(o, "a");
    wait_for(o, 1);
    shows(o, "b"); /* mended, and damaged again */
    wait_for(o, 2);
    shows(o, "c");
    wait_for(o, 3);
    shows(o, "a");
    wait_for(o, 1);
    fails(o, "b");
    assert_int_equal(count_lines("entry 1 is skipped: file: is damaged"), before + 2);
}

static void a_last_entry_that_fails_is_the_end(void **state)
{
    owner *o = *state;
    set(o, "ab", false);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    wait_for(o, 1);
    fails(o, "b");
    assert_false(is_playing(o));
    assert_string_equal(asked(o), "");
}

static void a_list_in_which_all_fail_stops_with_a_line(void **state)
{
    owner *o = *state;
    for (int loop = 0; loop < 2; loop++) {
        const int before = count_lines("none of its 3 entries can be shown");
        set(o, "abc", loop);
        lf_playlist_play(o->list, -1);
        fails(o, "a");
        fails(o, "b");
        assert_true(is_playing(o));
        fails(o, "c");
        assert_false(is_playing(o));
        assert_string_equal(asked(o), "");
        assert_int_equal(count_lines("none of its 3 entries can be shown"), before + 1);
    }
}

static void failures_count_only_one_after_another(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, -1);
    for (int i = 0; i < 4; i++) {
        fails(o, "a");
        fails(o, "b");
        if (i == 0) /* afterwards it is on the panel */
            shows(o, "c");
        wait_for(o, 3);
    }
    assert_true(is_playing(o));
}

static void next_and_previous_step_and_wrap_only_in_a_loop(void **state)
{
    owner *o = *state;
    for (int loop = 0; loop < 2; loop++) {
        set(o, "", loop); /* stops */
        set(o, "abc", loop);
        lf_playlist_play(o->list, 0);
        shows(o, "a");
        lf_playlist_step(o->list, 1);
        shows(o, "b");
        lf_playlist_step(o->list, 1);
        shows(o, "c");
        timer();
        lf_playlist_step(o->list, 1);
        if (loop) {
            shows(o, "a");
            lf_playlist_step(o->list, -1);
            shows(o, "c");
        } else {
            assert_string_equal(asked(o), "");
            assert_true(timer() < 0); /* its time goes on */
            assert_int_equal(index_of(o), 2);
        }
        assert_true(is_playing(o));
        lf_playlist_play(o->list, 0);
        shows(o, "a");
        lf_playlist_step(o->list, -1);
        assert_string_equal(asked(o), loop ? "c" : "");
        if (o->on_its_way)
            load(o);
    }
}

static void a_step_back_skips_backwards(void **state)
{
    owner *o = *state;
    set(o, "abc", false);
    lf_playlist_play(o->list, 2);
    shows(o, "c");
    lf_playlist_step(o->list, -1);
    fails(o, "b");
    shows(o, "a");
    wait_for(o, 1); /* and forwards again by the clock */
    assert_string_equal(asked(o), "b");
    load(o);
    lf_playlist_step(o->list, -1);
    show(o, LF_LEVEL_COARSE);
    timer();
    fails(o, "a"); /* nothing is before it, and "b" is on the panel */
    assert_string_equal(asked(o), "");
    assert_int_equal(index_of(o), 1);
    wait_for(o, 2);
    fails(o, "c");
    assert_false(is_playing(o));
}

static void what_is_on_the_panel_is_not_loaded_again(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    for (int i = 0; i < 3; i++) {
        wait_for(o, 1);
        fails(o, "b");
        fails(o, "c");
        assert_string_equal(asked(o), "");
        assert_int_equal(index_of(o), 0);
        assert_true(is_playing(o));
    }
    set(o, "xa", true); /* the same file */
    wait_for(o, 2);
    fails(o, "x");
    assert_string_equal(asked(o), "");
    wait_for(o, 2);
    /* something else may be shown after a stop, and after a load that was not cancelled in time */
    lf_playlist_stop(o->list);
    fail_load(o);
    assert_string_equal(asked(o), "x");
    lf_playlist_play(o->list, 0);
    fails(o, "x");
    shows(o, "a");
    lf_playlist_stop(o->list);
    set(o, "xay", true);
    lf_playlist_play(o->list, 0);
    fails(o, "x");
    shows(o, "a");
    lf_playlist_step(o->list, 1);
    assert_string_equal(asked(o), "y");
    lf_playlist_step(o->list, 1);
    load(o); /* "y" */
    fails(o, "x");
    assert_string_equal(asked(o), "a");
}

/* The entries are long, and each event goes to all who listen. */
static void entries_that_fail_are_told_together(void **state)
{
    owner *o = *state;
    set(o, "abcde", true);
    lf_playlist_play(o->list, -1);
    int n = o->n_changed;
    fails(o, "a");
    fails(o, "b");
    assert_int_equal(o->n_changed, n);
    shows(o, "c");
    assert_int_equal(o->n_changed, n + 1);
    wait_for(o, 3);
    assert_int_equal(o->n_changed, n + 2);
    fails(o, "d");
    fails(o, "e");
    fails(o, "a");
    fails(o, "b"); /* back to "c" */
    assert_int_equal(o->n_changed, n + 3);
    lf_playlist_stop(o->list);
    n = o->n_changed;
    lf_playlist_step(o->list, 1);
    fails(o, "d");
    assert_int_equal(o->n_changed, n + 1); /* of the step */
    lf_playlist_stop(o->list);
    assert_int_equal(o->n_changed, n + 2); /* "e" is the current one */
    lf_playlist_stop(o->list);
    assert_int_equal(o->n_changed, n + 2);
    assert_string_equal(asked(o), "e");
    fail_load(o);
    assert_int_equal(o->n_changed, n + 2);
    set(o, "ab", true);
    lf_playlist_play(o->list, -1);
    n = o->n_changed;
    fails(o, "a");
    fails(o, "b");
    assert_false(is_playing(o));
    assert_int_equal(o->n_changed, n + 1);
}

static void steps_work_while_it_is_stopped(void **state)
{
    owner *o = *state;
    set(o, "abc", false);
    lf_playlist_step(o->list, 1);
    shows(o, "b");
    assert_true(timer() < 0);
    assert_false(is_playing(o));
    lf_playlist_step(o->list, -1);
    shows(o, "a");
    lf_playlist_play(o->list, -1); /* where it is */
    shows(o, "a");
    lf_assert_close(timer(), 1, 0, 1e-5);
}

static void what_is_stopped_stays(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    assert_true(timer() > 0);
    lf_playlist_stop(o->list);
    assert_false(is_playing(o));
    clock_now += 60;
    assert_true(sd_event_run(o->event, 0) >= 0);
    show(o, LF_LEVEL_CONVERGED);
    assert_string_equal(asked(o), "");
    lf_playlist_play(o->list, -1);
    assert_string_equal(asked(o), "a");
    lf_playlist_stop(o->list); /* while it loads */
    assert_int_equal(o->n_vain, 1);
    load(o);
    show(o, LF_LEVEL_COARSE);
    assert_true(timer() < 0);
    assert_string_equal(asked(o), "");
}

static void a_load_that_is_no_longer_wanted_makes_room(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, -1);
    assert_string_equal(asked(o), "a");
    lf_playlist_step(o->list, 1);
    lf_playlist_step(o->list, 1);
    assert_int_equal(o->n_vain, 1);
    assert_string_equal(asked(o), ""); /* one at a time */
    const int lines = count_lines("is skipped");
    fail_load(o); /* "a", cancelled */
    assert_int_equal(count_lines("is skipped"), lines);
    shows(o, "c");
    wait_for(o, 3);
}

static void new_entries_keep_the_file_that_is_shown(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, 1);
    shows(o, "b");
    lf_assert_close(timer(), 2, 0, 1e-5);
    clock_now += 1.5;
    set(o, "xyzb", true); /* it is entry 3 now, for 4 seconds */
    assert_string_equal(asked(o), "");
    assert_int_equal(index_of(o), 3);
    wait_for(o, 2.5);
    shows(o, "x");
    set(o, "uv", true); /* it is gone */
    assert_true(is_playing(o));
    shows(o, "u");
    set(o, "vuu", true); /* the nearest of two */
    assert_int_equal(index_of(o), 1);
    set(o, "", true);
    assert_false(is_playing(o));
    assert_int_equal(lf_playlist_now(o->list).n, 0);
    lf_playlist_play(o->list, -1);
    lf_playlist_step(o->list, 1);
    assert_string_equal(asked(o), "");
}

static void new_entries_while_one_loads(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    lf_playlist_play(o->list, -1);
    assert_string_equal(asked(o), "a");
    set(o, "xa", true); /* still wanted */
    assert_int_equal(o->n_vain, 0);
    load(o);
    assert_int_equal(index_of(o), 1);
    show(o, LF_LEVEL_COARSE);
    wait_for(o, 2);
    assert_string_equal(asked(o), "x");
    set(o, "yz", true);
    assert_int_equal(o->n_vain, 1);
    fail_load(o);
    shows(o, "y");
}

static void what_cannot_be_asked_for_stops_it(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    o->refuses = true;
    lf_playlist_play(o->list, -1);
    assert_false(is_playing(o));
    lf_playlist_play(o->list, 2); /* no such entry */
    assert_false(is_playing(o));
}

static void play_goes_on_or_to_an_entry(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, 1);
    shows(o, "b");
    const int n = o->n_changed;
    lf_playlist_play(o->list, -1);
    assert_string_equal(asked(o), "");
    assert_int_equal(o->n_changed, n);
    lf_playlist_play(o->list, 2);
    assert_string_equal(asked(o), "c");
    assert_int_equal(o->n_changed, n + 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        list_test(entries_come_in_turn_each_for_its_time),
        list_test(turns_count_what_is_to_be_loaded),
        list_test(the_time_counts_from_the_first_coarse_frame),
        list_test(a_frame_that_is_shown_before_the_load_is_told_counts),
        list_test(without_loop_the_last_entry_is_the_end),
        list_test(a_loop_of_one_entry_is_loaded_once),
        list_test(entries_that_fail_are_skipped_with_one_line_each),
        list_test(a_last_entry_that_fails_is_the_end),
        list_test(a_list_in_which_all_fail_stops_with_a_line),
        list_test(failures_count_only_one_after_another),
        list_test(next_and_previous_step_and_wrap_only_in_a_loop),
        list_test(a_step_back_skips_backwards),
        list_test(what_is_on_the_panel_is_not_loaded_again),
        list_test(entries_that_fail_are_told_together),
        list_test(steps_work_while_it_is_stopped),
        list_test(what_is_stopped_stays),
        list_test(a_load_that_is_no_longer_wanted_makes_room),
        list_test(new_entries_keep_the_file_that_is_shown),
        list_test(new_entries_while_one_loads),
        list_test(what_cannot_be_asked_for_stops_it),
        list_test(play_goes_on_or_to_an_entry),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
