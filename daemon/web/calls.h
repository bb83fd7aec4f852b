/* calls: a connection to quiltd that stays: calls with their answers, and notifications. It begins
 * with the first call, gives up all other rights, and begins again if it broke. Thread: event. */
#ifndef LF_DAEMON_WEB_CALLS_H
#define LF_DAEMON_WEB_CALLS_H

#include <jansson.h>
#include <systemd/sd-event.h>

#include "base/status.h"

/* quiltd has so long for its oldest open call; then the connection ends. */
#define LF_CALLS_PATIENCE_S 30u

typedef struct lf_calls lf_calls;

/* An answer. result NULL: the call failed, and why says so in words. Both are borrowed. */
typedef void (*lf_calls_done_fn)(void *context, const json_t *result, const char *why);

/* They may ask, but not destroy. */
typedef struct lf_calls_events {
    /* A notification; borrowed. */
    void (*note)(void *context, const char *method, const json_t *params);
    /* The connection broke. Its calls fail after this. */
    void (*ended)(void *context);
    void *context;
} lf_calls_events;

/* socket: path of quiltd's, borrowed. methods: an array of strings, all that will be called;
 * subscriptions: events (subscribe). Both are taken. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_calls_create(sd_event *event, const char *socket, json_t *methods,
                                       json_t *subscriptions, const lf_calls_events *events,
                                       lf_calls **out, lf_error *err);
/* Open calls get no answer. Accepts NULL. */
void lf_calls_destroy(lf_calls *calls);

/* Calls a method. params: taken; NULL: none. `done` follows, not from within. LF_E_NODEV: quiltd
 * does not answer at its socket; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_calls_ask(lf_calls *calls, const char *method, json_t *params,
                                    lf_calls_done_fn done, void *context, lf_error *err);
/* Connects, for the sake of notifications. LF_E_NODEV, LF_E_NOMEM. */
LF_NODISCARD lf_status lf_calls_connect(lf_calls *calls, lf_error *err);
/* Nobody waits with this context any more. */
void lf_calls_forget(lf_calls *calls, const void *context);

#endif
