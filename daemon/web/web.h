/* web: the gateway: an HTTP server on a loopback address (libmicrohttpd) in an event loop.
 *
 * It serves the page, exchanges the token for a cookie, answers /api/status and /preview.jpg, and
 * makes sessions of WebSockets at /rpc. guard.h says what is refused before anything else. A
 * connection carries one request and ends 10 s after it began, unless it became a WebSocket.
 * Headers have at most 32 kB, and no request has a body. Thread: event. */
#ifndef LF_DAEMON_WEB_WEB_H
#define LF_DAEMON_WEB_WEB_H

#include <systemd/sd-event.h>

#include "base/status.h"

#define LF_WEB_MAX_SESSIONS 16    /* WebSockets */
#define LF_WEB_MAX_CONNECTIONS 64 /* of all kinds */

typedef struct lf_web lf_web;

/* Opens a listening socket at "127.0.0.1:PORT" or "[::1]:PORT"; port 0: any free one. The caller
 * owns *out_fd. LF_E_ARG: another address; LF_E_BUSY: the port is in use; LF_E_IO. */
LF_NODISCARD lf_status lf_web_listen(const char *address, int *out_fd, lf_error *err);

/* Serves listen_fd, a listening TCP socket on a loopback address, for the quiltd at the path
 * socket. Takes ownership of listen_fd, also after failure. LF_E_ARG: listen_fd is something else.
 */
LF_NODISCARD lf_status lf_web_create(sd_event *event, int listen_fd, const char *socket,
                                     lf_web **out, lf_error *err);
/* Ends all sessions. Accepts NULL. */
void lf_web_destroy(lf_web *web);

/* The URL of the page with the token in its fragment: "http://127.0.0.1:8033/#…". */
const char *lf_web_url(const lf_web *web);
int lf_web_port(const lf_web *web);
/* Number of WebSockets. */
int lf_web_sessions(const lf_web *web);

#endif
