#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/sandbox/import.h"

/* Space for one descriptor, suitably aligned. */
typedef union control {
    struct cmsghdr header;
    char bytes[CMSG_SPACE(sizeof(int))];
} control;

lf_status lf_import_send(int socket, const void *message, size_t size, int fd)
{
    control room = {.bytes = {0}};
    struct iovec data = {(void *)(uintptr_t)message, size};
    struct msghdr header = {.msg_iov = &data, .msg_iovlen = 1};
    ssize_t n;
    if (fd >= 0) {
        header.msg_control = room.bytes;
        header.msg_controllen = sizeof room.bytes;
        struct cmsghdr *with = CMSG_FIRSTHDR(&header);
        with->cmsg_level = SOL_SOCKET;
        with->cmsg_type = SCM_RIGHTS;
        with->cmsg_len = CMSG_LEN(sizeof fd);
        memcpy(CMSG_DATA(with), &fd, sizeof fd);
    }
    do {
        n = sendmsg(socket, &header, MSG_NOSIGNAL | MSG_DONTWAIT);
    } while (n < 0 && errno == EINTR);
    return n == (ssize_t)size ? LF_OK : LF_E_IO;
}

/* The received descriptor, if there is exactly one; alignment leaves space for two. */
static int take_descriptor(const struct msghdr *header)
{
    int fd = -1, n = 0;
    const struct cmsghdr *with = CMSG_FIRSTHDR(header);
    if (!with || with->cmsg_level != SOL_SOCKET || with->cmsg_type != SCM_RIGHTS)
        return -1;
    for (size_t at = CMSG_LEN(0); at + sizeof fd <= with->cmsg_len; at += sizeof fd, n++) {
        if (fd >= 0)
            close(fd);
        memcpy(&fd, (const char *)with + at, sizeof fd);
    }
    if (n > 1)
        close(fd);
    return n == 1 ? fd : -1;
}

lf_status lf_import_receive(int socket, void *message, size_t size, int *out_fd)
{
    control room;
    struct iovec data = {message, size};
    struct msghdr header = {.msg_iov = &data,
                            .msg_iovlen = 1,
                            .msg_control = room.bytes,
                            .msg_controllen = sizeof room.bytes};
    ssize_t n;
    *out_fd = -1;
    do {
        n = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
    } while (n < 0 && errno == EINTR);
    *out_fd = n >= 0 ? take_descriptor(&header) : -1;
    if (n == (ssize_t)size && !(header.msg_flags & (MSG_TRUNC | MSG_CTRUNC)))
        return LF_OK;
    if (*out_fd >= 0)
        close(*out_fd);
    *out_fd = -1;
    return LF_E_IO;
}
