/* The device kind `usb` over any link. Private to device/, its tests and bench. */
#ifndef LF_DEVICE_USB_H
#define LF_DEVICE_USB_H

#include "device/usb/usb_link.h"

/* Creates the device for the display at the other end of link. Takes ownership of link in any case:
 * destroy closes it, or a failure does at once. calibration as for lf_device_ops.open; place as
 * filled by lf_usb_open. Errors of lf_device_ops.open. */
LF_NODISCARD lf_status lf_usb_create(lf_usb_link *link, const lf_usb_place *place,
                                     const lf_calibration *calibration, lf_device **out_device,
                                     lf_error *err);

#endif
