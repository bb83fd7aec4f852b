/* peer: a connection of HTTP. libmicrohttpd keeps it as the context of the connection. */
#ifndef LF_DAEMON_WEB_PEER_H
#define LF_DAEMON_WEB_PEER_H

#include <microhttpd.h>
#include <stdbool.h>

#include "daemon/web/patience.h"
#include "daemon/web/service.h"

typedef struct lf_peer lf_peer;
struct lf_peer {
    lf_peer *next; /* older */
    lf_patience *patience;
    lf_service service;                 /* that it came in at */
    const struct lf_seat_kind *offered; /* who will sit behind its WebSocket */
    const char *origin; /* of a page at a service of programs, which may read answers; NULL: none */
    bool asked;         /* the headers of a request have come */
    bool zero;          /* the path of the request holds a zero byte */
};

/* NULL: it could not be made. */
lf_peer *lf_peer_of(struct MHD_Connection *connection);

#endif
