/* exports: the exports of one client. quiltd writes into memory files of the gateway, and the
 * client fetches them over HTTP (downloads.h). Thread: event. */
#ifndef LF_DAEMON_WEB_EXPORTS_H
#define LF_DAEMON_WEB_EXPORTS_H

#include "daemon/web/downloads.h"
#include "daemon/wire/rpc.h"

/* Ids of the calls begin so. */
#define LF_EXPORTS_ID "quiltweb:export:"

typedef struct lf_exports lf_exports;

typedef struct lf_exports_events {
    /* A message for the client; taken. */
    void (*say)(void *context, json_t *message);
    /* A line for quiltd (taken, by malloc; NULL: out of memory) with descriptors, which are kept.
     */
    void (*ask)(void *context, char *line, const int *fds, int n_fds);
    void *context;
} lf_exports_events;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_exports_create(lf_downloads *downloads, const lf_exports_events *events,
                                         lf_exports **out, lf_error *err);
/* Drops what is not ready; quiltd ends these exports with the client's connection. Accepts NULL. */
void lf_exports_destroy(lf_exports *exports);

/* Takes a call of export and asks quiltd. LF_E_ARG: a kind without downloads, or not a name of a
 * file; LF_E_BUSY, LF_E_IO, LF_E_NOMEM: nothing was asked. */
LF_NODISCARD lf_status lf_exports_begin(lf_exports *exports, const lf_rpc_request *request,
                                        lf_error *err);
/* Looks at a message of quiltd. True: it is an answer to an export, and the client has got it with
 * its own id. */
bool lf_exports_answer(lf_exports *exports, json_t *message);
/* Looks at a notification `export` of quiltd, after the client has got it. When an export is done,
 * says `download`. */
void lf_exports_note(lf_exports *exports, const json_t *params);

#endif
