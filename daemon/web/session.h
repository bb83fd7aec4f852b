/* session: one client of the gateway: its WebSocket, its connection to quiltd, and the images on
 * their way to it.
 *
 * Each message of the client is one request of JSON-RPC. Allowed methods go to quiltd, and lines of
 * quiltd come back as messages. Uploads and exports pass as descriptors. `preview.start`,
 * `preview.stop` and `preview.ack` are the gateway's own: an image is sent when quiltd shows
 * another one, at most four times a second, and never before the client has acknowledged the last.
 * A client that does not read holds up nobody: the gateway stops reading from its connection to
 * quiltd. Thread: event. */
#ifndef LF_DAEMON_WEB_SESSION_H
#define LF_DAEMON_WEB_SESSION_H

#include <systemd/sd-event.h>

#include "base/status.h"
#include "daemon/web/downloads.h"
#include "daemon/web/uploads.h"

typedef struct lf_session lf_session;

/* The session has ended: `fd` is not used any more. Called once, from the event loop; the session
 * may be destroyed in it. */
typedef void (*lf_session_ended_fn)(void *context, lf_session *session);

/* What has been passed to quiltd but not been sent yet, of all sessions. */
typedef lf_uploads_passed (*lf_session_passed_fn)(void *context);

/* What all sessions share; borrowed. */
typedef struct lf_session_home {
    sd_event *event;
    const char *socket; /* path of quiltd's */
    lf_uploads *uploads;
    lf_downloads *downloads;
    lf_session_passed_fn passed;
    void *context;
} lf_session_home;

/* fd, early[n]: as for lf_ws_create. If quiltd does not answer, the session begins all the same,
 * and closes with this reason. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_session_create(const lf_session_home *home, int fd, const void *early,
                                         size_t n, lf_session **out, lf_error *err);
/* Adds what this session has passed and not sent. */
void lf_session_add_passed(const lf_session *session, lf_uploads_passed *passed);
void lf_session_on_end(lf_session *session, lf_session_ended_fn fn, void *context);
/* Accepts NULL. */
void lf_session_destroy(lf_session *session);

#endif
