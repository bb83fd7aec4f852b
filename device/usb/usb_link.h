/* The USB functions that the host of a USB display needs: vendor requests to one interface and one
 * bulk OUT endpoint. A table of functions with two implementations: libusb
 * (device/usb/usb_libusb.c) and a simulated display called directly (device/model/usb_model.h).
 *
 * Threads: a link belongs to one thread at a time; only cancel may come from any other. Private to
 * device/, its tests and bench. */
#ifndef LF_DEVICE_USB_LINK_H
#define LF_DEVICE_USB_LINK_H

#include <stdint.h>

#include "device/device.h"

typedef enum lf_usb_result {
    LF_USB_OK,
    LF_USB_STALL,     /* refused; the endpoint works again */
    LF_USB_TIMEOUT,   /* nothing was accepted within the time allowed */
    LF_USB_CANCELLED, /* by cancel */
    LF_USB_GONE,      /* unplugged: final */
    LF_USB_NOMEM,     /* out of memory for a single transfer */
    LF_USB_IO,        /* any other error on the wire */
} lf_usb_result;

typedef struct lf_usb_link lf_usb_link;

typedef struct lf_usb_link_ops {
    /* A vendor request to the interface. in: fills at most n bytes of data; otherwise sends data[n]
     * (n at most 4096). *out_n (may be NULL) is the number of bytes moved, 0 on failure. Returns
     * within timeout_ms. */
    lf_usb_result (*control)(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                             uint8_t *data, size_t n, size_t *out_n, int timeout_ms);
    /* Begins to send data[n], n > 0. data stays the caller's and must not change before bulk_end,
     * which must follow. Does not wait. */
    void (*bulk_begin)(lf_usb_link *link, const uint8_t *data, size_t n);
    /* Waits until all is sent or has failed, at most until nothing has moved for timeout_ms.
     * Afterwards no transfer is in progress, whatever the result. */
    lf_usb_result (*bulk_end)(lf_usb_link *link, int timeout_ms);
    /* The transfer in progress, and every later call, ends soon with LF_USB_CANCELLED. */
    void (*cancel)(lf_usb_link *link);
    /* Releases the interface, frees. */
    void (*close)(lf_usb_link *link);
} lf_usb_link_ops;

/* First field of every link. */
struct lf_usb_link {
    const lf_usb_link_ops *ops;
};

/* The text of a result ("refused (STALL)", "unplugged", …), and its lf_status. */
const char *lf_usb_result_text(lf_usb_result result);
lf_status lf_usb_result_status(lf_usb_result result);

/* A display on the bus. Strings are sanitised (lf_device_text). */
typedef struct lf_usb_place {
    char address[40]; /* "1-4.2": bus and ports, as in usb:BUS-PORT */
    char product[64], serial[64];
    uint16_t vendor_id, product_id;
    uint8_t interface, endpoint; /* the display's interface, its first bulk OUT endpoint */
    char output[64];   /* output of the kernel's driver for it: "card1/USB-1"; empty = none */
    char problem[256]; /* why it cannot be used and what to do; empty = no known problem */
} lf_usb_place;

/* Lists all GUD interfaces (class 0xff with a bulk OUT endpoint) on 1d50:614d, 16d0:10a9 and
 * 04d8:ef7e, at most one per device. Opens and disturbs no device: descriptors and strings are the
 * system's copies. Returns the number written, at most max. */
int lf_usb_list(lf_usb_place *out, int max);

/* Opens the display at this address, "" = the first that is free. Never detaches a kernel driver.
 * The caller closes *out_link. LF_E_BUSY: a driver or another program has the interface (err says
 * what to use instead; *out_place->output, if the driver shows on it). LF_E_ARG: not an address;
 * LF_E_NODEV; LF_E_IO: no permission (err names the missing rule). */
LF_NODISCARD lf_status lf_usb_open(const char *address, lf_usb_place *out_place,
                                   lf_usb_link **out_link, lf_error *err);

#endif
