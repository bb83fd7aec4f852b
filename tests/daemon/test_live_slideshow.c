/* Slideshows of folders and of videos through a running daemon, and the options that begin them.
 * Nothing here asserts how long an entry is shown. */
#include "tests/daemon/hall.h"

#include <sys/stat.h>

#include "base/thread.h"

/* What the folder has to show, in its order. "worse.png" and "bad.png" cannot be shown, which is
 * known only when they are loaded. */
static const char *const shown[] = {"2.png",    "10.png", "a.png",    "b_qs2x2.png",
                                    "bad.png",  "c.png",  "fog.json", "movie_qs2x2a0.75.mp4",
                                    "worse.png"};
enum { SHOWN = sizeof shown / sizeof *shown };

/* Files that no slideshow shows, and more that it does. */
static void fill(const hall *h)
{
    write_picture(within(h, "10.png"));
    write_picture(within(h, "2.png"));
    write_picture(within(h, ".hidden.png"));
    lf_test_write(h->scene, "sky.exr", "x");
    lf_test_write(h->scene, "notes.txt", "x");
    lf_test_write(h->scene, "other.json", "{}");
    lf_test_write(h->scene, "movie_qs2x2a0.75.mp4", "x");
    assert_int_equal(mkdir(within(h, "deeper"), 0777), 0);
    write_picture(within(h, "deeper/d.png"));
}

static json_t *list(hall *h)
{
    json_t *answer = live_call(&h->c, "playlist.get", NULL);
    json_t *result = json_incref(json_object_get(answer, "result"));
    assert_non_null(result);
    json_decref(answer);
    return result;
}

static void assert_entries(const hall *h, const json_t *list, const char *const *names, size_t n)
{
    const json_t *entries = json_object_get(list, "entries");
    assert_int_equal(json_array_size(entries), n);
    for (size_t i = 0; i < n; i++) {
        const json_t *entry = json_array_get(entries, i);
        assert_string_equal(json_string_value(json_object_get(entry, "file")), within(h, names[i]));
        assert_null(json_object_get(entry, "seconds"));
    }
}

static void a_folder_is_shown_in_natural_order(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    fill(&h);
    assert_int_equal(live_code(&h.c, "playlist.set",
                               json_pack("{s:s, s:f, s:f, s:b}", "folder", h.scene, "seconds", 0.2,
                                         "crossfade", 0.1, "loop", 1)),
                     0);
    json_t *now = list(&h);
    assert_entries(&h, now, shown, SHOWN);
    assert_string_equal(json_string_value(json_object_get(now, "folder")), h.scene);
    assert_true(json_is_false(json_object_get(now, "more")));
    assert_true(json_is_false(json_object_get(now, "paused")));
    lf_assert_close(json_number_value(json_object_get(now, "seconds")), 0.2, 0, 1e-12);
    lf_assert_close(json_number_value(json_object_get(now, "crossfade")), 0.1, 0, 1e-12);
    json_decref(now);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    for (int i = 0, generation = 0; i < SHOWN + 2; i++) {
        const char *name = shown[i % SHOWN];
        if (strcmp(name, "bad.png") != 0 && strcmp(name, "worse.png") != 0 &&
            strncmp(name, "movie", 5) != 0)
            assert_shown(&h, name, ++generation);
    }
    json_t *answer =
        live_call(&h.c, "playlist.set",
                  json_pack("{s:o, s:b}", "entries", entries_of(&h, "a.png", LONG), "check", 1));
    const json_t *checked = json_object_get(answer, "result");
    assert_int_equal(json_array_size(json_object_get(checked, "entries")), 1);
    assert_true(json_is_false(json_object_get(checked, "playing")));
    json_decref(answer);
    assert_refused(
        &h, "playlist.set",
        json_pack("{s:[{s:s}], s:b}", "entries", "file", within(&h, "missing.png"), "check", 1),
        -32002, "/entries/0/file", "No such file");
    now = list(&h);
    assert_int_equal(json_array_size(json_object_get(now, "entries")), SHOWN);
    assert_true(json_is_true(json_object_get(now, "playing")));
    json_decref(now);
    set(&h, "a.png", LONG, true);
    now = list(&h);
    assert_true(json_is_null(json_object_get(now, "folder")));
    lf_assert_close(json_number_value(json_object_get(now, "seconds")), 10, 0, 1e-12);
    json_decref(now);
    end(&h);
}

static json_t *folder(const char *path)
{
    return json_pack("{s:s}", "folder", path);
}

static void folders_that_cannot_be_shown_are_refused(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "a.png", LONG, true);
    assert_int_equal(mkdir(within(&h, "empty"), 0777), 0);
    write_picture(within(&h, "empty/.hidden.png"));
    lf_test_write(h.scene, "empty/notes.txt", "x");
    assert_refused(&h, "playlist.set", folder(within(&h, "empty")), -32002, "",
                   "nothing in the folder can be shown");
    assert_refused(&h, "playlist.set", folder(within(&h, "missing")), -32002, "", "No such file");
    assert_refused(&h, "playlist.set", folder(within(&h, "a.png")), -32002, "", "not a folder");
    assert_refused(&h, "playlist.set", folder("/etc"), -32001, "", "outside the folders");
    assert_refused(&h, "playlist.set", folder(""), -32602, "/folder", "empty");
    assert_refused(&h, "playlist.set", NULL, -32602, "", "give entries or folder");
    assert_refused(&h, "playlist.set", json_pack("{s:s, s:[]}", "folder", h.scene, "entries"),
                   -32602, "", "exclude each other");
    assert_refused(&h, "playlist.set", json_pack("{s:[], s:f}", "entries", "crossfade", 10.5),
                   -32602, "/crossfade", "");
    assert_refused(&h, "playlist.set", json_pack("{s:[], s:i}", "entries", "seconds", 0), -32602,
                   "/seconds", "");
    assert_int_equal(index_now(&h), 0); /* the list is as it was */
    json_t *now = list(&h);
    assert_int_equal(json_array_size(json_object_get(now, "entries")), 1);
    json_decref(now);
    end(&h);
}

static void of_many_files_the_first_1000_are_shown(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    assert_int_equal(mkdir(within(&h, "many"), 0777), 0);
    for (int i = 1; i <= 1001; i++) {
        char name[32];
        snprintf(name, sizeof name, "many/%d.png", i);
        lf_test_write(h.scene, name, "x");
    }
    assert_int_equal(live_code(&h.c, "playlist.set", folder(within(&h, "many"))), 0);
    json_t *now = list(&h);
    const json_t *entries = json_object_get(now, "entries");
    assert_int_equal(json_array_size(entries), 1000);
    assert_string_equal(json_string_value(json_object_get(json_array_get(entries, 999), "file")),
                        within(&h, "many/1000.png"));
    assert_true(json_is_true(json_object_get(now, "more")));
    json_decref(now);
    assert_true(live_logged(&h.l, "the slideshow has the first 1000"));
    end(&h);
}

static void keys_of_an_entry_are_checked_and_told(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    static const struct {
        const char *entry, *pointer, *why;
    } wrong[] = {
        {"{\"file\": \"a.png\", \"quilt\": \"8\"}", "/entries/0/quilt", ""},
        {"{\"file\": \"b_qs2x2.png\", \"views\": 5}", "/entries/0/views", "fewer tiles"},
        {"{\"file\": \"a.png\", \"zoom\": 5}", "/entries/0/zoom", ""},
        {"{\"file\": \"a.png\", \"rgbd_in\": \"behind\"}", "/entries/0/rgbd_in", ""},
        {"{\"file\": \"a.png\", \"loud\": true}", "/entries/0", "loud"},
        {"{\"file\": \"fog.json\", \"focus\": 0.1}", "/entries/0/focus", "without a scene"},
        {"{\"seconds\": 1}", "/entries/0", "file"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        json_t *entry = json_loads(wrong[i].entry, 0, NULL);
        assert_refused(&h, "playlist.set", json_pack("{s:[o]}", "entries", entry), -32602,
                       wrong[i].pointer, wrong[i].why);
    }
    json_t *entry = json_pack("{s:s, s:s, s:f, s:f, s:f}", "file", within(&h, "c.png"), "quilt",
                              "2x2", "aspect", 0.5, "focus", 0.01, "zoom", 2.0);
    assert_int_equal(live_code(&h.c, "playlist.set", json_pack("{s:[O]}", "entries", entry)), 0);
    json_t *now = list(&h);
    assert_true(json_equal(json_array_get(json_object_get(now, "entries"), 0), entry));
    json_decref(now);
    json_decref(entry);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    live_wait(&h.c, "converged");
    assert_int_equal((int)live_number(&h.c, "status", NULL, "views"), 4);
    lf_assert_close(live_number(&h.c, "status", NULL, "aspect"), 0.5, 0, 1e-9);
    assert_int_equal(live_code(&h.c, "playlist.change", json_pack("{s:i}", "views", 3)), 0);
    live_wait(&h.c, "converged");
    while ((int)live_number(&h.c, "status", NULL, "views") != 3)
        live_nap(20);
    end(&h);
}

/* The keys of the current entry, of which a change names some, are those of the load. */
static void a_change_is_shown_at_once(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    assert_refused(&h, "playlist.change", json_pack("{s:f}", "zoom", 2.0), -32000, "",
                   "call playlist.set first");
    set(&h, "a.png c.png", LONG, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    assert_shown(&h, "a.png", 1);
    assert_int_equal(live_code(&h.c, "playlist.change", json_pack("{s:s}", "quilt", "2x2")), 0);
    assert_shown(&h, "a.png", 2);
    assert_int_equal((int)live_number(&h.c, "status", NULL, "views"), 4);
    assert_int_equal(live_code(&h.c, "playlist.change", json_pack("{s:f}", "zoom", 2.0)), 0);
    assert_shown(&h, "a.png", 3);
    assert_int_equal((int)live_number(&h.c, "status", NULL, "views"), 4);
    assert_int_equal(
        live_code(&h.c, "playlist.change", json_pack("{s:i, s:f}", "index", 1, "zoom", 2.0)), 0);
    assert_refused(&h, "playlist.change", json_pack("{s:i, s:f}", "index", 2, "zoom", 2.0), -32602,
                   "/index", "there is no entry 2");
    assert_refused(&h, "playlist.change", json_pack("{s:s}", "quilt", "x"), -32602, "/quilt", "");
    assert_refused(&h, "playlist.change", json_pack("{s:s}", "file", "b.png"), -32602, "", "file");
    json_t *now = list(&h);
    const json_t *entries = json_object_get(now, "entries");
    for (int i = 0; i < 2; i++)
        lf_assert_close(
            json_number_value(json_object_get(json_array_get(entries, (size_t)i), "zoom")), 2, 0,
            1e-12);
    json_decref(now);
    assert_int_equal(live_code(&h.c, "playlist.next", NULL), 0);
    assert_shown(&h, "c.png", 4); /* nothing was loaded meanwhile */
    end(&h);
}

static bool is_paused(hall *h)
{
    json_t *now = slideshow(h);
    const bool paused = json_is_true(json_object_get(now, "paused"));
    json_decref(now);
    return paused;
}

static bool renders_not(hall *h)
{
    json_t *status = live_call(&h->c, "status", NULL);
    const bool paused = json_is_true(json_object_get(json_object_get(status, "result"), "paused"));
    json_decref(status);
    return paused;
}

static void a_pause_is_told_and_steps_work_in_it(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    set(&h, "a.png c.png", 0.5, true);
    assert_refused(&h, "playlist.pause", NULL, -32000, "", "is stopped");
    assert_int_equal(live_code(&h.c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    assert_true(renders_not(&h));
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    assert_int_equal(live_code(&h.c, "playlist.pause", NULL), 0);
    assert_true(is_paused(&h));
    const int index = index_now(&h);
    live_wait(&h.c, "converged");
    while (renders_not(&h)) /* an entry plays */
        live_nap(50);
    live_nap(1000); /* its time has passed */
    assert_int_equal(index_now(&h), index);
    assert_int_equal(live_code(&h.c, "playlist.next", NULL), 0);
    assert_int_equal(index_now(&h), 1 - index);
    assert_true(is_paused(&h));
    assert_int_equal(live_code(&h.c, "button", json_pack("{s:s}", "name", "square")), 0);
    assert_false(is_paused(&h));
    while (index_now(&h) != index) /* it goes on */
        live_nap(50);
    assert_int_equal(live_code(&h.c, "button", json_pack("{s:s}", "name", "square")), 0);
    assert_true(is_paused(&h));
    assert_int_equal(live_code(&h.c, "playlist.stop", NULL), 0);
    assert_false(is_paused(&h));
    end(&h);
}

/* The level that the first frame of this generation has. */
static const char *first_level(hall *h, int generation)
{
    char *level = lf_test_buffer();
    for (;;) {
        json_t *message = next_told(h, "frame");
        const json_t *frame = json_object_get(message, "params");
        snprintf(level, 32, "%s", json_string_value(json_object_get(frame, "level")));
        const bool is_it = json_integer_value(json_object_get(frame, "generation")) == generation;
        json_decref(message);
        if (is_it)
            return level;
    }
}

/* A mixed image is told as coarse. Steps work while images fade, and another file ends that. */
static void entries_fade_into_each_other_and_other_files_do_not(void **state)
{
    (void)state;
    hall h;
    begin(&h);
    assert_int_equal(live_code(&h.watcher, "subscribe", json_pack("{s:[s]}", "events", "frame")),
                     0);
    assert_int_equal(
        live_code(&h.c, "playlist.set",
                  json_pack("{s:o, s:f}", "entries",
                            entries_of(&h, "b_qs2x2.png a.png c.png", LONG), "crossfade", 10.0)),
        0);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    assert_string_equal(first_level(&h, 1), "converged"); /* after a card */
    for (int i = 2; i <= 4; i++) {
        assert_int_equal(live_code(&h.c, i % 2 ? "playlist.previous" : "playlist.next", NULL), 0);
        assert_string_equal(first_level(&h, i), "coarse");
    }
    assert_int_equal(live_code(&h.c, "playlist.pause", NULL), 0);
    assert_int_equal(live_code(&h.c, "playlist.play", json_pack("{s:i}", "index", 2)), 0);
    assert_string_equal(first_level(&h, 5), "coarse");
    assert_int_equal(
        live_code(&h.c, "scene.load", json_pack("{s:s}", "file", within(&h, "b_qs2x2.png"))), 0);
    assert_string_equal(first_level(&h, 6), "converged");
    end(&h);
}

/* Notifications of entries, until there are so many. */
static void wait_for_entries(hall *h, size_t n)
{
    size_t now = 0;
    while (now != n) {
        json_t *message = next_told(h, "playlist");
        now = json_array_size(json_object_get(json_object_get(message, "params"), "entries"));
        json_decref(message);
    }
}

static void the_option_plays_a_folder_and_a_hangup_reads_it_again(void **state)
{
    (void)state;
    hall h;
    prepare(&h);
    assert_int_equal(unlink(within(&h, "fog.json")), 0);
    live_start(&h.l, NULL, "--device", h.l.sim, "--playlist", h.scene, "--seconds", "80000",
               "--crossfade", "0.5", NULL);
    enter(&h);
    json_t *now;
    while (now = list(&h), json_array_size(json_object_get(now, "entries")) == 0) {
        json_decref(now);
        live_nap(20);
    }
    assert_int_equal(json_array_size(json_object_get(now, "entries")), 5);
    assert_true(json_is_true(json_object_get(now, "playing")));
    assert_true(json_is_true(json_object_get(now, "loop")));
    lf_assert_close(json_number_value(json_object_get(now, "seconds")), 80000, 0, 1e-9);
    lf_assert_close(json_number_value(json_object_get(now, "crossfade")), 0.5, 0, 1e-12);
    json_decref(now);
    live_wait(&h.c, "converged");
    assert_string_equal(live_status_text(&h.c, "scene"), within(&h, "a.png"));
    assert_int_equal(live_code(&h.c, "playlist.change", json_pack("{s:f}", "zoom", 2.0)), 0);
    write_picture(within(&h, "0.png"));
    assert_int_equal(unlink(within(&h, "c.png")), 0);
    write_picture(within(&h, "z.png"));
    kill(h.l.pid, SIGHUP);
    wait_for_entries(&h, 6);
    assert_int_equal(index_now(&h), 1); /* "a.png" stays, as it was changed */
    /* also if a client sets the same folder, for another crossfade */
    assert_int_equal(live_code(&h.c, "playlist.set",
                               json_pack("{s:s, s:f, s:f}", "folder", h.scene, "seconds", 80000.0,
                                         "crossfade", 1.0)),
                     0);
    now = list(&h);
    assert_true(json_object_get(json_array_get(json_object_get(now, "entries"), 1), "zoom"));
    assert_true(json_is_true(json_object_get(now, "playing")));
    json_decref(now);
    end(&h);
}

static void a_folder_that_is_filled_later_is_shown_after_a_hangup(void **state)
{
    (void)state;
    hall h;
    prepare(&h);
    assert_int_equal(mkdir(within(&h, "empty"), 0777), 0);
    live_start(&h.l, NULL, "--device", h.l.sim, "--playlist", within(&h, "empty"), NULL);
    enter(&h);
    while (!live_logged(&h.l, "nothing in the folder can be shown"))
        live_nap(20);
    assert_string_equal(live_status_text(&h.c, "state"), "error");
    write_picture(within(&h, "empty/1.png"));
    kill(h.l.pid, SIGHUP);
    assert_shown(&h, "empty/1.png", 1);
    end(&h);
}

static void options_that_do_not_belong_together_are_refused(void **state)
{
    (void)state;
    hall h;
    prepare(&h);
    assert_int_equal(live_run(&h.l, "quiltd", "--seconds", "5", NULL), 2);
    assert_int_equal(live_run(&h.l, "quiltd", "--crossfade", "1", NULL), 2);
    assert_int_equal(live_run(&h.l, "quiltd", h.l.sim, "--playlist", h.scene, NULL), 2);
    assert_int_equal(live_run(&h.l, "quiltd", "--playlist", "", NULL), 2);
    assert_int_equal(live_run(&h.l, "quiltd", "--playlist", h.scene, "--crossfade", "11", NULL), 2);
    assert_int_equal(live_run(&h.l, "quiltd", "--playlist", h.scene, "--seconds", "0", NULL), 2);
    assert_int_equal(live_run(&h.l, "quiltd", "--playlist", within(&h, "missing"), NULL), 1);
    static const char *const words[] = {"--seconds: needs --playlist FOLDER",
                                        "--crossfade: needs --playlist FOLDER",
                                        "exclude each other", "the name of the folder is empty"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!live_logged(&h.l, words[i]))
            fail_msg("the log does not say \"%s\"", words[i]);
    live_finish(&h.l);
}

/* ------------------------------------------------------------------------------------- media -- */

/* A quilt video of `frames` frames at 10 a second; false: there is no ffmpeg. */
static bool write_video(const hall *h, const char *name, const char *frames)
{
    char *const args[] = {(char[]){"ffmpeg"},
                          (char[]){"-loglevel"},
                          (char[]){"error"},
                          (char[]){"-f"},
                          (char[]){"lavfi"},
                          (char[]){"-i"},
                          (char[]){"testsrc=size=96x128:rate=10"},
                          (char[]){"-frames:v"},
                          (char *)(uintptr_t)frames,
                          (char *)(uintptr_t)within(h, name),
                          NULL};
    const pid_t pid = fork();
    if (pid == 0) {
        execvp(args[0], args);
        _exit(127);
    }
    const int code = live_reap(pid);
    assert_true(code == 0 || code == 127);
    if (code == 127)
        print_message("there is no ffmpeg: videos are not tested\n");
    return code == 0;
}

/* The numbers of different pushes in updates.jsonl. */
static int count_pushes(const hall *h)
{
    char line[4096], path[PATH_MAX];
    snprintf(path, sizeof path, "%s/updates.jsonl", h->l.sim + 4);
    live_wait_for_file(path);
    FILE *file = fopen(path, "r");
    int n = 0;
    double last = -1;
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        json_t *update = json_loads(line, 0, NULL);
        const double seq = json_number_value(json_object_get(update, "seq"));
        n += seq > last;
        last = seq > last ? seq : last;
        json_decref(update);
    }
    fclose(file);
    return n;
}

/* Whatever the machine does, images are dropped and never queued: the panel gets no more of them
 * than 60 a second. */
static void a_video_a_picture_and_a_scene_come_in_turn(void **state)
{
    (void)state;
    hall h;
    prepare(&h);
    if (!write_video(&h, "v_qs2x2a0.75.mp4", "8")) {
        live_finish(&h.l);
        skip();
    }
    live_start(&h.l, NULL, "--device", h.l.sim, "--allow-path", h.scene, NULL);
    enter(&h);
    const double start = lf_time_now();
    json_t *entries = json_pack("[{s:s}, {s:s, s:f}, {s:s, s:f}]", "file",
                                within(&h, "v_qs2x2a0.75.mp4"), "file", within(&h, "a.png"),
                                "seconds", 0.3, "file", within(&h, "fog.json"), "seconds", 0.3);
    assert_int_equal(live_code(&h.c, "playlist.set",
                               json_pack("{s:o, s:f}", "entries", entries, "crossfade", 0.2)),
                     0);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    static const char *const order[] = {"v_qs2x2a0.75.mp4", "a.png", "fog.json"};
    for (int i = 0; i < 9; i++)
        assert_shown(&h, order[i % 3], 1 + i);
    assert_int_equal(live_code(&h.c, "playlist.stop", NULL), 0);
    const double seconds = lf_time_now() - start;
    const int pushes = count_pushes(&h);
    assert_true(pushes >= 9);
    assert_true(pushes <= 60 * seconds + 2 * 9);
    end(&h);
}

static void a_video_holds_its_frame_in_a_pause_and_loops_for_its_time(void **state)
{
    (void)state;
    hall h;
    prepare(&h);
    if (!write_video(&h, "v_qs2x2a0.75.mp4", "5")) {
        live_finish(&h.l);
        skip();
    }
    live_start(&h.l, NULL, "--device", h.l.sim, "--allow-path", h.scene, NULL);
    enter(&h);
    set(&h, "v_qs2x2a0.75.mp4 a.png", LONG, true);
    assert_int_equal(live_code(&h.c, "playlist.play", NULL), 0);
    assert_shown(&h, "v_qs2x2a0.75.mp4", 1);
    const int first = count_pushes(&h);
    while (count_pushes(&h) < first + 12) /* two rounds */
        live_nap(50);
    assert_int_equal(index_now(&h), 0);
    assert_int_equal(live_code(&h.c, "playlist.pause", NULL), 0);
    int before, after = -1;
    do { /* what was on its way arrives */
        before = after;
        live_nap(500);
        after = count_pushes(&h);
    } while (after > before);
    live_nap(1000);
    assert_int_equal(count_pushes(&h), after);
    assert_int_equal(live_code(&h.c, "playlist.pause", json_pack("{s:b}", "paused", 0)), 0);
    while (count_pushes(&h) < after + 3)
        live_nap(50);
    end(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_folder_is_shown_in_natural_order),
        cmocka_unit_test(folders_that_cannot_be_shown_are_refused),
        cmocka_unit_test(of_many_files_the_first_1000_are_shown),
        cmocka_unit_test(keys_of_an_entry_are_checked_and_told),
        cmocka_unit_test(a_change_is_shown_at_once),
        cmocka_unit_test(a_pause_is_told_and_steps_work_in_it),
        cmocka_unit_test(entries_fade_into_each_other_and_other_files_do_not),
        cmocka_unit_test(the_option_plays_a_folder_and_a_hangup_reads_it_again),
        cmocka_unit_test(a_folder_that_is_filled_later_is_shown_after_a_hangup),
        cmocka_unit_test(options_that_do_not_belong_together_are_refused),
        cmocka_unit_test(a_video_a_picture_and_a_scene_come_in_turn),
        cmocka_unit_test(a_video_holds_its_frame_in_a_pause_and_loops_for_its_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
