/* The device `usb` over any link. Private to device/, its tests and bench. */
#ifndef LF_DEVICE_USB_H
#define LF_DEVICE_USB_H

#include "device/usb/usb_link.h"

/* Makes the device of a display at the other end of link, which is taken in any case: closed by
 * destroy, or at once on failure. calibration as lf_device_ops.open has it, place as lf_usb_open
 * left it. Errors as lf_device_ops.open. */
LF_NODISCARD lf_status lf_usb_create(lf_usb_link *link, const lf_usb_place *place,
                                     const lf_calibration *calibration, lf_device **out_device,
                                     lf_error *err);

#endif
