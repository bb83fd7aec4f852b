/* notify: notifications to subscribed clients. Thread: event. */
#ifndef LF_DAEMON_NOTIFY_H
#define LF_DAEMON_NOTIFY_H

#include "daemon/wire/client.h"

/* Bits of lf_client_flags: the events a client subscribed to. */
enum {
    LF_EVENT_FRAME = 1,
    LF_EVENT_CONVERGED = 2,
    LF_EVENT_DEVICE = 4,
    LF_EVENT_SCENE = 8,
    LF_EVENT_EXPORT = 16,
    LF_EVENT_BUTTON = 32,
    LF_EVENT_LOG = 64,
    LF_EVENT_PLAYLIST = 128,
};

/* Sends a notification to the clients subscribed to `event`. Takes ownership of params. clients
 * NULL: no clients exist yet; nothing is sent. */
void lf_notify(lf_clients *clients, unsigned event, const char *method, json_t *params);

#endif
