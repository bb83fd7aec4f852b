/* The server side of USB/IP 1.1.1 (Documentation/usb/usbip_protocol.rst of Linux). It serves one
 * simulated device over connected stream sockets: to `usbip attach` over TCP, or directly to the
 * kernel's vhci_hcd through one end of a socket pair. URBs of one endpoint are answered in order,
 * those of different endpoints in any order, so a slow endpoint delays no other.
 *
 * Peers are not trusted. A message that breaks the protocol ends the connection. At most
 * LF_USBIP_MAX_URBS wait, with at most LF_USBIP_MAX_WAITING bytes; more are read, dropped and
 * answered with -ENOMEM. The server does not read from a peer that does not read.
 *
 * Threads: a device and all its connections belong to one thread. Nothing blocks: the caller polls.
 * Private to device/ and quiltsim. */
#ifndef LF_DEVICE_USBIP_H
#define LF_DEVICE_USBIP_H

#include <poll.h>

#include "device/model/model.h"

/* The identity of the one device: the argument of `usbip attach -b`, and busnum << 16 | devnum. */
#define LF_USBIP_BUSID "1-1"
enum { LF_USBIP_PORT = 3240, LF_USBIP_DEVID = 1 << 16 | 2, LF_USBIP_HIGH_SPEED = 3 };
/* Limits of the memory that one connection can use. */
enum { LF_USBIP_MAX_URBS = 256, LF_USBIP_MAX_TRANSFER = 16 << 20, LF_USBIP_MAX_WAITING = 64 << 20 };

/* Shared by the connections. Owned by the caller, and must outlive them; models are borrowed. */
typedef struct lf_usbip_device {
    lf_model *model;         /* NULL = unplugged: lists are empty, imports are refused */
    const lf_model_gud *gud; /* its speed limits the bulk endpoint; NULL = no limit */
    bool taken;              /* a connection has imported it */
} lf_usbip_device;

typedef struct lf_usbip lf_usbip;

/* Serves a connected stream socket, which is made non-blocking. imported: the handshake is done, as
 * with vhci_hcd's attach file, and the device must not be taken. On LF_OK the connection owns fd,
 * otherwise the caller keeps it. LF_E_NOMEM, LF_E_IO. */
LF_NODISCARD lf_status lf_usbip_create(lf_usbip_device *device, int fd, bool imported,
                                       lf_usbip **out);
/* Closes the socket: for the host the device is unplugged. Accepts NULL. */
void lf_usbip_destroy(lf_usbip *usbip);

/* Fills *out with the events to poll for. Returns the longest time, in milliseconds (-1 = for
 * ever), before lf_usbip_run must be called again. */
int lf_usbip_poll(const lf_usbip *usbip, uint64_t now_ns, struct pollfd *out);
/* Reads, answers and writes what is possible at this time (CLOCK_MONOTONIC). To be called also when
 * the device has news, such as a button.
 *   LF_OK        the connection continues
 *   LF_E_NODEV   normal end: the list was sent, the host has gone, or the device has
 *   LF_E_FORMAT  the peer broke the protocol (err says how)
 *   LF_E_IO, LF_E_NOMEM
 *
 * After an error only destroy may be called. */
LF_NODISCARD lf_status lf_usbip_run(lf_usbip *usbip, uint64_t now_ns, lf_error *err);
/* True once the handshake is done and URBs are transferred. */
bool lf_usbip_imported(const lf_usbip *usbip);

#endif
