/* saver: the accumulations that a daemon leaves behind in the folder of --state, and goes on with:
 * whose folder it is, and when is saved. What there is to save, and how, whoever made it knows.
 * Everything is the event thread's, but for the event `save`. */
#ifndef LF_DAEMON_SAVER_H
#define LF_DAEMON_SAVER_H

#include <systemd/sd-event.h>

#include "daemon/engine/states.h"
#include "daemon/threads/inbox.h"

/* A picture is saved when it has been shown for so long, and then once in each: at most 60 s are to
 * be lost, with what saving itself takes. */
#define LF_SAVE_USEC UINT64_C(45000000)

typedef struct lf_saver lf_saver;

/* An accumulation, which only grows within a generation. */
typedef struct lf_saved {
    int64_t generation;
    double passes;
} lf_saved;

typedef struct lf_saver_events {
    /* What there is to save; false: nothing. */
    bool (*asked)(void *context, lf_saved *out_now);
    /* Saves it. LF_E_STATE: it is not to be saved. Thread: the saver's, and for lf_saver_save_now
     * the event thread; never both at once. */
    lf_status (*save)(void *context, lf_error *err);
    /* A save on the saver's thread has ended. */
    void (*ended)(void *context);
} lf_saver_events;

/* Where a saver lives; all of it is borrowed and outlives it. */
typedef struct lf_saver_home {
    const char *folder; /* NULL: nothing is saved */
    uint64_t usec;      /* LF_SAVE_USEC */
    sd_event *event;
    lf_inbox *inbox; /* read by the event thread */
} lf_saver_home;

/* Locks the folder for this process alone, until its end, and opens its states; events is copied.
 * LF_E_BUSY: it is another's; LF_E_IO, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_saver_create(const lf_saver_home *home, const lf_saver_events *events,
                                       void *context, lf_saver **out_saver, lf_error *err);
/* Not while it is busy. Accepts NULL. */
void lf_saver_destroy(lf_saver *saver);
/* The states of the folder; NULL without one. */
lf_states *lf_saver_states(lf_saver *saver);
/* Another picture is shown. */
void lf_saver_begin(lf_saver *saver);
/* It goes on from a saved state, which need not be saved again. */
void lf_saver_restored(lf_saver *saver, const lf_saved *state);
/* Whether a save is under way. */
bool lf_saver_is_busy(const lf_saver *saver);
/* From now on no save is begun but by lf_saver_save_now. */
void lf_saver_stop(lf_saver *saver);
/* (blocks) Saves what is not saved yet, on this thread, and tells systemd how long that may take.
 * Not while it is busy. */
void lf_saver_save_now(lf_saver *saver);

#endif
