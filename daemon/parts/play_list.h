/* playlist: a slideshow of files, with at most one load in progress. It depends on neither files
 * nor server: its owner loads the entries it requests and reports the outcome.
 *
 * An entry is shown for its seconds. Without them a video is shown once through, and anything else
 * for the list's seconds. A video of one frame is a picture. Thread: event. */
#ifndef LF_DAEMON_PLAY_LIST_H
#define LF_DAEMON_PLAY_LIST_H

#include <jansson.h>
#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

#define LF_PLAYLIST_SECONDS 10.0 /* default */

typedef struct lf_playlist lf_playlist;

typedef struct lf_playlist_entry {
    char *file;     /* absolute, by lf_strdup */
    double seconds; /* 0: not given */
    json_t *keys;   /* how the file is shown, for the owner; a reference; NULL: none */
    bool told;      /* private: its failure is in the log */
} lf_playlist_entry;

/* How the entries are played. */
typedef struct lf_playlist_how {
    double seconds; /* of entries that are no videos and have none; > 0 */
    bool loop;
    double crossfade; /* seconds, for the owner */
} lf_playlist_how;

typedef struct lf_playlist_events {
    /* Load this entry. once: a video is to hold its last frame instead of looping; changes of that
     * are in lf_playlist_state.once. Call
     * lf_playlist_loaded when the load has ended, but not from within. False: not possible, which
     * ends the playlist's run. */
    bool (*due)(void *context, const lf_playlist_entry *entry, bool once);
    /* The load in progress is of no use any more. lf_playlist_loaded is still called. */
    void (*vain)(void *context);
    /* The entries, the current one, or whether they are played or paused has changed. Of entries
     * that fail one after another it is called once, when one is loaded or the list stops. */
    void (*changed)(void *context);
} lf_playlist_events;

/* What is known of it; borrowed until the next call. */
typedef struct lf_playlist_state {
    const lf_playlist_entry *entries;
    int64_t turn; /* counts the times that an entry was to be loaded; of the last one */
    int n;
    int index; /* of the current entry; 0 without entries */
    bool playing;
    bool paused; /* only while it is played */
    bool loads;  /* the current entry is being loaded */
    bool waits;  /* the panel does not show the current entry yet */
    bool once;   /* if the current entry is a video, it is to hold its last frame at the end */
    lf_playlist_how how;
} lf_playlist_state;

/* events is copied, event borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_playlist_create(sd_event *event, const lf_playlist_events *events,
                                          void *context, lf_playlist **out_playlist);
/* Accepts NULL. */
void lf_playlist_destroy(lf_playlist *playlist);
void lf_playlist_entries_free(lf_playlist_entry *entries, int n);

/* Replaces the entries; takes ownership. If the list is played and the new entries have the file of
 * the current one, that file stays: it is shown for its new time, and loaded again only if its keys
 * differ. Otherwise the first new entry is shown. No entries: the list stops. */
void lf_playlist_set(lf_playlist *playlist, lf_playlist_entry *entries, int n,
                     const lf_playlist_how *how);
/* Replaces the seconds and the keys of an entry (0..n-1); takes a reference to keys. If the list
 * shows it and the keys differ, it is loaded again, after the load in progress, and its time goes
 * on. The event `changed` follows if something differs. */
void lf_playlist_change(lf_playlist *playlist, int index, double seconds, json_t *keys);
/* Shows an entry, and each next one after the entry's seconds, which count from its first coarse
 * frame. index -1: where it stopped, or the first after the end; a list that is played goes on. A
 * loop of one entry is loaded once. Ends a pause. Does nothing if there is no such entry. */
void lf_playlist_play(lf_playlist *playlist, int index);
/* Stops the time of the entry that is shown, or lets it go on; the owner pauses a video. Steps work
 * meanwhile. Does nothing if the list is not played. */
void lf_playlist_pause(lf_playlist *playlist, bool paused);
/* The entry that is shown stays. */
void lf_playlist_stop(lf_playlist *playlist);
/* Shows the next entry (1) or the previous one (-1), also if the list is not played. Does nothing
 * at an end without loop, and without entries. */
void lf_playlist_step(lf_playlist *playlist, int step);
/* Outcome of the requested load: its generation, and whether it is a video. err not NULL: it
 * failed. The entry is then skipped, in the direction of the last step, with one line in the log
 * until the entry has been shown or replaced. If that leads back to the entry on the panel, its
 * time starts again. If all entries fail one after another, the list stops with a line. */
void lf_playlist_loaded(lf_playlist *playlist, int64_t generation, bool is_movie,
                        const lf_error *err);
/* The video of this generation has only one frame: it counts as a picture. May be repeated. */
void lf_playlist_still(lf_playlist *playlist, int64_t generation);
/* The video of this generation has played through, once more or for good, or cannot go on (err).
 * May be repeated. False: it is not the video of the current entry, so err has no line in the
 * log. */
bool lf_playlist_played(lf_playlist *playlist, int64_t generation, const lf_error *err);
/* The panel shows this generation at this level. */
void lf_playlist_shown(lf_playlist *playlist, int64_t generation, lf_level level);
lf_playlist_state lf_playlist_now(const lf_playlist *playlist);

#endif
