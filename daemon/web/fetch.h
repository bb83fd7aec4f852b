/* fetch: one call of quiltd over a connection of its own, for one HTTP request. The connection
 * gives up the right to call anything else. Thread: event. */
#ifndef LF_DAEMON_WEB_FETCH_H
#define LF_DAEMON_WEB_FETCH_H

#include <jansson.h>
#include <systemd/sd-event.h>

#include "base/status.h"

typedef struct lf_fetch lf_fetch;

typedef struct lf_fetch_call {
    const char *method;
    json_t *params;          /* borrowed; NULL: none */
    int fd;                  /* passed with the call and kept by the caller; -1: none */
    unsigned int patience_s; /* the fetch fails without an answer in this time */
} lf_fetch_call;

/* The answer is there. Called once, from the event loop, not from within lf_fetch_create; it may
 * not destroy the fetch. */
typedef void (*lf_fetch_done_fn)(void *context);

/* Begins. LF_E_NODEV: nobody listens at the path `socket`; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_fetch_create(sd_event *event, const char *socket,
                                       const lf_fetch_call *call, lf_fetch_done_fn done,
                                       void *context, lf_fetch **out, lf_error *err);
/* Accepts NULL. */
void lf_fetch_destroy(lf_fetch *fetch);
/* Makes an unfinished fetch fail and calls `done`. */
void lf_fetch_cancel(lf_fetch *fetch);

/* Before `done`: LF_E_BUSY. After it: LF_OK with the result, which stays the fetch's, or why it
 * failed. LF_E_STATE: quiltd answered with an error; its code is *out_code, its words are
 * err->what. */
LF_NODISCARD lf_status lf_fetch_result(const lf_fetch *fetch, const json_t **out_result,
                                       int *out_code, lf_error *err);

#endif
