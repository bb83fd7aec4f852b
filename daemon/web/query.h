/* query: the parameters behind "?" of a request. Thread: event. */
#ifndef LF_DAEMON_WEB_QUERY_H
#define LF_DAEMON_WEB_QUERY_H

#include <jansson.h>
#include <microhttpd.h>

#include "base/status.h"

typedef enum lf_query_type { LF_QUERY_TEXT, LF_QUERY_WHOLE, LF_QUERY_NUMBER } lf_query_type;

typedef struct lf_query_key {
    const char *name;  /* NULL: the end of the list */
    const char *param; /* its name in the call of quiltd */
    lf_query_type type;
    bool required;
} lf_query_key;

/* Reads the parameters of a request as an object of their params, a new reference. Texts must be
 * UTF-8 without a zero byte. LF_E_ARG: an unknown, repeated or missing parameter, or another type;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_query_read(struct MHD_Connection *connection, const lf_query_key *keys,
                                     json_t **out, lf_error *err);

#endif
