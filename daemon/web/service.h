/* service: whose requests come in at a port. Every listening socket belongs to a service, and each
 * service has a port, a guard and paths of its own. */
#ifndef LF_DAEMON_WEB_SERVICE_H
#define LF_DAEMON_WEB_SERVICE_H

typedef enum lf_service {
    LF_SERVICE_PAGE,   /* the page, and programs that know the token */
    LF_SERVICE_BRIDGE, /* requests of programs that speak to Looking Glass Bridge, by default 33334
                        */
    LF_SERVICE_EVENTS, /* what Bridge tells such programs, by default 9724 */
    LF_SERVICE_WEBXR,  /* pages that draw for themselves and ask for the panel, by default 11222 */
    LF_SERVICES,
} lf_service;

#endif
