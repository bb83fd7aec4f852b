/* The server's side of USB/IP 1.1.1 (the kernel's Documentation/usb/usbip_protocol.rst; usb.md
 * 2(c)): one simulated device over connected stream sockets, to `usbip attach` by TCP or straight
 * to the kernel's vhci_hcd by one end of a socket pair. A URB is answered when the device has an
 * answer, in any order among endpoints and in the given order on each; a slow endpoint delays no
 * other.
 *
 * Whoever connects is not trusted: a message that breaks the protocol ends the connection; at most
 * LF_USBIP_MAX_URBS wait, with at most LF_USBIP_MAX_WAITING bytes (what is beyond is read, dropped
 * and answered -ENOMEM); a peer that does not read is not read from. Threads: a device and all its
 * connections belong to one thread. Nothing blocks: the caller polls. Private to device/ and
 * quiltsim. */
#ifndef LF_DEVICE_USBIP_H
#define LF_DEVICE_USBIP_H

#include <poll.h>

#include "device/model/model.h"

/* How the one device is called: what `usbip attach -b` takes, and busnum << 16 | devnum. */
#define LF_USBIP_BUSID "1-1"
enum { LF_USBIP_PORT = 3240, LF_USBIP_DEVID = 1 << 16 | 2, LF_USBIP_HIGH_SPEED = 3 };
/* Bounds of what one connection may make the server keep. */
enum { LF_USBIP_MAX_URBS = 256, LF_USBIP_MAX_TRANSFER = 16 << 20, LF_USBIP_MAX_WAITING = 64 << 20 };

/* What the connections share. The caller's, and there as long as any of them; models are borrowed.
 */
typedef struct lf_usbip_device {
    lf_model *model;         /* NULL = unplugged: lists are empty, imports are refused */
    const lf_model_gud *gud; /* whose speed the bulk endpoint has; NULL = at once */
    bool taken;              /* a connection has imported it */
} lf_usbip_device;

typedef struct lf_usbip lf_usbip;

/* Serves a connected stream socket, made non-blocking. imported: the handshake is behind it, as
 * with vhci_hcd's attach file, and the device must not be taken. On LF_OK fd is the connection's,
 * otherwise it stays the caller's. LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_usbip_create(lf_usbip_device *device, int fd, bool imported,
                                       lf_usbip **out);
/* Closes the socket: to the host the device is unplugged. Accepts NULL. */
void lf_usbip_destroy(lf_usbip *usbip);

/* What to poll for, and for how many milliseconds at most (-1 = for ever), before lf_usbip_run is
 * called again. */
int lf_usbip_poll(const lf_usbip *usbip, uint64_t now_ns, struct pollfd *out);
/* Reads, answers and writes whatever can be at this time (CLOCK_MONOTONIC). Also called when the
 * device has something new to tell, a button.
 *   LF_OK        goes on
 *   LF_E_NODEV   over, as it should be: the list was sent, the host has gone, or the device has
 *   LF_E_FORMAT  the peer broke the protocol (err says how)
 *   LF_E_IO, LF_E_NOMEM
 * All but LF_OK: only destroy is left to call. */
LF_NODISCARD lf_status lf_usbip_run(lf_usbip *usbip, uint64_t now_ns, lf_error *err);
/* True once the handshake is over and URBs are carried. */
bool lf_usbip_imported(const lf_usbip *usbip);

#endif
