/* playlist: a slideshow of files, with at most one load in progress. It depends on neither files
 * nor server: its owner loads the entries it requests and reports the outcome. Thread: event. */
#ifndef LF_DAEMON_PLAY_LIST_H
#define LF_DAEMON_PLAY_LIST_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

typedef struct lf_playlist lf_playlist;

typedef struct lf_playlist_entry {
    char *file; /* absolute, by lf_strdup */
    double seconds;
    bool told; /* private: its failure is in the log */
} lf_playlist_entry;

typedef struct lf_playlist_events {
    /* Load this file. Call lf_playlist_loaded when the load has ended, but not from within. False:
     * not possible, which ends the playlist's run. */
    bool (*due)(void *context, const char *file);
    /* The load in progress is of no use any more. lf_playlist_loaded is still called. */
    void (*vain)(void *context);
    /* The entries, the current one, or whether they are played has changed. Of entries that fail
     * one after another it is called once, when one is loaded or the list stops. */
    void (*changed)(void *context);
} lf_playlist_events;

/* What is known of it; borrowed until the next call. */
typedef struct lf_playlist_state {
    const lf_playlist_entry *entries;
    int n;
    int index; /* of the current entry; 0 without entries */
    bool playing, loop;
    bool loads; /* the current entry is being loaded */
} lf_playlist_state;

/* events is copied, event borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_playlist_create(sd_event *event, const lf_playlist_events *events,
                                          void *context, lf_playlist **out_playlist);
/* Accepts NULL. */
void lf_playlist_destroy(lf_playlist *playlist);
void lf_playlist_entries_free(lf_playlist_entry *entries, int n);

/* Replaces the entries; takes ownership. If the list is played and the new entries have the file of
 * the current one, that file stays: it is shown for its new time. Otherwise the first new entry is
 * shown. No entries: the list stops. */
void lf_playlist_set(lf_playlist *playlist, lf_playlist_entry *entries, int n, bool loop);
/* Shows an entry, and each next one after the entry's seconds, which count from its first coarse
 * frame. index -1: where it stopped, or the first after the end; a list that is played goes on. A
 * loop of one entry is loaded once. Does nothing if there is no such entry. */
void lf_playlist_play(lf_playlist *playlist, int index);
/* The entry that is shown stays. */
void lf_playlist_stop(lf_playlist *playlist);
/* Shows the next entry (1) or the previous one (-1), also if the list is not played. Does nothing
 * at an end without loop, and without entries. */
void lf_playlist_step(lf_playlist *playlist, int step);
/* Outcome of the requested load: its generation. err not NULL: it failed. The entry is then
 * skipped, in the direction of the last step, with one line in the log until the entry has been
 * shown or replaced. If that leads back to the entry on the panel, its time starts again. If all
 * entries fail one after another, the list stops with a line. */
void lf_playlist_loaded(lf_playlist *playlist, int64_t generation, const lf_error *err);
/* The panel shows this generation at this level. */
void lf_playlist_shown(lf_playlist *playlist, int64_t generation, lf_level level);
lf_playlist_state lf_playlist_now(const lf_playlist *playlist);

#endif
