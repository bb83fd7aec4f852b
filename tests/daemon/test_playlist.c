/* The slideshow without a server, by a clock of the test's own (wrap_test_playlist): which files
 * are asked for, and when. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/parts/play_list.h"
#include "tests/daemon/own_clock.h"

typedef struct owner {
    sd_event *event;
    lf_playlist *list;
    char asked[16]; /* asked for last, and not looked at yet; "": nothing */
    bool on_its_way, refuses;
    bool once; /* as it was asked for last */
    int n_vain, n_changed;
    int64_t generation;
} owner;

static bool on_due(void *context, const lf_playlist_entry *entry, bool once)
{
    owner *o = context;
    assert_string_equal(o->asked, "");
    assert_false(o->on_its_way); /* one at a time */
    if (o->refuses)
        return false;
    snprintf(o->asked, sizeof o->asked, "%s", entry->file);
    o->once = once;
    o->on_its_way = true;
    return true;
}

static void on_vain(void *context)
{
    owner *o = context;
    assert_true(o->on_its_way);
    o->n_vain++;
}

static void on_changed(void *context)
{
    owner *o = context;
    o->n_changed++;
}

static int set_up(void **state)
{
    static const lf_playlist_events events = {
        .due = on_due, .vain = on_vain, .changed = on_changed};
    owner *o = *state = calloc(1, sizeof *o);
    assert_non_null(o);
    clock_now = 1000;
    woken_in = -1;
    assert_true(sd_event_new(&o->event) >= 0);
    lf_assert_ok(lf_playlist_create(o->event, &events, o, &o->list), NULL);
    return 0;
}

static int tear_down(void **state)
{
    owner *o = *state;
    lf_playlist_destroy(o->list);
    sd_event_unref(o->event);
    free(o);
    return 0;
}

/* Each letter is a file; entry i is shown for 1 + i seconds. */
static void set(owner *o, const char *files, bool loop)
{
    const int n = (int)strlen(files);
    lf_playlist_entry *entries = lf_calloc((size_t)n + 1, sizeof *entries);
    assert_non_null(entries);
    for (int i = 0; i < n; i++) {
        const char name[2] = {files[i], '\0'};
        entries[i] = (lf_playlist_entry){.file = lf_strdup(name), .seconds = 1 + i};
    }
    const lf_playlist_how how = {.seconds = 30, .loop = loop};
    lf_playlist_set(o->list, entries, n, &how);
}

/* The file that was asked for since the last look. */
static const char *asked(owner *o)
{
    char *file = lf_test_buffer();
    snprintf(file, 16, "%s", o->asked);
    o->asked[0] = '\0';
    return file;
}

static void load(owner *o)
{
    assert_true(o->on_its_way);
    o->on_its_way = false;
    lf_playlist_loaded(o->list, ++o->generation, false, NULL);
}

static void fail_load(owner *o)
{
    lf_error err;
    (void)lf_error_set(&err, LF_E_FORMAT, "file", "is damaged");
    assert_true(o->on_its_way);
    o->on_its_way = false;
    lf_playlist_loaded(o->list, 0, false, &err);
}

static void show(owner *o, lf_level level)
{
    lf_playlist_shown(o->list, o->generation, level);
}

/* Expects this file, and shows it. */
static void shows(owner *o, const char *file)
{
    assert_string_equal(asked(o), file);
    load(o);
    show(o, LF_LEVEL_COARSE);
}

/* Expects this file, which is damaged. */
static void fails(owner *o, const char *file)
{
    assert_string_equal(asked(o), file);
    fail_load(o);
}

/* The timer that was set; negative: none. */
static double timer(void)
{
    double seconds = woken_in;
    woken_in = -1;
    return seconds;
}

/* Waits for the timer, which must be this long. */
static void wait_for(owner *o, double seconds)
{
    double in = timer();
    lf_assert_close(in, seconds, 0, 1e-5);
    clock_now += in;
    assert_true(sd_event_run(o->event, 0) >= 0);
}

static bool is_playing(const owner *o)
{
    return lf_playlist_now(o->list).playing;
}

static int index_of(const owner *o)
{
    return lf_playlist_now(o->list).index;
}

/* The log's lines with this text since the start of the program. */
static int count_lines(const char *text)
{
    lf_log_line line;
    int n = 0;
    for (int64_t i = 1; i <= lf_log_last(); i++)
        n += lf_log_line_at(i, &line) && strstr(line.text, text);
    return n;
}

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

#define list_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

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
        list_test(entries_come_in_turn_each_for_its_time),
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
        list_test(without_a_time_a_video_plays_through_and_others_have_the_lists),
        list_test(a_video_with_a_time_is_shown_for_it),
        list_test(a_video_alone_loops_and_the_last_one_stays),
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
