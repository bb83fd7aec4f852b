#include "device/usb/usb_link.h"

const char *lf_usb_result_text(lf_usb_result result)
{
    switch (result) {
    case LF_USB_OK:
        return "no error";
    case LF_USB_STALL:
        return "refused (STALL)";
    case LF_USB_TIMEOUT:
        return "the device did not answer in time";
    case LF_USB_CANCELLED:
        return "cancelled";
    case LF_USB_GONE:
        return "unplugged";
    case LF_USB_NOMEM:
        return "the kernel has no memory for USB transfers; raise usbcore.usbfs_memory_mb";
    case LF_USB_IO:
        break;
    }
    return "the USB transfer failed";
}

lf_status lf_usb_result_status(lf_usb_result result)
{
    switch (result) {
    case LF_USB_OK:
        return LF_OK;
    case LF_USB_TIMEOUT:
        return LF_E_TIMEOUT;
    case LF_USB_CANCELLED:
        return LF_E_CANCELLED;
    case LF_USB_GONE:
        return LF_E_NODEV;
    case LF_USB_NOMEM:
        return LF_E_NOMEM;
    case LF_USB_STALL:
    case LF_USB_IO:
        break;
    }
    return LF_E_IO;
}
