/* listen: which socket a daemon listens at: systemd's, or a path with its lock. */
#ifndef LF_DAEMON_LISTEN_H
#define LF_DAEMON_LISTEN_H

#include "base/status.h"

/* A name in the file system that is this process's alone. */
typedef struct lf_listener {
    char *path;  /* to be removed at the end; NULL = systemd's */
    int lock_fd; /* locked; -1 = none */
} lf_listener;

/* The socket that systemd has handed over, else one at this path (NULL: the first of
 * lf_default_socket). *out is to be ended by lf_unlisten, also on failure; *out_fd is the caller's.
 * LF_E_BUSY: a living daemon has it; LF_E_EXISTS: what is there is no socket; LF_E_ARG, LF_E_IO. */
LF_NODISCARD lf_status lf_listen(const char *socket, lf_listener *out, int *out_fd, lf_error *err);
/* Removes the socket's name and lets go of its lock. Accepts what was ended already. */
void lf_unlisten(lf_listener *listener);
/* $QUILTD_SOCKET, else $XDG_RUNTIME_DIR/quiltd.sock, else /run/quiltd/control.sock, for index 0, 1,
 * 2 (those that are not set are left out); false behind the last. */
bool lf_default_socket(int index, char *out, size_t size);

#endif
