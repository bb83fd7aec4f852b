/* The HID interface of a first-generation panel: its EEPROM, read page by page, and its input
 * reports. Source: lgeeprom.py of lonetech/LookingGlass. Logic over a link of a few functions, so
 * that tests and fuzzers can replace the hardware; device/hid/hid_hidapi.c is the link to real
 * devices. The only request ever sent is "read a page". Private to device/ and its tests.
 *
 * Every call ends, whatever the device does: reports are counted, and the link provides the clock.
 * Replies that arrive in parts exceed the total time by at most the rest of a report. A device that
 * does not accept requests blocks the kernel for 5 s each; the total time is over after the first.
 *
 * Threads: a link belongs to one thread at a time; lf_hid_list and lf_hid_open may be called by
 * any. */
#ifndef LF_DEVICE_HID_H
#define LF_DEVICE_HID_H

#include <stdint.h>

#include "base/calibration.h"

enum {
    LF_HID_FEATURE = 68, /* bytes of a request, with the report number 0 before it */
    LF_HID_REPORT = 68,  /* bytes of an input report, which has no number */
    LF_HID_PAGE = 64,    /* bytes of EEPROM in a reply */
    /* longest accepted calibration; known ones have fewer than 1000 bytes */
    LF_HID_MAX_JSON = 4096
};

/* The connection to a device. Functions return what hidapi's return. */
typedef struct lf_hid_link {
    /* Sends a feature report, number included: bytes sent, or -1. */
    int (*send)(void *context, const uint8_t *report, size_t n);
    /* Waits for the next packet of input reports. Returns its bytes, 0 = none within timeout_ms (0
     * = do not wait), -1 = the device is gone. */
    int (*read)(void *context, uint8_t *out, size_t max, int timeout_ms);
    /* A clock that does not go backwards. */
    uint64_t (*now_ms)(void *context);
    void (*close)(void *context); /* NULL = nothing to close */
    void *context;
} lf_hid_link;

/* Timeouts and number of attempts. */
typedef struct lf_hid_patience {
    int reply_ms; /* for the reply to a request */
    int rest_ms;  /* for the rest of a partial report */
    int attempts; /* requests of the same page */
    int total_ms; /* for everything */
} lf_hid_patience;
/* 1 s, 10 ms, 3 times, 4 s. */
extern const lf_hid_patience lf_hid_patient;

/* Reads one whole input report: 1 = in out, 0 = none within timeout_ms, -1 = the device is gone.
 * Parts are joined. A report that is not complete rest_ms after its first part is dropped and
 * counts as none. */
int lf_hid_read_report(const lf_hid_link *link, int timeout_ms, int rest_ms,
                       uint8_t out[LF_HID_REPORT]);

/* Reads the calibration in the EEPROM. `where` names the device in errors. Data that does not parse
 * is read a second time, because before the first request a button report looks like a page 0. *out
 * is untouched on failure:
 *   LF_E_NODEV    unplugged
 *   LF_E_TIMEOUT  no reply, or none to the request
 *   LF_E_IO       every request is refused
 *   LF_E_FORMAT   blank EEPROM, impossible length, or text that is not a calibration */
LF_NODISCARD lf_status lf_hid_read_calibration(const lf_hid_link *link,
                                               const lf_hid_patience *patience, const char *where,
                                               lf_calibration *out, lf_error *err);

/* ------------------------------------------------------------------------------ hid_hidapi.c -- */

/* A connected panel's HID interface. */
typedef struct lf_hid_place {
    char path[256];   /* /dev/hidraw0 */
    char product[64]; /* sanitised */
} lf_hid_place;

/* Lists the HID devices 04d8:ef7e whose product begins with "HoloPlay", because many products share
 * the vendor number. Fills at most max entries, returns their number. Opens no device. */
int lf_hid_list(lf_hid_place *out, int max);

/* Opens a path for reading and sending; other programs may have it open too. On LF_OK the caller
 * closes the link with lf_hid_close.
 *   LF_E_NODEV  not connected
 *   LF_E_IO     no permission (err says what to do), or the system's message */
LF_NODISCARD lf_status lf_hid_open(const char *path, lf_hid_link *out, lf_error *err);
/* Accepts a zeroed link. */
void lf_hid_close(lf_hid_link *link);

#endif
