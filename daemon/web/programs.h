/* programs: what quiltweb does for programs of Looking Glass panels besides HTTP: the commands of
 * the older protocol, its Unix socket, and a panel that is lent. Thread: event. */
#ifndef LF_DAEMON_WEB_PROGRAMS_H
#define LF_DAEMON_WEB_PROGRAMS_H

#include <systemd/sd-event.h>

#include "base/status.h"
#include "daemon/web/driver.h"

typedef struct lf_programs lf_programs;

typedef struct lf_programs_config {
    const char *socket;   /* path of quiltd's */
    const char *version;  /* of Bridge, that is said */
    uint64_t image_limit; /* bytes of one image */
    bool panel_only;
    const char *nng_path; /* of a Unix socket to be made; NULL: none */
    int nng_fd;           /* a listening one, which is taken, also after failure; -1: none */
} lf_programs_config;

/* LF_E_ARG: both sockets, or one that is something else; LF_E_BUSY, LF_E_EXISTS, LF_E_IO: the path
 * cannot be used; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_programs_create(sd_event *event, const lf_programs_config *config,
                                          lf_programs **out, lf_error *err);
/* After the server of HTTP. Accepts NULL. */
void lf_programs_destroy(lf_programs *programs);

/* Both stay the programs'. The panel is NULL if it is not lent. */
lf_driver *lf_programs_driver(const lf_programs *programs);
lf_panel_only *lf_programs_panel(const lf_programs *programs);

#endif
