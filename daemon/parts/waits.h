/* waits: calls that wait until a picture is shown. How they are answered, and what is shown,
 * whoever made them knows. Thread: event. */
#ifndef LF_DAEMON_WAITS_H
#define LF_DAEMON_WAITS_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

typedef struct lf_waits lf_waits;

/* What is waited for, and by whom. */
typedef struct lf_wait {
    void *call;
    uint64_t client;
    int64_t generation;
    lf_level level;
    double seconds; /* at most; 0 = for ever */
} lf_wait;

typedef enum lf_wait_state {
    LF_WAIT_ON,
    LF_WAIT_SHOWN, /* but not in the files of a panel that has some */
    LF_WAIT_OVER,
} lf_wait_state;

/* A question is asked for every wait at every look; calls that are answered are given up with it.
 */
typedef struct lf_waits_events {
    lf_wait_state (*state)(void *context, const lf_wait *wait);
    /* Whether nobody waits for the answer any more. */
    bool (*is_vain)(void *context, const lf_wait *wait);
    /* Why there will be no picture; NULL: one may come. */
    const lf_error *(*failed)(void *context);
    /* Some wait for files alone. */
    void (*unwritten)(void *context);
    /* What is waited for is there. */
    void (*answered)(void *context, const lf_wait *wait);
    /* It did not come within its seconds. */
    void (*late)(void *context, const lf_wait *wait);
    /* It will not come. scene: err is of the scene. */
    void (*ended)(void *context, const lf_wait *wait, const lf_error *err, bool scene);
} lf_waits_events;

/* events is copied, event borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_waits_create(sd_event *event, const lf_waits_events *events,
                                       void *context, lf_waits **out_waits);
/* When none is left. Accepts NULL. */
void lf_waits_destroy(lf_waits *waits);
/* Answers when it is over, at once where it is. The call is taken over. LF_E_BUSY: its client waits
 * too often already; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_waits_add(lf_waits *waits, const lf_wait *wait, lf_error *err);
/* Some may be over. */
void lf_waits_look(lf_waits *waits);
/* There may be no picture any more that could come. */
void lf_waits_look_at_failure(lf_waits *waits);
/* Ends those that wait for files alone with an error. */
void lf_waits_fail_files(lf_waits *waits, const lf_error *err);
/* Ends all with an error. Accepts NULL. */
void lf_waits_fail(lf_waits *waits, const lf_error *err, bool scene);

#endif
