/* guard: what a request must be before quiltweb looks at what it asks for.
 *
 * Any page in a browser can send requests to a loopback address. The Host header shows names that
 * were rebound to it, the Origin header shows pages of others, and a secret shows that the caller
 * was given the URL. libmicrohttpd accepts some requests that two readers understand differently;
 * they are refused here. Pure functions: no sockets, no state but the guard. Thread: any. */
#ifndef LF_DAEMON_WEB_GUARD_H
#define LF_DAEMON_WEB_GUARD_H

#include <stdint.h>

#include "daemon/web/origins.h"
#include "daemon/web/secret.h"

/* The headers that decide. Texts are borrowed; NULL: the header is absent. With several headers of
 * a name, the text is the last and the count says so. */
typedef struct lf_guard_request {
    const char *target; /* path without the query */
    const char *host, *origin, *length, *cookie, *authorization, *site;
    int hosts, origins, lengths, cookies, authorizations, sites; /* site: Sec-Fetch-Site */
    bool zero;                                                   /* the path holds a zero byte */
    bool encoded;                                                /* has a Transfer-Encoding */
    bool takes_body;      /* the method of this path has a body … */
    uint64_t body_limit;  /* … of so many bytes at most; … */
    const char *too_long; /* … a longer one is refused with these words */
} lf_guard_request;

enum { LF_GUARD_NAMES = 3, LF_GUARD_MAX_ORIGIN = 272 };

typedef struct lf_guard {
    char hosts[LF_GUARD_NAMES][32]; /* accepted values of Host: "localhost:PORT" … */
    /* Origin of the page behind a server with TLS, "https://NAME" or "https://NAME:PORT"; "": none.
     * What follows https:// is one more accepted Host. */
    char public_origin[LF_GUARD_MAX_ORIGIN];
    char cookie[32];   /* name of the cookie; holds the port, which cookies ignore */
    lf_secret token;   /* in the URL, and after "Bearer " */
    lf_secret session; /* in the cookie */
    /* Of a service of programs, which has no secrets: pages that may ask there, besides programs
     * without an Origin; borrowed. NULL: the service is the page's. */
    const lf_origins *allowed;
} lf_guard;

/* Draws both secrets for a server at this port. LF_E_IO. */
LF_NODISCARD lf_status lf_guard_init(lf_guard *guard, int port, lf_error *err);
/* The guard of a service of programs at this port. allowed: borrowed. */
void lf_guard_init_programs(lf_guard *guard, int port, const lf_origins *allowed);

/* Sets public_origin. LF_E_ARG: not https:// with a name in lower case, and perhaps a port; or it
 * is one of `hosts`, whose pages come by http. */
LF_NODISCARD lf_status lf_guard_set_public(lf_guard *guard, const char *origin, lf_error *err);

/* 0, or the status of HTTP with which the request is refused; *out_why: a line for the body.
 * - 421: not exactly one Host with a name and port of ours
 * - 400: absolute target, a zero byte in the path, two lengths, cookies or authorizations, a
 * Transfer-Encoding
 * - 411: no length where a body is expected
 * - 413: a body where none is expected, or a longer one
 * - 403: an Origin that is not ours, or not allowed at a service of programs */
int lf_guard_check(const lf_guard *guard, const lf_guard_request *request, const char **out_why);

/* True if the request came through the server of public_origin. */
bool lf_guard_is_public(const lf_guard *guard, const lf_guard_request *request);
/* True if the request has the token as Authorization: Bearer. */
bool lf_guard_has_token(const lf_guard *guard, const lf_guard_request *request);
/* True if the request has the cookie of the session. */
bool lf_guard_has_cookie(const lf_guard *guard, const lf_guard_request *request);
/* True if the request may get an answer that is not for everybody: with the token, or with the
 * cookie from our page. Browsers say in Sec-Fetch-Site whose page it is; without it, it may be
 * ours.
 */
bool lf_guard_may_read(const lf_guard *guard, const lf_guard_request *request);
/* True if the request may send a body: from our page with the cookie or the token, or from a
 * program (no Origin) with the token. lf_guard_check has passed. */
bool lf_guard_may_write(const lf_guard *guard, const lf_guard_request *request);
/* True if the request may open a WebSocket: from our page with the cookie, or from a program (no
 * Origin) with the token. lf_guard_check has passed. */
bool lf_guard_may_connect(const lf_guard *guard, const lf_guard_request *request);

#endif
