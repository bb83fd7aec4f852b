/* A slideshow through a running daemon: in which order files are shown, what ends it, and what is
 * refused. Nothing here asserts how long an entry is shown. */
#include "tests/daemon/hall.h"

static void pictures_and_a_scene_come_in_turn(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    json_t *none = slideshow(&h);
    assert_true(json_is_null(none));
    json_decref(none);
    set(&h, "a.png b_qs2x2.png fog.json c.png", 0.1, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    static const char *const order[] = {"a.png", "b_qs2x2.png", "fog.json", "c.png"};
    for (int i = 0; i < 9; i++)
        assert_shown(&h, order[i % 4], 1 + i);
    assert_true(is_playing(&h));
    assert_int_equal(live_code(&h.c, "playlist.stop", NULL), 0);
    assert_false(is_playing(&h));
    end(&h);
}

static void without_loop_it_ends_and_says_so(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "a.png c.png", 0.1, false);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    static const struct {
        int index;
        bool playing;
    } told[] = {{0, false}, {0, true}, {1, true}, {1, false}}; /* the first: set */
    for (int i = 0; i < 4; i++) {
        json_t *message = next_told(&h, "playlist");
        const json_t *params = json_object_get(message, "params");
        assert_int_equal(json_integer_value(json_object_get(params, "index")), told[i].index);
        assert_int_equal(json_is_true(json_object_get(params, "playing")), told[i].playing);
        assert_true(json_is_false(json_object_get(params, "loop")));
        assert_int_equal(json_array_size(json_object_get(params, "entries")), 2);
        json_decref(message);
    }
    assert_false(is_playing(&h));
    end(&h);
}

static void bad_entries_are_skipped_and_if_all_are_bad_it_stops(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "bad.png a.png bad.png c.png", 0.1, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    for (int i = 0; i < 6; i++)
        assert_shown(&h, i % 2 ? "c.png" : "a.png", 1 + i);
    assert_true(live_logged(&h.l, "playlist: entry 0 is skipped: "));
    assert_int_equal(live_code(&h.c, "playlist.stop", NULL), 0);
    set(&h, "bad.png worse.png", LONG, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && is_playing(&h); i++)
        live_nap(20);
    assert_false(is_playing(&h));
    assert_true(live_logged(&h.l, "playlist: none of its 2 entries can be shown; it stops"));
    end(&h);
}

/* -1: of none. */
static json_int_t turn_told(hall *h)
{
    json_t *message = next_told(h, "scene");
    const json_t *turn = json_object_get(json_object_get(message, "params"), "turn");
    const json_int_t number = turn ? json_integer_value(turn) : -1;
    json_decref(message);
    return number;
}

static void an_image_has_the_turn_of_the_answer(void **state)
{
    static const char *const steps[] = {"playlist.play", "playlist.next"};
    (void)state;
    hall h;
    begin(&h);
    set(&h, "fog.json a.png", LONG, true);
    for (int i = 0; i < 2; i++) {
        json_t *answer = live_call(&h.c, steps[i], NULL);
        assert_int_equal(
            json_integer_value(json_object_get(json_object_get(answer, "result"), "turn")), i + 1);
        json_decref(answer);
        assert_int_equal(turn_told(&h), i + 1);
        if (i == 0) {
            assert_int_equal(live_code(&h.c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
            assert_int_equal(turn_told(&h), -1);
        }
    }
    end(&h);
}

static void another_scene_ends_it_and_changes_do_not(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "fog.json a.png", LONG, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    assert_shown(&h, "fog.json", 1);
    assert_int_equal(live_code(&h.c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    assert_int_equal(
        live_code(&h.c, "scene.patch", json_pack("{s:{s:{s:f}}}", "patch", "camera", "cone", 20.0)),
        0);
    kill(h.l.pid, SIGHUP); /* reads the same file again */
    for (int generation = 2; generation <= 4; generation++)
        assert_shown(&h, "fog.json", generation);
    assert_true(is_playing(&h));
    json_t *wrong = json_pack("{s:s}", "file", within(&h, "missing.json"));
    assert_int_equal(live_code(&h.c, "scene.load", wrong), -32002);
    assert_true(is_playing(&h)); /* nothing was loaded */
    json_t *other = json_pack("{s:s, s:s}", "file", within(&h, "c.png"), "quilt", "1x1");
    assert_int_equal(live_code(&h.watcher, "scene.load", other), 0);
    assert_false(is_playing(&h));
    json_t *now = slideshow(&h);
    assert_int_equal(json_integer_value(json_object_get(now, "entries")), 2);
    json_decref(now);
    end(&h);
}

static void buttons_step_through_it_while_it_plays(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "c.png fog.json", LONG, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    assert_shown(&h, "c.png", 1);
    static const char *const presses[] = {"right", "left", "left"};
    static const int indices[] = {1, 0, 1};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(live_code(&h.c, "button", json_pack("{s:s}", "name", presses[i])), 0);
        assert_int_equal(index_now(&h), indices[i]);
        assert_shown(&h, indices[i] ? "fog.json" : "c.png", 2 + i);
    }
    assert_int_equal(live_code(&h.c, "playlist.stop", NULL), 0);
    assert_int_equal(live_code(&h.c, "button", json_pack("{s:s}", "name", "right")), 0);
    assert_shown(&h, "b_qs2x2.png", 5); /* of the folder, by name */
    end(&h);
}

static void next_and_previous_step_while_it_is_stopped(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "a.png c.png", LONG, false);
    assert_int_equal(live_code(&h.c, "playlist.next", NULL), 0);
    assert_shown(&h, "c.png", 1);
    assert_int_equal(live_code(&h.c, "playlist.previous", NULL), 0);
    assert_shown(&h, "a.png", 2);
    assert_int_equal(live_code(&h.c, "playlist.previous", NULL), 0);
    assert_int_equal(index_now(&h), 0);
    assert_false(is_playing(&h));
    assert_int_equal(live_code(&h.c, "playlist.play", json_pack("{s:i}", "index", 1)), 0);
    assert_shown(&h, "c.png", 3);
    end(&h);
}

static json_t *one_more(const hall *h, const char *file)
{
    json_t *entries = entries_of(h, "a.png c.png", LONG);
    json_array_append_new(entries, json_pack("{s:s, s:i}", "file", file, "seconds", 1));
    return json_pack("{s:o}", "entries", entries);
}

static void entries_are_checked_and_a_wrong_one_changes_nothing(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    assert_refused(&h, "playlist.play", NULL, -32000, "", "call playlist.set first");
    assert_refused(&h, "playlist.next", NULL, -32000, "", "call playlist.set first");
    set(&h, "fog.json", LONG, false);
    assert_refused(&h, "playlist.set", one_more(&h, h.l.sim + 4), -32001, "/entries/2/file",
                   "outside the folders");
    assert_refused(&h, "playlist.set", one_more(&h, "/missing.png"), -32001, "/entries/2/file",
                   "outside the folders");
    assert_int_equal(symlink(h.l.sim + 4, within(&h, "link.png")), 0);
    assert_refused(&h, "playlist.set", one_more(&h, within(&h, "link.png")), -32001,
                   "/entries/2/file", "outside the folders");
    assert_refused(&h, "playlist.set", one_more(&h, within(&h, "missing.png")), -32002,
                   "/entries/2/file", "No such file");
    assert_refused(&h, "playlist.set", one_more(&h, ""), -32602, "/entries/2/file", "empty");
    static const char *const wrong[] = {"0", "0.09", "86401", "\"1\"", "null"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        json_t *params = json_pack("{s:o}", "entries", entries_of(&h, "a.png", 1));
        json_object_set_new(json_array_get(json_object_get(params, "entries"), 0), "seconds",
                            json_loads(wrong[i], JSON_DECODE_ANY, NULL));
        assert_refused(&h, "playlist.set", params, -32602, "/entries/0/seconds", "");
    }
    json_t *checked =
        json_pack("{s:o, s:b}", "entries", entries_of(&h, "a.png c.png", 1), "check", 1);
    json_t *answer = live_call(&h.c, "playlist.set", json_incref(checked));
    assert_int_equal(json_array_size(json_object_get(json_object_get(answer, "result"), "entries")),
                     2);
    json_decref(answer);
    json_array_append_new(json_object_get(checked, "entries"),
                          json_pack("{s:s}", "file", within(&h, "missing.png")));
    assert_refused(&h, "playlist.set", checked, -32002, "/entries/2/file", "No such file");
    assert_refused(&h, "playlist.play", json_pack("{s:i}", "index", 1), -32602, "/index",
                   "there is no entry 1");
    json_t *now = slideshow(&h);
    assert_int_equal(json_integer_value(json_object_get(now, "entries")), 1);
    json_decref(now);
    end(&h);
}

static void a_long_list_of_long_names_is_refused(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    char name[256];
    snprintf(name, sizeof name, "%0240d.png", 7);
    write_picture(within(&h, name));
    json_t *entries = json_array(), *one = entries_of(&h, name, 1);
    for (int i = 0; i < 1000; i++)
        json_array_append(entries, json_array_get(one, 0));
    assert_refused(&h, "playlist.set", json_pack("{s:O}", "entries", entries), -32602, "/entries",
                   "256 KiB");
    json_array_append(entries, json_array_get(one, 0));
    assert_refused(&h, "playlist.set", json_pack("{s:o}", "entries", entries), -32602, "/entries",
                   "at most 1000");
    json_decref(one);
    end(&h);
}

/* Its tiles may be meant; a name that has them is believed. */
static void a_video_that_is_shown_as_one_view_is_told(void **state)
{
    (void)state;
    static const char words[] = "turn.mp4: is shown as one view, because its name has no tiles";
    hall h;
    begin(&h);
    lf_test_write(h.scene, "turn.mp4", "x");
    lf_test_write(h.scene, "turn_qs2x2.mp4", "x");
    set(&h, "a.png turn_qs2x2.mp4", LONG, true);
    assert_false(live_logged(&h.l, "is shown as one view"));
    set(&h, "a.png turn_qs2x2.mp4 turn.mp4", LONG, true);
    while (!live_logged(&h.l, words))
        live_nap(20);
    end(&h);
}

static void quiltctl_sends_absolute_names(void **state)
{
    (void)state;
    hall h;
    char before[PATH_MAX];
    begin(&h);
    assert_non_null(getcwd(before, sizeof before));
    assert_int_equal(chdir(h.l.folder), 0);
    const int code =
        live_run(&h.l, "quiltctl", "--socket", h.l.socket, "playlist.set",
                 "entries:=[{\"file\": \"scene/a.png\", \"seconds\": 9}, {\"seconds\": 9, "
                 "\"file\": \"scene/fog.json\"}]",
                 NULL);
    assert_int_equal(chdir(before), 0);
    assert_int_equal(code, 0);
    /* one line, not the whole list */
    assert_true(live_logged(&h.l, "entry 1 of 2, a.png, stopped"));
    assert_false(live_logged(&h.l, "entries.0"));
    assert_int_not_equal(live_run(&h.l, "quiltctl", "--socket", h.l.socket, "playlist.set",
                                  "folder=/nowhere/at/all", NULL),
                         0);
    assert_true(live_logged(&h.l, "/nowhere/at/all: No such file or directory"));
    assert_int_not_equal(live_run(&h.l, "quiltctl", "--socket", h.l.socket, "scene.load",
                                  "file=/nowhere/missing.glb", NULL),
                         0);
    assert_true(live_logged(&h.l, "/nowhere/missing.glb: No such file or directory"));
    json_t *answer = live_call(&h.c, "playlist.get", NULL);
    json_t *entries = json_object_get(json_object_get(answer, "result"), "entries");
    assert_int_equal(json_array_size(entries), 2);
    assert_string_equal(json_string_value(json_object_get(json_array_get(entries, 0), "file")),
                        within(&h, "a.png"));
    json_decref(answer);
    end(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_and_a_scene_come_in_turn),
        cmocka_unit_test(without_loop_it_ends_and_says_so),
        cmocka_unit_test(bad_entries_are_skipped_and_if_all_are_bad_it_stops),
        cmocka_unit_test(an_image_has_the_turn_of_the_answer),
        cmocka_unit_test(another_scene_ends_it_and_changes_do_not),
        cmocka_unit_test(buttons_step_through_it_while_it_plays),
        cmocka_unit_test(next_and_previous_step_while_it_is_stopped),
        cmocka_unit_test(entries_are_checked_and_a_wrong_one_changes_nothing),
        cmocka_unit_test(a_long_list_of_long_names_is_refused),
        cmocka_unit_test(a_video_that_is_shown_as_one_view_is_told),
        cmocka_unit_test(quiltctl_sends_absolute_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
