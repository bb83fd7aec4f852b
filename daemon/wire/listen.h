/* listen: the socket a daemon listens on: systemd's, or a path with its lock. */
#ifndef LF_DAEMON_LISTEN_H
#define LF_DAEMON_LISTEN_H

#include "base/status.h"

/* A socket's name. */
typedef struct lf_listener {
    char *path;  /* where clients connect; NULL: a socket from systemd without a path */
    int lock_fd; /* locked: this process owns the name; -1: systemd does */
} lf_listener;

/* Uses the socket passed by systemd; otherwise creates one at this path. socket NULL: the first
 * path of lf_default_socket. End *out with lf_unlisten, also after failure. The caller owns
 * *out_fd. LF_E_BUSY: a running daemon uses the path; LF_E_EXISTS: the path exists and is not a
 * socket; LF_E_ARG, LF_E_IO. */
LF_NODISCARD lf_status lf_listen(const char *socket, lf_listener *out, int *out_fd, lf_error *err);
/* Creates a socket at this path, for its user alone, without asking systemd. option: what the
 * errors name as the remedy, such as "--socket PATH". Results and errors as above; LF_E_EXISTS also
 * if the socket there is another user's. */
LF_NODISCARD lf_status lf_listen_at(const char *path, const char *option, lf_listener *out,
                                    int *out_fd, lf_error *err);
/* Removes a socket that this process owns, and releases its lock. May be called twice. */
void lf_unlisten(lf_listener *listener);
/* Candidate paths for index 0, 1, 2: $QUILTD_SOCKET, $XDG_RUNTIME_DIR/quiltd.sock,
 * /run/quiltd/control.sock. Unset variables are skipped. False: index is past the last
 * candidate. */
bool lf_default_socket(int index, char *out, size_t size);

#endif
