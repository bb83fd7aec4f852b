/* nng: the older protocol (driver.h) over a Unix socket, as nng's transport ipc speaks it.
 *
 * Both sides greet with 8 bytes. Then each message is a byte 1, its length in 8 bytes, the highest
 * first, and the message. A client that greets as something else than REQ, or sends another kind of
 * message, is dropped; so is one that stands still for 20 s within a message. What a client does
 * not take of its answers is dropped. Thread: event. */
#ifndef LF_DAEMON_WEB_NNG_H
#define LF_DAEMON_WEB_NNG_H

#include <systemd/sd-event.h>

#include "base/status.h"
#include "daemon/web/driver.h"

#define LF_NNG_PATH "/tmp/holoplay-driver.ipc"

typedef struct lf_nng lf_nng;

/* fd: a listening Unix socket, which is taken, also after failure. driver: borrowed. LF_E_ARG: it
 * is something else; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_nng_create(sd_event *event, int fd, lf_driver *driver, lf_nng **out,
                                     lf_error *err);
/* Drops all clients. Accepts NULL. */
void lf_nng_destroy(lf_nng *nng);
int lf_nng_clients(const lf_nng *nng);

#endif
