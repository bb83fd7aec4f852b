/* parser: long lines of clients are parsed on a thread, and what they were parsed into is freed
 * there: a mebibyte of JSON takes tens of milliseconds. Until then the client's next lines wait.
 * Thread: event, but for the parsing. */
#ifndef LF_DAEMON_PARSER_H
#define LF_DAEMON_PARSER_H

#include "daemon/threads/inbox.h"
#include "daemon/wire/client.h"

/* Lines from here on are long. */
#define LF_LONG_LINE ((size_t)16384)
/* What such lines were parsed into is given back to the system: it is twenty times as large. */
#define LF_HUGE_LINE ((size_t)262144)

typedef struct lf_parser lf_parser;

typedef struct lf_parser_events {
    /* The client, which is still there, asks for that; both are borrowed. */
    void (*asked)(void *context, lf_client *client, const lf_rpc_request *request);
} lf_parser_events;

/* events is copied; inbox, read by the event thread, and clients are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_parser_create(lf_inbox *inbox, lf_clients *clients,
                                        const lf_parser_events *events, void *context,
                                        lf_parser **out_parser);
/* Parses a client's line; from within lf_line_fn. false: out of memory. */
LF_NODISCARD bool lf_parser_queue(lf_parser *parser, lf_client *client, const char *text, size_t n);
/* Ends the thread; the inbox must be read once more before the parser is destroyed. Accepts NULL.
 */
void lf_parser_end(lf_parser *parser);
/* After lf_parser_end. Accepts NULL. */
void lf_parser_destroy(lf_parser *parser);

#endif
