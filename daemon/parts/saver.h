/* saver: saves and resumes the daemon's accumulations in the folder of --state. It locks the folder
 * and decides when to save; its owner knows what to save and how. Thread: event, except the
 * callback `save`. */
#ifndef LF_DAEMON_SAVER_H
#define LF_DAEMON_SAVER_H

#include <systemd/sd-event.h>

#include "daemon/engine/states.h"
#include "daemon/threads/inbox.h"

/* A picture is saved this long after it is first shown, and then at this interval, so that with the
 * time of saving at most 60 s are lost. */
#define LF_SAVE_USEC UINT64_C(45000000)

typedef struct lf_saver lf_saver;

/* An accumulation, which only grows within a generation. */
typedef struct lf_saved {
    int64_t generation;
    double passes;
} lf_saved;

typedef struct lf_saver_events {
    /* The accumulation to save; false: none. */
    bool (*asked)(void *context, lf_saved *out_now);
    /* Saves it. LF_E_STATE: it must not be saved. Thread: the saver's, or the event thread for
     * lf_saver_save_now; never both at once. */
    lf_status (*save)(void *context, lf_error *err);
    /* A save on the saver's thread has ended. */
    void (*ended)(void *context);
} lf_saver_events;

/* Environment of the saver; all of it is borrowed and must outlive it. */
typedef struct lf_saver_home {
    const char *folder; /* NULL: nothing is saved */
    uint64_t usec;      /* LF_SAVE_USEC */
    sd_event *event;
    lf_inbox *inbox; /* read by the event thread */
} lf_saver_home;

/* Locks the folder for this process until its end, and opens its states. events is copied.
 * LF_E_BUSY: another process has the lock; LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_saver_create(const lf_saver_home *home, const lf_saver_events *events,
                                       void *context, lf_saver **out_saver, lf_error *err);
/* Not while it is busy. Accepts NULL. */
void lf_saver_destroy(lf_saver *saver);
/* The states of the folder; NULL without one. */
lf_states *lf_saver_states(lf_saver *saver);
/* A new picture is shown. */
void lf_saver_begin(lf_saver *saver);
/* The picture resumed from a saved state, which need not be saved again. */
void lf_saver_restored(lf_saver *saver, const lf_saved *state);
/* True while a save is in progress. */
bool lf_saver_is_busy(const lf_saver *saver);
/* From now on only lf_saver_save_now saves. */
void lf_saver_stop(lf_saver *saver);
/* (blocks) Saves unsaved passes on this thread, and tells systemd how long that may take. Not while
 * a save is in progress. */
void lf_saver_save_now(lf_saver *saver);

#endif
