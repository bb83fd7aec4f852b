#include "device/model/vhci.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/errno_text.h"
#include "device/model/usbip.h"

enum { PORT_FREE = 4 };

static lf_status cannot(lf_error *err, const char *path, const char *verb)
{
    int code = errno;
    lf_status status = code == ENOENT ? LF_E_NODEV : LF_E_IO;
    return lf_error_set(err, status, path, "%s: %s%s", verb, lf_errno_text(code),
                        code == ENOENT                    ? "; run modprobe vhci_hcd as root first"
                        : code == EACCES || code == EPERM ? "; run quiltsim --attach as root"
                                                          : "");
}

/* "hs  0000 004 000 00000000 000000 0-0" is a free port of the hub that high speed takes. */
static lf_status find_port(const char *folder, unsigned *out_port, lf_error *err)
{
    char path[PATH_MAX], line[256];
    unsigned port, state;
    bool found = false;
    snprintf(path, sizeof path, "%s/status", folder);
    FILE *file = fopen(path, "re");
    if (!file)
        return cannot(err, path, "cannot open the file");
    while (!found && fgets(line, sizeof line, file))
        found = sscanf(line, "hs %u %u", &port, &state) == 2 && state == PORT_FREE;
    fclose(file);
    if (!found)
        return lf_error_set(err, LF_E_BUSY, path,
                            "no port is free; detach a device (usbip port; usbip detach -p PORT)");
    *out_port = port;
    return LF_OK;
}

static lf_status give(const char *folder, unsigned port, int fd, lf_error *err)
{
    char path[PATH_MAX], text[64];
    int n = snprintf(text, sizeof text, "%u %d %u %u", port, fd, (unsigned)LF_USBIP_DEVID,
                     (unsigned)LF_USBIP_HIGH_SPEED);
    snprintf(path, sizeof path, "%s/attach", folder);
    int file = open(path, O_WRONLY | O_CLOEXEC);
    if (file < 0)
        return cannot(err, path, "cannot open the file");
    lf_status status = write(file, text, (size_t)n) == n
                           ? LF_OK
                           : cannot(err, path, "the kernel refused the device");
    close(file);
    return status;
}

lf_status lf_vhci_attach(const char *folder, int *out_fd, lf_error *err)
{
    unsigned port;
    int ends[2];
    lf_status status = find_port(folder, &port, err);
    if (status != LF_OK)
        return status;
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) < 0)
        return cannot(err, folder, "cannot create a pair of sockets");
    status = give(folder, port, ends[1], err);
    close(ends[1]); /* the kernel holds its own reference */
    if (status == LF_OK)
        *out_fd = ends[0];
    else
        close(ends[0]);
    return status;
}
