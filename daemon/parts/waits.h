/* waits: calls that wait until a picture is shown. Its owner knows what is shown and how to answer.
 * Thread: event. */
#ifndef LF_DAEMON_WAITS_H
#define LF_DAEMON_WAITS_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

typedef struct lf_waits lf_waits;

/* One wait: the call, its client and its target. */
typedef struct lf_wait {
    void *call;
    uint64_t client;
    int64_t generation;
    lf_level level;
    double seconds; /* timeout; 0 = none */
} lf_wait;

typedef enum lf_wait_state {
    LF_WAIT_ON,
    LF_WAIT_SHOWN, /* shown, but not yet in the files of a panel that writes some */
    LF_WAIT_OVER,
} lf_wait_state;

/* The queries are called for every wait at every look. answered, late and ended hand over the
 * call. */
typedef struct lf_waits_events {
    lf_wait_state (*state)(void *context, const lf_wait *wait);
    /* True if nobody waits for the answer any more. */
    bool (*is_vain)(void *context, const lf_wait *wait);
    /* Why there will be no picture; NULL: one may come. */
    const lf_error *(*failed)(void *context);
    /* Some waits lack only the panel's files. */
    void (*unwritten)(void *context);
    /* The target was reached. */
    void (*answered)(void *context, const lf_wait *wait);
    /* The timeout has passed. */
    void (*late)(void *context, const lf_wait *wait);
    /* The target cannot be reached. scene: err is about the scene. */
    void (*ended)(void *context, const lf_wait *wait, const lf_error *err, bool scene);
} lf_waits_events;

/* events is copied, event borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_waits_create(sd_event *event, const lf_waits_events *events,
                                       void *context, lf_waits **out_waits);
/* To be called when no wait is left. Accepts NULL. */
void lf_waits_destroy(lf_waits *waits);
/* Adds a wait, or answers at once if it is over. Takes ownership of the call. LF_E_BUSY: its client
 * has too many waits; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_waits_add(lf_waits *waits, const lf_wait *wait, lf_error *err);
/* Checks all waits, because the state may have changed. */
void lf_waits_look(lf_waits *waits);
/* If `failed` says that no picture will come, ends all waits with its error. */
void lf_waits_look_at_failure(lf_waits *waits);
/* Ends the waits that lack only files, with an error. */
void lf_waits_fail_files(lf_waits *waits, const lf_error *err);
/* Ends all waits with an error. Accepts NULL. */
void lf_waits_fail(lf_waits *waits, const lf_error *err, bool scene);

#endif
