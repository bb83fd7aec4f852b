/* web: the gateway: an HTTP server on loopback addresses (libmicrohttpd) in an event loop.
 *
 * It serves the page, exchanges the token for a cookie, takes uploads, gives downloads, images and
 * numbers, and makes sessions of WebSockets at /rpc. Other services (service.h) are for programs
 * that speak to Looking Glass Bridge. guard.h says what is refused before anything else. A
 * connection carries one request and ends 10 s after it began, unless it becomes a WebSocket or
 * moves much data (patience.h). Headers have at most 32 kB. Thread: event. */
#ifndef LF_DAEMON_WEB_WEB_H
#define LF_DAEMON_WEB_WEB_H

#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"
#include "daemon/web/driver.h"
#include "daemon/web/listen.h"
#include "daemon/web/origins.h"
#include "daemon/web/service.h"

#define LF_WEB_MAX_SESSIONS 16    /* WebSockets of a service */
#define LF_WEB_MAX_CONNECTIONS 64 /* of the page's service */
#define LF_WEB_MAX_PROGRAMS 32    /* connections of each other service */
#define LF_WEB_URL_SIZE 320
#define LF_WEB_UPLOAD_LIMIT_MIB 1024

typedef struct lf_web lf_web;

typedef struct lf_web_config {
    /* Of each service: listening TCP sockets on loopback addresses, all at one port that no other
     * service has. None: the service is closed. The page's service has one at least. */
    lf_web_sockets services[LF_SERVICES];
    const lf_origins *allowed;  /* at the services of programs, copied; NULL: none */
    const char *socket;         /* path of quiltd's */
    const char *bridge_version; /* that programs of Bridge are told; NULL: LF_BRIDGE_VERSION */
    const char *public_origin;  /* of the page behind a server with TLS (guard.h); NULL: none */
    uint64_t upload_limit;      /* bytes of all uploads together */
    lf_driver *driver;          /* of the service of WebXR pages; borrowed; NULL: it has none */
    const lf_panel_only *panel_only; /* borrowed; NULL: quiltd keeps its panel */
} lf_web_config;

/* Takes ownership of the sockets, also after failure. LF_E_ARG: one of them, or the origin, is
 * something else. */
LF_NODISCARD lf_status lf_web_create(sd_event *event, const lf_web_config *config, lf_web **out,
                                     lf_error *err);
/* Ends all sessions. Accepts NULL. */
void lf_web_destroy(lf_web *web);

/* The URL of the page with the token in its fragment: "http://127.0.0.1:8033/#…", or at the
 * public origin. */
const char *lf_web_url(const lf_web *web);
/* The port of a service; 0: it is closed. */
int lf_web_port(const lf_web *web, lf_service service);
/* Number of WebSockets of all services. */
int lf_web_sessions(const lf_web *web);

#endif
