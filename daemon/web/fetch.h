/* fetch: one question to quiltd over a connection of its own, for one HTTP request. Thread: event.
 */
#ifndef LF_DAEMON_WEB_FETCH_H
#define LF_DAEMON_WEB_FETCH_H

#include <systemd/sd-event.h>

#include "base/status.h"

typedef struct lf_fetch lf_fetch;

typedef enum lf_fetch_kind {
    LF_FETCH_STATUS, /* the result of `status` as JSON */
    LF_FETCH_STILL,  /* the middle view as a JPEG */
} lf_fetch_kind;

/* The answer is there. Called once, from the event loop, not from within lf_fetch_create; it may
 * not destroy the fetch. */
typedef void (*lf_fetch_done_fn)(void *context);

/* Begins. If quiltd does not answer within 8 s, the fetch fails. LF_E_NODEV: nobody listens at the
 * path `socket`. */
LF_NODISCARD lf_status lf_fetch_create(sd_event *event, const char *socket, lf_fetch_kind kind,
                                       lf_fetch_done_fn done, void *context, lf_fetch **out,
                                       lf_error *err);
/* Accepts NULL. */
void lf_fetch_destroy(lf_fetch *fetch);
/* Makes an unfinished fetch fail and calls `done`. */
void lf_fetch_cancel(lf_fetch *fetch);

/* Before `done`: LF_E_BUSY. After it: LF_OK, or why it failed (LF_E_STATE: quiltd answered with an
 * error, for example that nothing is shown). Of a status, *out_text is the JSON, terminated, which
 * stays the fetch's. Of a still, *out_fd is its file with *out_size bytes, which the caller closes.
 */
LF_NODISCARD lf_status lf_fetch_result(lf_fetch *fetch, const char **out_text, int *out_fd,
                                       size_t *out_size, lf_error *err);

#endif
