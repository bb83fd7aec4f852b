/* Attaches a simulated device to this machine through Linux's virtual host controller (module
 * vhci_hcd). It takes one end of a connected socket through sysfs and speaks USB/IP over it. Needs
 * root. Private to device/ and quiltsim. */
#ifndef LF_DEVICE_VHCI_H
#define LF_DEVICE_VHCI_H

#include "base/status.h"

#define LF_VHCI_FOLDER "/sys/devices/platform/vhci_hcd.0"

/* Attaches device LF_USBIP_DEVID at high speed to the first free port of the controller in this
 * folder. On LF_OK *out_fd is the device's end of the socket, owned by the caller; closing it
 * unplugs the device. LF_E_NODEV: no such controller (err says what to load); LF_E_BUSY: no free
 * port; LF_E_IO: no permission, or the kernel refused. */
LF_NODISCARD lf_status lf_vhci_attach(const char *folder, int *out_fd, lf_error *err);

#endif
