/* rights: a connection to quiltd gives up, first of all, the methods that nobody needs on it. A
 * mistake of the gateway then cannot reach them. Thread: event. */
#ifndef LF_DAEMON_WEB_RIGHTS_H
#define LF_DAEMON_WEB_RIGHTS_H

#include <jansson.h>

#include "base/status.h"
#include "daemon/web/link.h"

typedef enum lf_rights_answer {
    LF_RIGHTS_NONE,    /* the message is another one */
    LF_RIGHTS_DONE,    /* the rights are limited, or quiltd is too old to know rights.limit */
    LF_RIGHTS_AGAIN,   /* quiltd lacks a method; it is off the list, which must be sent again */
    LF_RIGHTS_REFUSED, /* quiltd has refused */
} lf_rights_answer;

/* Asks quiltd to limit a connection to these methods, an array of strings. All other lines wait
 * until lf_link_go_on, which must follow LF_RIGHTS_DONE. LF_E_NOMEM, also if methods is NULL. */
LF_NODISCARD lf_status lf_rights_limit(lf_link *link, json_t *methods);
/* What a message of quiltd says to the call for these methods. err: why it was refused. */
lf_rights_answer lf_rights_read(const json_t *message, json_t *methods, lf_error *err);

#endif
