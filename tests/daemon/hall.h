/* A quiltd with some pictures and a client that hears of its slideshow; for tests of slideshows. */
#ifndef LF_TESTS_DAEMON_HALL_H
#define LF_TESTS_DAEMON_HALL_H

#include "tests/daemon/live.h"

#include "base/image_io.h"

/* The time of an entry that is not to end. */
#define LONG 86400.0

typedef struct hall {
    live l;
    live_client c, watcher; /* the watcher hears of scenes and the playlist */
    char scene[PATH_MAX / 4];
} hall;

static inline const char *within(const hall *h, const char *name)
{
    return lf_test_path(h->scene, name);
}

static inline void write_picture(const char *path)
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

/* Three pictures, of which one is a quilt, damaged ones, and a scene; no daemon yet. */
static inline void prepare(hall *h)
{
    live_prepare(&h->l);
    snprintf(h->scene, sizeof h->scene, "%s/scene", h->l.folder);
    write_picture(within(h, "a.png"));
    write_picture(within(h, "b_qs2x2.png"));
    write_picture(within(h, "c.png"));
    lf_test_write(h->scene, "bad.png", "x");
    lf_test_write(h->scene, "worse.png", "x");
}

/* The daemon runs. */
static inline void enter(hall *h)
{
    live_connect(&h->l, &h->c);
    live_connect(&h->l, &h->watcher);
    assert_int_equal(
        live_code(&h->watcher, "subscribe", json_pack("{s:[s,s]}", "events", "scene", "playlist")),
        0);
}

static inline void begin(hall *h)
{
    prepare(h);
    live_start(&h->l, NULL, "--device", h->l.sim, "--allow-path", h->scene, NULL);
    enter(h);
}

static inline void end(hall *h)
{
    live_close(&h->c);
    live_close(&h->watcher);
    live_finish(&h->l);
}

/* names: file names with blanks in between; seconds: of each. */
static inline json_t *entries_of(const hall *h, const char *names, double seconds)
{
    json_t *entries = json_array();
    char text[256], *rest = text;
    snprintf(text, sizeof text, "%s", names);
    for (const char *name; (name = strsep(&rest, " "));)
        json_array_append_new(entries,
                              json_pack("{s:s, s:f}", "file", within(h, name), "seconds", seconds));
    return entries;
}

static inline void set(hall *h, const char *names, double seconds, bool loop)
{
    json_t *params =
        json_pack("{s:o, s:b}", "entries", entries_of(h, names, seconds), "loop", (int)loop);
    assert_int_equal(live_code(&h->c, "playlist.set", params), 0);
}

/* The next notification of this name. */
static inline json_t *next_told(hall *h, const char *method)
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
static inline void assert_shown(hall *h, const char *name, int generation)
{
    json_t *message = next_told(h, "scene");
    const json_t *params = json_object_get(message, "params");
    assert_string_equal(json_string_value(json_object_get(params, "file")), within(h, name));
    assert_int_equal(json_integer_value(json_object_get(params, "generation")), generation);
    json_decref(message);
}

static inline json_t *slideshow(hall *h)
{
    json_t *answer = live_call(&h->c, "status", NULL);
    json_t *now = json_incref(json_object_get(json_object_get(answer, "result"), "playlist"));
    assert_non_null(now);
    json_decref(answer);
    return now;
}

static inline bool is_playing(hall *h)
{
    json_t *now = slideshow(h);
    bool playing = json_is_true(json_object_get(now, "playing"));
    json_decref(now);
    return playing;
}

static inline int index_now(hall *h)
{
    json_t *now = slideshow(h);
    int index = (int)json_integer_value(json_object_get(now, "index"));
    json_decref(now);
    return index;
}

/* The answer is an error with this code, pointer and text. */
static inline void assert_refused(hall *h, const char *method, json_t *params, int code,
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

#endif
