/* A panel of the first generation with random faults, in place of whatever hangs on this machine's
 * USB: a GUD display ("usb:1-1") and a HID side with its calibration and buttons on one plug. A
 * program linked with wrap_test_faults (tests/module.mk) finds it where the rest finds libusb's and
 * hidapi's devices; everything above those two is as in the daemon.
 *
 * What the panel suffers from is drawn when it is opened and lasts until it is pulled out, which
 * happens every few seconds. Numbers are drawn from one seed, in the order in which threads ask for
 * them. Threads: any. The orders may lie in memory that is shared with another process. */
#ifndef LF_TESTS_DAEMON_FAULTY_H
#define LF_TESTS_DAEMON_FAULTY_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

enum { LF_FAULTY_WIDTH = 192, LF_FAULTY_HEIGHT = 256 };

typedef enum lf_faulty_kind {
    LF_FAULTY_UNPLUG,
    LF_FAULTY_REFUSED, /* to be opened */
    LF_FAULTY_STALL,
    LF_FAULTY_STATUS, /* errors of its own */
    LF_FAULTY_HANG,
    LF_FAULTY_SLOW,
    LF_FAULTY_LIE,
    LF_FAULTY_GARBAGE,
    LF_FAULTY_SHORT,
    LF_FAULTY_MUTE,
    LF_FAULTY_EEPROM,
    LF_FAULTY_STALE,
    LF_FAULTY_FLOOD,
    LF_FAULTY_KINDS,
} lf_faulty_kind;

typedef struct lf_faulty_orders {
    uint64_t seed; /* before the first device is opened */
    /* false: plugged in and healthy (what is open under a fault is pulled out first) */
    atomic_bool sick;
    /* what happened */
    atomic_uint_fast64_t struck[LF_FAULTY_KINDS];
    atomic_uint_fast64_t opened;     /* displays */
    atomic_uint_fast64_t rects;      /* shown */
    atomic_uint_fast64_t pages;      /* of EEPROM asked for */
    atomic_uint_fast64_t presses;    /* of buttons, reported */
    atomic_uint_fast64_t violations; /* HID requests other than reading a page */
} lf_faulty_orders;

/* "unplugged", "refused", … */
const char *lf_faulty_name(lf_faulty_kind kind);

/* Borrowed until the process ends; before the first device is looked for. */
void lf_faulty_use(lf_faulty_orders *orders);

#endif
