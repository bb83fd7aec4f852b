/* Videos, pauses and changes of a slideshow without a server, by a clock of the test's own
 * (wrap_test_playlist_media). */
#include "tests/daemon/playlist_owner.h"

/* The file that was asked for is a video, and is shown. */
static void shows_video(owner *o, const char *file, bool once)
{
    assert_string_equal(asked(o), file);
    assert_int_equal(o->once, once);
    o->on_its_way = false;
    lf_playlist_loaded(o->list, ++o->generation, true, NULL);
    show(o, LF_LEVEL_CONVERGED);
}

/* The video on the panel has played through. */
static void play_through(owner *o)
{
    lf_playlist_played(o->list, o->generation, NULL);
}

static void fail_video(owner *o)
{
    lf_error err;
    (void)lf_error_set(&err, LF_E_FORMAT, "video", "changes its size");
    lf_playlist_played(o->list, o->generation, &err);
}

/* Entries that have no time of their own. */
static void set_timeless(owner *o, const char *files, bool loop)
{
    const int n = (int)strlen(files);
    const lf_playlist_how how = {.seconds = 30, .loop = loop};
    lf_playlist_entry *entries = lf_calloc((size_t)n + 1, sizeof *entries);
    assert_non_null(entries);
    for (int i = 0; i < n; i++) {
        const char name[2] = {files[i], '\0'};
        entries[i].file = lf_strdup(name);
    }
    lf_playlist_set(o->list, entries, n, &how);
}

static void without_a_time_a_video_plays_through_and_others_have_the_lists(void **state)
{
    owner *o = *state;
    set_timeless(o, "avb", true);
    lf_playlist_play(o->list, -1);
    for (int i = 0; i < 2; i++) {
        shows(o, "a");
        wait_for(o, 30);
        shows_video(o, "v", true);
        assert_true(timer() < 0);
        clock_now += 1000;
        play_through(o);
        shows(o, "b");
        play_through(o); /* the panel shows no video any more */
        assert_string_equal(asked(o), "");
        wait_for(o, 30);
    }
}

static void a_video_with_a_time_is_shown_for_it(void **state)
{
    owner *o = *state;
    set(o, "vb", true);
    lf_playlist_play(o->list, -1);
    shows_video(o, "v", false);
    play_through(o); /* and goes on */
    assert_string_equal(asked(o), "");
    wait_for(o, 1);
    assert_string_equal(asked(o), "b");
}

static void a_video_alone_loops_and_the_last_one_stays(void **state)
{
    owner *o = *state;
    set_timeless(o, "v", true);
    lf_playlist_play(o->list, -1);
    shows_video(o, "v", false);
    play_through(o);
    assert_string_equal(asked(o), "");
    assert_true(is_playing(o));
    set_timeless(o, "vw", false);
    play_through(o);
    shows_video(o, "w", true);
    play_through(o);
    assert_false(is_playing(o));
    assert_int_equal(index_of(o), 1);
}

static bool is_once(const owner *o)
{
    return lf_playlist_now(o->list).once;
}

/* Whether a video loops follows from the list as it is, not as it was when the video was loaded. */
static void a_video_loops_as_soon_as_nothing_follows_it(void **state)
{
    owner *o = *state;
    set_timeless(o, "vb", true);
    assert_false(is_once(o));
    lf_playlist_play(o->list, -1);
    assert_true(lf_playlist_now(o->list).waits);
    shows_video(o, "v", true);
    assert_true(is_once(o) && !lf_playlist_now(o->list).waits);
    set_timeless(o, "v", true);
    assert_false(is_once(o));
    set_timeless(o, "bv", true);
    assert_true(is_once(o));
    lf_playlist_change(o->list, 1, 8, NULL); /* a time of its own */
    assert_false(is_once(o));
    lf_playlist_change(o->list, 1, 0, NULL);
    assert_true(is_once(o));
    lf_playlist_stop(o->list);
    assert_false(is_once(o));
    assert_string_equal(asked(o), "");
}

/* Its last frame stays, until something else is wanted. */
static void the_last_video_of_a_list_that_has_ended_holds(void **state)
{
    owner *o = *state;
    set_timeless(o, "v", false);
    lf_playlist_play(o->list, -1);
    shows_video(o, "v", true);
    play_through(o);
    assert_false(is_playing(o));
    assert_true(is_once(o));
    lf_playlist_stop(o->list);
    assert_false(is_once(o));
}

/* Such as a GIF that does not move: it has the list's seconds, from when it was shown. */
static void a_video_of_one_frame_is_shown_as_a_picture(void **state)
{
    owner *o = *state;
    set_timeless(o, "gb", true);
    lf_playlist_play(o->list, -1);
    shows_video(o, "g", true);
    assert_true(timer() < 0);
    clock_now += 1;
    lf_playlist_still(o->list, o->generation - 1); /* the one before */
    play_through(o);
    shows(o, "b");
    wait_for(o, 30);
    shows_video(o, "g", true);
    clock_now += 1;
    for (int i = 0; i < 2; i++) {
        lf_playlist_still(o->list, o->generation);
        play_through(o);
        assert_string_equal(asked(o), "");
    }
    wait_for(o, 29);
    assert_string_equal(asked(o), "b");
}

static void what_a_video_before_did_does_not_count(void **state)
{
    owner *o = *state;
    set_timeless(o, "vwx", true);
    lf_playlist_play(o->list, -1);
    shows_video(o, "v", true);
    lf_playlist_played(o->list, o->generation - 1, NULL);
    assert_string_equal(asked(o), "");
    lf_playlist_step(o->list, 1);
    play_through(o); /* while the next one loads */
    shows_video(o, "w", true);
    assert_int_equal(index_of(o), 1);
    lf_playlist_stop(o->list);
    play_through(o);
    assert_string_equal(asked(o), "");
}

static void videos_that_fail_are_skipped(void **state)
{
    owner *o = *state;
    const int skipped = count_lines("is skipped: video: changes its size"),
              none = count_lines("none of its 2 entries can be shown");
    set_timeless(o, "vb", true);
    lf_playlist_play(o->list, -1);
    for (int i = 0; i < 3; i++) {
        shows_video(o, "v", true);
        fail_video(o);
        shows(o, "b");
        wait_for(o, 30);
    }
    assert_int_equal(count_lines("is skipped: video: changes its size"), skipped + 1);
    /* all fail, though each could be loaded */
    assert_string_equal(asked(o), "v");
    set_timeless(o, "", true);
    fail_load(o);
    set_timeless(o, "vw", true);
    lf_playlist_play(o->list, -1);
    shows_video(o, "v", true);
    fail_video(o);
    shows_video(o, "w", true);
    fail_video(o);
    assert_false(is_playing(o));
    assert_int_equal(count_lines("none of its 2 entries can be shown"), none + 1);
}

/* Its last frame may be on the panel. */
static void a_video_is_loaded_again_if_all_others_fail(void **state)
{
    owner *o = *state;
    set_timeless(o, "vb", true);
    lf_playlist_play(o->list, -1);
    for (int i = 0; i < 4; i++) {
        shows_video(o, "v", true);
        play_through(o);
        fails(o, "b");
    }
    assert_true(is_playing(o));
}

static void a_pause_holds_the_time(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_pause(o->list, true); /* of a list that is stopped */
    assert_false(lf_playlist_now(o->list).paused);
    lf_playlist_play(o->list, 1);
    shows(o, "b");
    lf_assert_close(timer(), 2, 0, 1e-5);
    clock_now += 1.5;
    const int n = o->n_changed;
    lf_playlist_pause(o->list, true);
    lf_playlist_pause(o->list, true);
    assert_int_equal(o->n_changed, n + 1);
    assert_true(lf_playlist_now(o->list).paused && is_playing(o));
    clock_now += 500;
    assert_true(sd_event_run(o->event, 0) >= 0);
    assert_string_equal(asked(o), "");
    lf_playlist_pause(o->list, false);
    wait_for(o, 0.5);
    assert_string_equal(asked(o), "c");
    lf_playlist_pause(o->list, true); /* while it loads */
    clock_now += 500;
    load(o);
    show(o, LF_LEVEL_COARSE);
    assert_true(timer() < 0);
    clock_now += 500;
    lf_playlist_pause(o->list, false);
    wait_for(o, 3);
    shows(o, "a");
    lf_playlist_pause(o->list, true);
    lf_playlist_stop(o->list);
    assert_false(lf_playlist_now(o->list).paused);
}

static void steps_work_in_a_pause(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    timer();
    lf_playlist_pause(o->list, true);
    lf_playlist_step(o->list, 1);
    shows(o, "b");
    assert_true(timer() < 0);
    assert_true(lf_playlist_now(o->list).paused);
    lf_playlist_step(o->list, -1);
    shows(o, "a");
    lf_playlist_play(o->list, 2); /* ends it */
    shows(o, "c");
    lf_assert_close(timer(), 3, 0, 1e-5);
}

static void a_video_that_ends_in_a_pause_is_followed_after_it(void **state)
{
    owner *o = *state;
    set_timeless(o, "vb", true);
    lf_playlist_play(o->list, -1);
    shows_video(o, "v", true);
    lf_playlist_pause(o->list, true);
    play_through(o); /* its last frame was on its way */
    assert_string_equal(asked(o), "");
    lf_playlist_pause(o->list, false);
    assert_string_equal(asked(o), "b");
}

static json_t *zoom(double by)
{
    return json_pack("{s:f}", "zoom", by);
}

static void change(owner *o, int index, double seconds, json_t *keys)
{
    lf_playlist_change(o->list, index, seconds, keys);
    json_decref(keys);
}

static void a_change_shows_the_current_entry_again_and_its_time_goes_on(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    change(o, 0, 1, zoom(2)); /* the list is stopped */
    assert_string_equal(asked(o), "");
    lf_playlist_play(o->list, 1);
    shows(o, "b");
    clock_now += 1;
    const int n = o->n_changed;
    change(o, 1, 2, zoom(3));
    assert_int_equal(o->n_changed, n + 1);
    shows(o, "b");
    lf_assert_close(timer(), 1, 0, 1e-5);
    change(o, 1, 2, zoom(3)); /* the same */
    assert_string_equal(asked(o), "");
    assert_int_equal(o->n_changed, n + 1);
    change(o, 2, 3, zoom(2)); /* another entry */
    assert_string_equal(asked(o), "");
    change(o, 1, 9, zoom(3)); /* its time alone */
    assert_string_equal(asked(o), "");
    wait_for(o, 8);
    assert_string_equal(asked(o), "c");
}

/* Many changes, as of a slider, load the first and the last. */
static void changes_while_one_loads_are_loaded_together(void **state)
{
    owner *o = *state;
    set(o, "abc", true);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    for (int i = 1; i < 9; i++)
        change(o, 0, 1, zoom(i));
    assert_int_equal(o->n_vain, 0);
    for (int i = 0; i < 2; i++)
        shows(o, "a");
    assert_string_equal(asked(o), "");
    assert_int_equal(
        json_number_value(json_object_get(lf_playlist_now(o->list).entries[0].keys, "zoom")), 8);
}

/* A folder that is read again has no keys. */
static void new_entries_with_other_keys_are_loaded_again(void **state)
{
    owner *o = *state;
    set(o, "ab", true);
    lf_playlist_play(o->list, -1);
    shows(o, "a");
    change(o, 0, 1, zoom(2));
    shows(o, "a");
    clock_now += 0.25;
    set(o, "xa", true);
    shows(o, "a");
    assert_int_equal(index_of(o), 1);
    lf_assert_close(timer(), 1.75, 0, 1e-5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        list_test(without_a_time_a_video_plays_through_and_others_have_the_lists),
        list_test(a_video_with_a_time_is_shown_for_it),
        list_test(a_video_alone_loops_and_the_last_one_stays),
        list_test(a_video_loops_as_soon_as_nothing_follows_it),
        list_test(the_last_video_of_a_list_that_has_ended_holds),
        list_test(a_video_of_one_frame_is_shown_as_a_picture),
        list_test(what_a_video_before_did_does_not_count),
        list_test(videos_that_fail_are_skipped),
        list_test(a_video_is_loaded_again_if_all_others_fail),
        list_test(a_pause_holds_the_time),
        list_test(steps_work_in_a_pause),
        list_test(a_video_that_ends_in_a_pause_is_followed_after_it),
        list_test(a_change_shows_the_current_entry_again_and_its_time_goes_on),
        list_test(changes_while_one_loads_are_loaded_together),
        list_test(new_entries_with_other_keys_are_loaded_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
