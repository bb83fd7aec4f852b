#include "daemon/wire/listen.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"

#define SYSTEM_SOCKET "/run/quiltd/control.sock"
#define SYSTEM_GROUP "quiltd"
#define BACKLOG 128

bool lf_default_socket(int index, char *out, size_t size)
{
    const char *named = getenv("QUILTD_SOCKET");
    const char *runtime = getenv("XDG_RUNTIME_DIR");
    bool has_named = named && named[0] != '\0', has_runtime = runtime && runtime[0] == '/';
    if (has_named && index-- == 0) {
        snprintf(out, size, "%s", named);
        return true;
    }
    if (has_runtime && index-- == 0) {
        snprintf(out, size, "%s/quiltd.sock", runtime);
        return true;
    }
    snprintf(out, size, SYSTEM_SOCKET);
    return index == 0;
}

static lf_status address_of(const char *path, const char *option, struct sockaddr_un *out,
                            lf_error *err)
{
    *out = (struct sockaddr_un){.sun_family = AF_UNIX};
    if (path[0] == '\0') /* Linux: a name that no file's rights protect */
        return lf_error_set(err, LF_E_ARG, option, "expects the path of a socket, got none");
    if (strlen(path) >= sizeof out->sun_path)
        return lf_error_set(err, LF_E_ARG, path,
                            "the socket path is longer than %zu bytes; use a shorter one (%s)",
                            sizeof out->sun_path - 1, option);
    memcpy(out->sun_path, path, strlen(path) + 1);
    return LF_OK;
}

enum { LOCK_SIZE = sizeof((struct sockaddr_un *)0)->sun_path + 8 };

static void name_lock(const char *path, char out[LOCK_SIZE])
{
    snprintf(out, LOCK_SIZE, "%.*s.lock", LOCK_SIZE - 8, path);
}

static void unlink_lock(const char *path)
{
    char lock[LOCK_SIZE];
    name_lock(path, lock);
    unlink(lock);
}

/* The lock file is next to the socket; its holder may replace the socket. Retries, because an
 * ending daemon removes the file, and a lock on a removed file is worthless. */
static lf_status take_lock(const char *path, const char *option, int *out_fd, lf_error *err)
{
    char lock[LOCK_SIZE];
    name_lock(path, lock);
    for (;;) {
        int fd = open(lock, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (fd < 0) {
            return lf_error_set(err, LF_E_IO, path,
                                "cannot create the lock file of the socket: %s; choose another "
                                "%s",
                                lf_errno_text(errno), option);
        }
        if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
            close(fd);
            return lf_error_set(err, LF_E_BUSY, path,
                                "another quiltd uses this socket; choose another %s", option);
        }
        struct stat ours, there;
        if (fstat(fd, &ours) == 0 && stat(lock, &there) == 0 && ours.st_ino == there.st_ino &&
            ours.st_dev == there.st_dev) {
            *out_fd = fd;
            return LF_OK;
        }
        close(fd);
    }
}

/* Removes a socket of a dead daemon, but not one at which a daemon answers, nor another kind of
 * file. */
static lf_status clear_name(const char *path, const char *option, const struct sockaddr_un *address,
                            lf_error *err)
{
    struct stat st;
    if (lstat(path, &st) != 0)
        return LF_OK;
    if (!S_ISSOCK(st.st_mode))
        return lf_error_set(err, LF_E_EXISTS, path, "exists and is not a socket; choose another %s",
                            option);
    if (st.st_uid != geteuid())
        return lf_error_set(err, LF_E_EXISTS, path,
                            "the socket is another user's; choose another %s", option);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    bool answered =
        fd >= 0 &&
        (connect(fd, (const struct sockaddr *)address, sizeof *address) == 0 || errno == EAGAIN);
    if (fd >= 0)
        close(fd);
    if (answered)
        return lf_error_set(err, LF_E_BUSY, path,
                            "another program uses this socket; choose another %s", option);
    return unlink(path) == 0 ? LF_OK
                             : lf_error_set(err, LF_E_IO, path, "cannot replace the old socket: %s",
                                            lf_errno_text(errno));
}

/* The system's socket is accessible to the group; a user's only to the user. */
static void open_to_group(const char *path)
{
    const struct group *group = strcmp(path, SYSTEM_SOCKET) == 0 ? getgrnam(SYSTEM_GROUP) : NULL;
    if (group && chown(path, (uid_t)-1, group->gr_gid) == 0 && chmod(path, 0660) != 0)
        lf_log(LF_LOG_WARNING, "%s: cannot give the group %s access to the socket", path,
               SYSTEM_GROUP);
}

static lf_status bind_and_listen(const char *path, const struct sockaddr_un *address, int *out_fd,
                                 lf_error *err)
{
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    mode_t before = umask(0177);
    bool bound = fd >= 0 && bind(fd, (const struct sockaddr *)address, sizeof *address) == 0;
    int why = errno;
    umask(before);
    if (bound) {
        open_to_group(path);
        if (listen(fd, BACKLOG) == 0) {
            *out_fd = fd;
            return LF_OK;
        }
        why = errno;
    }
    if (fd >= 0)
        close(fd);
    return lf_error_set(err, LF_E_IO, path, "cannot listen: %s", lf_errno_text(why));
}

/* The path of a socket from systemd. NULL: it has none. */
static char *path_of(int fd)
{
    struct sockaddr_un address = {0};
    socklen_t size = sizeof address - 1; /* which leaves a zero at the end */
    const bool has_path = getsockname(fd, (struct sockaddr *)&address, &size) == 0 &&
                          address.sun_family == AF_UNIX && address.sun_path[0] == '/';
    return has_path ? lf_strdup(address.sun_path) : NULL;
}

lf_status lf_listen(const char *socket, lf_listener *out, int *out_fd, lf_error *err)
{
    int n = sd_listen_fds(1);
    *out = (lf_listener){.lock_fd = -1};
    if (n > 1 || (n == 1 && sd_is_socket_unix(SD_LISTEN_FDS_START, SOCK_STREAM, 1, NULL, 0) <= 0))
        return lf_error_set(
            err, LF_E_ARG, "systemd",
            "passed something other than one listening Unix stream socket; check the socket unit");
    if (n == 1) {
        *out_fd = SD_LISTEN_FDS_START;
        out->path = path_of(*out_fd);
        fcntl(*out_fd, F_SETFL, fcntl(*out_fd, F_GETFL) | O_NONBLOCK);
        return LF_OK;
    }
    char path[512];
    if (socket)
        snprintf(path, sizeof path, "%s", socket);
    else
        (void)lf_default_socket(0, path, sizeof path);
    return lf_listen_at(path, "--socket PATH", out, out_fd, err);
}

lf_status lf_listen_at(const char *path, const char *option, lf_listener *out, int *out_fd,
                       lf_error *err)
{
    struct sockaddr_un address;
    *out = (lf_listener){.lock_fd = -1};
    lf_status status = address_of(path, option, &address, err);
    if (status == LF_OK)
        status = take_lock(path, option, &out->lock_fd, err);
    if (status == LF_OK)
        status = clear_name(path, option, &address, err);
    if (status == LF_OK)
        status = bind_and_listen(path, &address, out_fd, err);
    if (status == LF_OK)
        out->path = lf_strdup(path);
    if (status != LF_OK && out->lock_fd >= 0) { /* ours: in /tmp it would keep out others */
        unlink_lock(path);
        close(out->lock_fd);
        out->lock_fd = -1;
    }
    return status;
}

void lf_unlisten(lf_listener *listener)
{
    if (listener->path && listener->lock_fd >= 0) {
        unlink(listener->path);
        unlink_lock(listener->path);
    }
    lf_free(listener->path);
    if (listener->lock_fd >= 0)
        close(listener->lock_fd);
    *listener = (lf_listener){.lock_fd = -1};
}
