/* web_child: quiltweb as a child of this process. It prints the URL of its page to our standard
 * output and its errors to our standard error. It ends with this process, however that ends: its
 * standard input is a pipe of ours. It is started once, and is not started again after its end.
 * Thread: event. */
#ifndef LF_DAEMON_WEB_CHILD_H
#define LF_DAEMON_WEB_CHILD_H

#include <systemd/sd-event.h>

#include "base/status.h"

typedef struct lf_web_child lf_web_child;

/* Starts quiltweb for the quiltd at the path `socket`; port 0: any free one. SIGCHLD must be
 * blocked. If it fails (exit status 1), it says why itself. Any other end before
 * lf_web_child_stop is one line in the log. LF_E_IO: it was not found or could not be started;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_web_child_create(sd_event *event, const char *socket, int port,
                                           lf_web_child **out, lf_error *err);
/* Lets it end. Accepts NULL. */
void lf_web_child_stop(lf_web_child *child);
/* Also waits for its end, at most a fifth of a second; then it is killed. Accepts NULL. */
void lf_web_child_destroy(lf_web_child *child);

#endif
