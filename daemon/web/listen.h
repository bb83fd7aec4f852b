/* listen: the sockets that quiltweb listens on, all on loopback addresses. Those of a service are
 * at one port. Thread: any. */
#ifndef LF_DAEMON_WEB_LISTEN_H
#define LF_DAEMON_WEB_LISTEN_H

#include "base/status.h"

#define LF_WEB_MAX_LISTENERS 2 /* 127.0.0.1 and ::1 */

/* The listening sockets of a service. */
typedef struct lf_web_sockets {
    int fd[LF_WEB_MAX_LISTENERS];
    int n;
} lf_web_sockets;

/* Opens a listening socket at "127.0.0.1:PORT" or "[::1]:PORT"; port 0: any free one. The caller
 * owns *out_fd. LF_E_ARG: another address; LF_E_BUSY: the port is in use; LF_E_NODEV: the machine
 * has no such address; LF_E_IO. */
LF_NODISCARD lf_status lf_web_listen(const char *address, int *out_fd, lf_error *err);
/* Listens on n (1 or 2) addresses with the same port; with port 0, one that is free on all. Logs an
 * address that the machine lacks, and goes on with the other. The caller owns out_fds[*out_n].
 * Errors as above; LF_E_NODEV: the machine has none of them. */
LF_NODISCARD lf_status lf_web_listen_all(const char *const addresses[], int n,
                                         int out_fds[LF_WEB_MAX_LISTENERS], int *out_n,
                                         lf_error *err);
/* The same for both addresses at this port, and the sockets in *out. */
LF_NODISCARD lf_status lf_web_listen_port(int port, lf_web_sockets *out, lf_error *err);
void lf_web_sockets_close(lf_web_sockets *sockets);

/* Finds the port of a listening TCP socket, and whether it is one of IPv6. LF_E_ARG: it is
 * something else, or not on a loopback address. */
LF_NODISCARD lf_status lf_web_listener_look(int fd, int *out_port, bool *out_v6, lf_error *err);

#endif
