/* A slideshow through a running daemon: in which order files are shown, what ends it, and what is
 * refused. Nothing here asserts how long an entry is shown. */
#include "tests/daemon/live.h"

#include "base/image_io.h"

/* The time of an entry that is not to end. */
#define LONG 86400.0

typedef struct hall {
    live l;
    live_client c, watcher; /* the watcher hears of scenes and the playlist */
    char scene[PATH_MAX / 4];
} hall;

static const char *within(const hall *h, const char *name)
{
    return lf_test_path(h->scene, name);
}

static void write_picture(const char *path)
{
    lf_image8 image = {0};
    lf_outfile file;
    lf_error err;
    lf_assert_ok(lf_image8_init(&image, 48, 64, 3), NULL);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8_finish(&image);
}

/* Three pictures, of which one is a quilt, a damaged one, and a scene. */
static void begin(hall *h)
{
    live_prepare(&h->l);
    snprintf(h->scene, sizeof h->scene, "%s/scene", h->l.folder);
    write_picture(within(h, "a.png"));
    write_picture(within(h, "b_qs2x2.png"));
    write_picture(within(h, "c.png"));
    lf_test_write(h->scene, "bad.png", "x");
    lf_test_write(h->scene, "worse.png", "x");
    live_start(&h->l, NULL, "--device", h->l.sim, "--allow-path", h->scene, NULL);
    live_connect(&h->l, &h->c);
    live_connect(&h->l, &h->watcher);
    assert_int_equal(
        live_code(&h->watcher, "subscribe", json_pack("{s:[s,s]}", "events", "scene", "playlist")),
        0);
}

static void end(hall *h)
{
    live_close(&h->c);
    live_close(&h->watcher);
    live_finish(&h->l);
}

/* names: file names with blanks in between; seconds: of each. */
static json_t *entries_of(const hall *h, const char *names, double seconds)
{
    json_t *entries = json_array();
    char text[256], *rest = text;
    snprintf(text, sizeof text, "%s", names);
    for (const char *name; (name = strsep(&rest, " "));)
        json_array_append_new(entries,
                              json_pack("{s:s, s:f}", "file", within(h, name), "seconds", seconds));
    return entries;
}

static void set(hall *h, const char *names, double seconds, bool loop)
{
    json_t *params =
        json_pack("{s:o, s:b}", "entries", entries_of(h, names, seconds), "loop", (int)loop);
    assert_int_equal(live_code(&h->c, "playlist.set", params), 0);
}

/* The next notification of this name. */
static json_t *next_told(hall *h, const char *method)
{
    for (;;) {
        json_t *message = live_receive(&h->watcher);
        assert_non_null(message);
        if (strcmp(json_string_value(json_object_get(message, "method")), method) == 0)
            return message;
        json_decref(message);
    }
}

/* The next scene that is shown is this file, with the next generation. */
static void assert_shown(hall *h, const char *name, int generation)
{
    json_t *message = next_told(h, "scene");
    const json_t *params = json_object_get(message, "params");
    assert_string_equal(json_string_value(json_object_get(params, "file")), within(h, name));
    assert_int_equal(json_integer_value(json_object_get(params, "generation")), generation);
    json_decref(message);
}

static json_t *slideshow(hall *h)
{
    json_t *answer = live_call(&h->c, "status", NULL);
    json_t *now = json_incref(json_object_get(json_object_get(answer, "result"), "playlist"));
    assert_non_null(now);
    json_decref(answer);
    return now;
}

static bool is_playing(hall *h)
{
    json_t *now = slideshow(h);
    bool playing = json_is_true(json_object_get(now, "playing"));
    json_decref(now);
    return playing;
}

static int index_now(hall *h)
{
    json_t *now = slideshow(h);
    int index = (int)json_integer_value(json_object_get(now, "index"));
    json_decref(now);
    return index;
}

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

/* The answer is an error with this code, pointer and text. */
static void assert_refused(hall *h, const char *method, json_t *params, int code,
                           const char *pointer, const char *why)
{
    json_t *answer = live_call(&h->c, method, params);
    const json_t *error = json_object_get(answer, "error");
    const char *text = json_string_value(json_object_get(error, "message")),
               *at = json_string_value(json_object_get(json_object_get(error, "data"), "pointer"));
    assert_int_equal(json_integer_value(json_object_get(error, "code")), code);
    assert_string_equal(at ? at : "", pointer);
    if (!text || !strstr(text, why))
        fail_msg("\"%s\" does not say \"%s\"", text ? text : "", why);
    json_decref(answer);
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
        cmocka_unit_test(another_scene_ends_it_and_changes_do_not),
        cmocka_unit_test(buttons_step_through_it_while_it_plays),
        cmocka_unit_test(next_and_previous_step_while_it_is_stopped),
        cmocka_unit_test(entries_are_checked_and_a_wrong_one_changes_nothing),
        cmocka_unit_test(a_long_list_of_long_names_is_refused),
        cmocka_unit_test(quiltctl_sends_absolute_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
