/* A slideshow without a server, by a clock of the test's own (wrap_test_playlist): which files are
 * asked for, and when. */
#ifndef LF_TESTS_DAEMON_PLAYLIST_OWNER_H
#define LF_TESTS_DAEMON_PLAYLIST_OWNER_H

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

static inline bool on_due(void *context, const lf_playlist_entry *entry, bool once)
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

static inline void on_vain(void *context)
{
    owner *o = context;
    assert_true(o->on_its_way);
    o->n_vain++;
}

static inline void on_changed(void *context)
{
    owner *o = context;
    o->n_changed++;
}

static inline int set_up(void **state)
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

static inline int tear_down(void **state)
{
    owner *o = *state;
    lf_playlist_destroy(o->list);
    sd_event_unref(o->event);
    free(o);
    return 0;
}

/* Each letter is a file; entry i is shown for 1 + i seconds. */
static inline void set(owner *o, const char *files, bool loop)
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

static inline void load(owner *o)
{
    assert_true(o->on_its_way);
    o->on_its_way = false;
    lf_playlist_loaded(o->list, ++o->generation, false, NULL);
}

static inline void fail_load(owner *o)
{
    lf_error err;
    (void)lf_error_set(&err, LF_E_FORMAT, "file", "is damaged");
    assert_true(o->on_its_way);
    o->on_its_way = false;
    lf_playlist_loaded(o->list, 0, false, &err);
}

static inline void show(owner *o, lf_level level)
{
    lf_playlist_shown(o->list, o->generation, level);
}

/* Expects this file, and shows it. */
static inline void shows(owner *o, const char *file)
{
    assert_string_equal(asked(o), file);
    load(o);
    show(o, LF_LEVEL_COARSE);
}

/* Expects this file, which is damaged. */
static inline void fails(owner *o, const char *file)
{
    assert_string_equal(asked(o), file);
    fail_load(o);
}

/* The timer that was set; negative: none. */
static inline double timer(void)
{
    double seconds = woken_in;
    woken_in = -1;
    return seconds;
}

/* Waits for the timer, which must be this long. */
static inline void wait_for(owner *o, double seconds)
{
    double in = timer();
    lf_assert_close(in, seconds, 0, 1e-5);
    clock_now += in;
    assert_true(sd_event_run(o->event, 0) >= 0);
}

static inline bool is_playing(const owner *o)
{
    return lf_playlist_now(o->list).playing;
}

static inline int index_of(const owner *o)
{
    return lf_playlist_now(o->list).index;
}

/* The log's lines with this text since the start of the program. */
static inline int count_lines(const char *text)
{
    lf_log_line line;
    int n = 0;
    for (int64_t i = 1; i <= lf_log_last(); i++)
        n += lf_log_line_at(i, &line) && strstr(line.text, text);
    return n;
}

#define list_test(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

#endif
