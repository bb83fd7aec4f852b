#include "daemon/parts/play_list.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/parts/play_pace.h"

struct lf_playlist {
    lf_playlist_events events;
    void *context;
    lf_pace pace;
    lf_playlist_entry *entries; /* owned */
    int64_t turn;               /* lf_playlist_state */
    int n, index;
    lf_playlist_how how;
    bool playing, paused;
    bool ended;    /* it has played its last entry … */
    bool holds;    /* … which stays, and a video's last frame with it */
    bool wanted;   /* the current entry is to be loaded */
    bool vain;     /* the load in progress is of an entry that is no longer current */
    bool loaded;   /* the current entry … */
    bool is_movie; /* … which is a video … */
    bool over;     /* … that has played through while the list was paused */
    bool timed;    /* its time runs … */
    double since;  /* … since then (lf_time_now) … */
    double shown;  /* … or stands still after so many seconds (paused) */
    int on_panel;  /* the last entry that was loaded while the list is played; -1: none */
    bool untold;   /* the current entry has changed since the last event `changed` */
    int step;      /* direction in which entries that fail are skipped */
    int n_failed;
};

void lf_playlist_entries_free(lf_playlist_entry *entries, int n)
{
    for (int i = 0; i < n; i++) {
        lf_free(entries[i].file);
        json_decref(entries[i].keys);
    }
    lf_free(entries);
}

static void tell(lf_playlist *playlist)
{
    playlist->untold = false;
    playlist->events.changed(playlist->context);
}

/* ------------------------------------------------------------------------------- its entries -- */

/* -1: none. */
static int neighbour(const lf_playlist *playlist, int step)
{
    const int index = playlist->index + step, n = playlist->n;
    if (index >= 0 && index < n)
        return index;
    return playlist->how.loop ? (index + n) % n : -1;
}

/* A loop of one entry stays. */
static bool is_followed(const lf_playlist *playlist)
{
    return neighbour(playlist, 1) != playlist->index;
}

/* Whether the current entry, if it is a video, is to hold its last frame. */
static bool is_once(const lf_playlist *playlist)
{
    return (playlist->playing || playlist->holds) && playlist->n > 0 &&
           !(playlist->entries[playlist->index].seconds > 0) && is_followed(playlist);
}

lf_playlist_state lf_playlist_now(const lf_playlist *playlist)
{
    return (lf_playlist_state){.entries = playlist->entries,
                               .turn = playlist->turn,
                               .n = playlist->n,
                               .index = playlist->index,
                               .playing = playlist->playing,
                               .paused = playlist->paused,
                               .loads = playlist->pace.on_its_way && !playlist->vain,
                               .waits = playlist->playing && !playlist->loaded,
                               .once = is_once(playlist),
                               .how = playlist->how};
}

static void halt(lf_playlist *playlist)
{
    playlist->playing = playlist->paused = playlist->wanted = playlist->timed = false;
    lf_pace_rest(&playlist->pace);
}

static void drop_load(lf_playlist *playlist)
{
    if (!playlist->pace.on_its_way || playlist->vain)
        return;
    playlist->vain = true;
    playlist->events.vain(playlist->context);
}

static void want(lf_playlist *playlist)
{
    playlist->wanted = true;
    playlist->turn++;
}

/* Loads the current entry, after the load in progress. */
static void load_wanted(lf_playlist *playlist)
{
    if (!playlist->wanted || playlist->pace.on_its_way)
        return;
    const lf_playlist_entry *entry = &playlist->entries[playlist->index];
    playlist->wanted = false;
    playlist->pace.on_its_way = playlist->events.due(playlist->context, entry, is_once(playlist));
    if (!playlist->pace.on_its_way)
        halt(playlist);
}

static void choose(lf_playlist *playlist, int index)
{
    playlist->index = index;
    want(playlist);
    playlist->loaded = playlist->timed = playlist->over = false;
    playlist->ended = playlist->holds = false;
    lf_pace_rest(&playlist->pace);
    drop_load(playlist);
    load_wanted(playlist);
}

/* ---------------------------------------------------------------------------------- its time -- */

/* INFINITY: until the video has played through. */
static double seconds_of(const lf_playlist *playlist)
{
    const double own = playlist->entries[playlist->index].seconds;
    if (own > 0)
        return own;
    return playlist->is_movie ? (double)INFINITY : playlist->how.seconds;
}

static void set_timer(const lf_playlist *playlist)
{
    const double seconds = seconds_of(playlist);
    if (is_followed(playlist) && !playlist->paused && isfinite(seconds))
        lf_pace_wake_at(&playlist->pace, playlist->since + seconds);
    else
        lf_pace_rest(&playlist->pace);
}

/* Starts the time of the current entry when it is shown. */
static void start_time(lf_playlist *playlist)
{
    if (!playlist->playing || !playlist->loaded || playlist->timed ||
        !lf_pace_is_shown(&playlist->pace))
        return;
    playlist->timed = true;
    playlist->since = lf_time_now();
    playlist->shown = 0;
    set_timer(playlist);
}

static void end(lf_playlist *playlist)
{
    halt(playlist);
    playlist->ended = playlist->holds = true;
}

/* The current entry was shown as long as it should be. */
static void go_on(lf_playlist *playlist)
{
    const int next = neighbour(playlist, 1);
    playlist->step = 1;
    playlist->n_failed = 0;
    playlist->entries[playlist->index].told = false;
    if (next >= 0)
        choose(playlist, next);
    else
        end(playlist);
    tell(playlist);
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    go_on(context);
    return 0;
}

void lf_playlist_shown(lf_playlist *playlist, int64_t generation, lf_level level)
{
    lf_pace_shown(&playlist->pace, generation, level);
    start_time(playlist);
}

/* ---------------------------------------------------------------------------------- failures -- */

static void tell_failure(lf_playlist *playlist, const lf_error *err)
{
    lf_playlist_entry *entry = &playlist->entries[playlist->index];
    char text[sizeof *err + 32];
    if (!entry->told)
        lf_log(LF_LOG_WARNING, "playlist: entry %d is skipped: %s", playlist->index,
               lf_error_format(err, text, sizeof text));
    entry->told = true;
}

/* The current entry is loaded, now or by an earlier load. A video may fail later, so that it counts
 * only after its time. */
static void succeed(lf_playlist *playlist)
{
    playlist->loaded = true;
    playlist->on_panel = playlist->index;
    if (!playlist->is_movie)
        playlist->n_failed = 0;
    playlist->step = 1;
    start_time(playlist);
}

/* The next entry in the same direction, or at the first one forwards again. One that is still on
 * the panel is not loaded again, unless it is a video, which may have ended. A run of entries that
 * fail is told at its end. */
static void skip(lf_playlist *playlist)
{
    int next = neighbour(playlist, playlist->step);
    playlist->untold = false;
    if (next < 0 && playlist->step < 0) {
        playlist->step = 1;
        next = neighbour(playlist, 1);
    }
    if (++playlist->n_failed >= playlist->n) {
        lf_log(LF_LOG_WARNING, "playlist: none of its %d %s can be shown; it stops", playlist->n,
               playlist->n == 1 ? "entry" : "entries");
        halt(playlist);
    } else if (next < 0) {
        end(playlist);
    } else if (playlist->playing && next == playlist->on_panel && !playlist->is_movie) {
        playlist->index = next;
        succeed(playlist);
    } else {
        choose(playlist, next);
        playlist->untold = playlist->pace.on_its_way;
    }
    if (!playlist->untold)
        tell(playlist);
}

static void take_load(lf_playlist *playlist, bool is_movie)
{
    playlist->is_movie = is_movie;
    if (!is_movie)
        playlist->entries[playlist->index].told = false;
    succeed(playlist);
    if (playlist->untold)
        tell(playlist);
    load_wanted(playlist); /* it was changed meanwhile */
}

void lf_playlist_loaded(lf_playlist *playlist, int64_t generation, bool is_movie,
                        const lf_error *err)
{
    lf_pace_loaded(&playlist->pace, generation);
    if (playlist->vain) {
        playlist->vain = false;
        if (!err) /* too late to be cancelled */
            playlist->on_panel = -1;
        load_wanted(playlist);
    } else if (err) {
        tell_failure(playlist, err);
        skip(playlist);
    } else {
        take_load(playlist, is_movie);
    }
}

/* The video of this generation is the current entry's. */
static bool is_its_video(const lf_playlist *playlist, int64_t generation)
{
    return playlist->playing && playlist->loaded && playlist->is_movie &&
           generation >= playlist->pace.generation && !playlist->pace.on_its_way;
}

void lf_playlist_still(lf_playlist *playlist, int64_t generation)
{
    if (!is_its_video(playlist, generation))
        return;
    playlist->is_movie = false;
    playlist->entries[playlist->index].told = false;
    playlist->n_failed = 0;
    if (playlist->timed)
        set_timer(playlist);
}

bool lf_playlist_played(lf_playlist *playlist, int64_t generation, const lf_error *err)
{
    if (!is_its_video(playlist, generation))
        return false;
    if (err) {
        tell_failure(playlist, err);
        playlist->on_panel = -1;
        skip(playlist);
    } else if (isinf(seconds_of(playlist)) && is_followed(playlist)) {
        if (playlist->paused)
            playlist->over = true;
        else
            go_on(playlist);
    }
    return true;
}

/* --------------------------------------------------------------------------------- its owner -- */

/* The entry with this file, at `index` if possible; -1: none. */
static int find(const lf_playlist_entry *entries, int n, const char *file, int index)
{
    int at = 0;
    if (index < n && strcmp(entries[index].file, file) == 0)
        return index;
    while (at < n && strcmp(entries[at].file, file) != 0)
        at++;
    return at < n ? at : -1;
}

/* The file of the current entry stays, with the new time; changed: it is shown in another way. */
static void keep(lf_playlist *playlist, int index, bool changed)
{
    playlist->index = index;
    playlist->on_panel = playlist->loaded ? index : -1;
    if (playlist->timed)
        set_timer(playlist);
    if (changed) {
        want(playlist);
        load_wanted(playlist);
    }
}

/* Whether an entry is shown in another way. */
static bool differs(const json_t *keys, const json_t *others)
{
    return keys || others ? !json_equal(keys, others) : false;
}

static void forget(lf_playlist *playlist)
{
    halt(playlist);
    drop_load(playlist);
    playlist->index = 0;
    playlist->on_panel = -1;
    playlist->loaded = playlist->ended = playlist->holds = false;
}

void lf_playlist_set(lf_playlist *playlist, lf_playlist_entry *entries, int n,
                     const lf_playlist_how *how)
{
    const bool playing = playlist->playing;
    const lf_playlist_entry *current = playing ? &playlist->entries[playlist->index] : NULL;
    const int same = playing ? find(entries, n, current->file, playlist->index) : -1;
    const bool changed = same >= 0 && differs(current->keys, entries[same].keys);
    lf_playlist_entries_free(playlist->entries, playlist->n);
    playlist->entries = entries;
    playlist->n = n;
    playlist->how = *how;
    playlist->n_failed = 0;
    if (same >= 0) {
        keep(playlist, same, changed);
    } else {
        forget(playlist);
        playlist->playing = playing && n > 0;
        if (playlist->playing)
            choose(playlist, 0);
    }
    tell(playlist);
}

void lf_playlist_change(lf_playlist *playlist, int index, double seconds, json_t *keys)
{
    lf_playlist_entry *entry = &playlist->entries[index];
    const bool changed = differs(entry->keys, keys),
               news = changed || seconds < entry->seconds || seconds > entry->seconds;
    json_decref(entry->keys);
    entry->keys = json_incref(keys);
    entry->seconds = seconds;
    if (playlist->playing && index == playlist->index)
        keep(playlist, index, changed);
    if (news)
        tell(playlist);
}

static void show(lf_playlist *playlist, int index, int step)
{
    playlist->step = step;
    playlist->n_failed = 0;
    choose(playlist, index);
    tell(playlist);
}

void lf_playlist_play(lf_playlist *playlist, int index)
{
    if (index >= playlist->n || playlist->n == 0 || (index < 0 && playlist->playing))
        return;
    if (index < 0)
        index = playlist->ended ? 0 : playlist->index;
    if (!playlist->playing) {
        lf_log(LF_LOG_INFO, "playlist: plays %d %s", playlist->n,
               playlist->n == 1 ? "entry" : "entries");
        playlist->on_panel = -1; /* anything may have been shown meanwhile */
    }
    playlist->playing = true;
    playlist->paused = false;
    show(playlist, index, 1);
}

void lf_playlist_pause(lf_playlist *playlist, bool paused)
{
    if (!playlist->playing || paused == playlist->paused)
        return;
    const double now = lf_time_now();
    playlist->paused = paused;
    if (paused)
        playlist->shown = playlist->timed ? now - playlist->since : 0;
    else
        playlist->since = now - playlist->shown;
    if (playlist->timed)
        set_timer(playlist);
    if (!paused && playlist->over)
        go_on(playlist);
    else
        tell(playlist);
}

void lf_playlist_stop(lf_playlist *playlist)
{
    const bool playing = playlist->playing;
    halt(playlist);
    playlist->holds = false;
    drop_load(playlist);
    if (playing)
        lf_log(LF_LOG_INFO, "playlist: stopped at entry %d", playlist->index);
    if (playing || playlist->untold)
        tell(playlist);
}

void lf_playlist_step(lf_playlist *playlist, int step)
{
    const int next = playlist->n > 0 ? neighbour(playlist, step) : -1;
    if (next >= 0 && next != playlist->index)
        show(playlist, next, step);
}

/* ------------------------------------------------------------------------------ construction -- */

lf_status lf_playlist_create(sd_event *event, const lf_playlist_events *events, void *context,
                             lf_playlist **out_playlist)
{
    lf_playlist *playlist = lf_calloc(1, sizeof *playlist);
    if (!playlist)
        return LF_E_NOMEM;
    *playlist = (lf_playlist){.events = *events,
                              .context = context,
                              .how = {.seconds = LF_PLAYLIST_SECONDS, .loop = true},
                              .on_panel = -1,
                              .step = 1};
    if (lf_pace_init(&playlist->pace, event, on_time, playlist) != LF_OK) {
        lf_free(playlist);
        return LF_E_NOMEM;
    }
    *out_playlist = playlist;
    return LF_OK;
}

void lf_playlist_destroy(lf_playlist *playlist)
{
    if (!playlist)
        return;
    lf_pace_finish(&playlist->pace);
    lf_playlist_entries_free(playlist->entries, playlist->n);
    lf_free(playlist);
}
