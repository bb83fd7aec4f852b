/* link: one connection of the gateway to quiltd's socket. Sends lines, with descriptors if wanted,
 * and hands over the lines that come. Never blocks: what quiltd does not take yet is queued.
 * Thread: event. */
#ifndef LF_DAEMON_WEB_LINK_H
#define LF_DAEMON_WEB_LINK_H

#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"

typedef struct lf_link lf_link;

/* Both are called from the event loop alone, and may call lf_link_close but not lf_link_destroy. */
typedef struct lf_link_events {
    /* A line without its newline, not terminated. */
    void (*line)(void *context, const char *line, size_t n);
    /* quiltd closed the connection, or sent a line that is too long. Called once; the link is
     * closed. */
    void (*ended)(void *context);
    void *context;
} lf_link_events;

/* Connects to path. LF_E_NODEV: nobody listens there, or nobody accepts. */
LF_NODISCARD lf_status lf_link_create(sd_event *event, const char *path,
                                      const lf_link_events *events, lf_link **out, lf_error *err);
/* No event comes any more. Accepts NULL. */
void lf_link_close(lf_link *link);
/* Accepts NULL. Not from within an event of this link. */
void lf_link_destroy(lf_link *link);

/* Sends text[n] (one line, no newline). fd: passed with it and kept by the caller; -1: none. A
 * closed link takes nothing. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_link_send(lf_link *link, const char *text, size_t n, int fd);
/* As lf_link_send, with n_fds (0 to LF_LINK_MAX_FDS) descriptors. */
#define LF_LINK_MAX_FDS 64
LF_NODISCARD lf_status lf_link_send_fds(lf_link *link, const char *text, size_t n, const int *fds,
                                        int n_fds);
/* As lf_link_send, without a descriptor, before all lines that wait. Those, and all that follow,
 * wait until lf_link_go_on. */
LF_NODISCARD lf_status lf_link_send_ahead(lf_link *link, const char *text, size_t n);
void lf_link_go_on(lf_link *link);
/* Bytes that wait to be sent. */
size_t lf_link_queued(const lf_link *link);
/* Adds the descriptors that wait to be sent, and the bytes of their files. */
void lf_link_waiting(const lf_link *link, int *fds, uint64_t *bytes);
/* Stops or continues reading; quiltd then keeps what it sends. */
void lf_link_pause(lf_link *link, bool paused);

#endif
