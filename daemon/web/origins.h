/* origins: pages of others that may ask at the services of programs (--allow-origin). Thread: any.
 */
#ifndef LF_DAEMON_WEB_ORIGINS_H
#define LF_DAEMON_WEB_ORIGINS_H

#include "base/status.h"

enum { LF_ORIGINS_MOST = 16, LF_ORIGINS_MAX_TEXT = 272 };

/* Stands for any port of localhost, 127.0.0.1 and [::1] by http. */
#define LF_ORIGINS_LOCAL "http://localhost:*"

typedef struct lf_origins {
    int n;
    bool local;
    char text[LF_ORIGINS_MOST][LF_ORIGINS_MAX_TEXT];
} lf_origins;

/* Adds "http://NAME", "https://NAME", either with ":PORT", or LF_ORIGINS_LOCAL. LF_E_ARG: it is
 * something else, for example "null" or "*", or there are too many. */
LF_NODISCARD lf_status lf_origins_add(lf_origins *origins, const char *text, lf_error *err);
/* True for the very text that was added, and for what LF_ORIGINS_LOCAL stands for. */
bool lf_origins_have(const lf_origins *origins, const char *origin);

/* Pages that were refused, and are told of once. */
enum { LF_STRANGERS_MOST = 64 };
typedef struct lf_strangers {
    int n;
    struct {
        int service;
        char origin[64]; /* its start */
    } told[LF_STRANGERS_MOST];
} lf_strangers;

/* True if this page is new at this service, and not too many were told of. */
bool lf_strangers_meet(lf_strangers *strangers, int service, const char *origin);
/* Why it is refused and what to do, for the log and the program. */
void lf_origins_refusal(const char *origin, lf_error *out);

#endif
