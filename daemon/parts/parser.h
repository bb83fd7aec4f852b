/* parser: parses long lines of clients on a thread and frees the results there, because a mebibyte
 * of JSON takes tens of milliseconds. The client's next lines wait meanwhile. Thread: event, except
 * parsing. */
#ifndef LF_DAEMON_PARSER_H
#define LF_DAEMON_PARSER_H

#include "daemon/threads/inbox.h"
#include "daemon/wire/client.h"

/* Lines of at least this many bytes are long. */
#define LF_LONG_LINE ((size_t)16384)
/* For lines of at least this many bytes, the memory of the parsed value is returned to the system;
 * the value is twenty times as large. */
#define LF_HUGE_LINE ((size_t)262144)

typedef struct lf_parser lf_parser;

typedef struct lf_parser_events {
    /* The client, which is still connected, sends this request; both are borrowed. */
    void (*asked)(void *context, lf_client *client, const lf_rpc_request *request);
} lf_parser_events;

/* events is copied; inbox, read by the event thread, and clients are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_parser_create(lf_inbox *inbox, lf_clients *clients,
                                        const lf_parser_events *events, void *context,
                                        lf_parser **out_parser);
/* Queues a client's line for parsing. To be called from within lf_line_fn. False: out of memory. */
LF_NODISCARD bool lf_parser_queue(lf_parser *parser, lf_client *client, const char *text, size_t n);
/* Ends the thread; the inbox must be read once more before the parser is destroyed. Accepts NULL.
 */
void lf_parser_end(lf_parser *parser);
/* After lf_parser_end. Accepts NULL. */
void lf_parser_destroy(lf_parser *parser);

#endif
