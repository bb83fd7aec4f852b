/* A host's link to a simulated display, called directly: for tests and benchmarks. */
#ifndef LF_DEVICE_USB_MODEL_H
#define LF_DEVICE_USB_MODEL_H

#include "device/model/model.h"
#include "device/usb/usb_link.h"

/* Opens a link to a simulated display without a bus. It delays transfers by lf_model_gud_delay_ns.
 * gud is borrowed until close. NULL = out of memory. */
lf_usb_link *lf_usb_model_open(lf_model_gud *gud);

#endif
