/* Simulated USB devices: a Looking Glass of the first generation (HID with an EEPROM and buttons)
 * and a GUD display. Plain functions without threads, clocks or sockets of their own. The same
 * models serve all simulations: direct calls (tests), umockdev under the unmodified libraries
 * (tests), and the kernel's USB/IP (quiltsim, and the guest of make check-kernel). Private to
 * device/ and its tests.
 *
 * Threads: an object belongs to one thread at a time. Functions return what a USB device would: a
 * number of bytes, or a negative errno. -EPIPE = STALL, -EAGAIN = NAK (nothing now, the host keeps
 * asking), -ENODEV = unplugged, -ETIMEDOUT = no answer ever. */
#ifndef LF_DEVICE_MODEL_H
#define LF_DEVICE_MODEL_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* ------------------------------------------------------------------------------- model_hid.c -- */

/* The HID interface of a first-generation panel: unnumbered feature reports of 67 bytes in (page
 * requests), input reports of 68 bytes out, which arrive in packets of at most 64. Source:
 * lgeeprom.py of lonetech/LookingGlass. */
enum { LF_MODEL_PAGE = 64, LF_MODEL_FEATURE = 67, LF_MODEL_INPUT = 68, LF_MODEL_EEPROM_MAX = 8192 };

/* Zeroed is a healthy device. Counts are of requests, from 1; 0 = never. */
typedef struct lf_model_hid_faults {
    /* replies come as 64 bytes, then 4 (as with hidapi's libusb back end), instead of 68 */
    bool split;
    int stale;       /* this many replies of an older page precede each right one */
    int mute_every;  /* every n-th request gets no answer */
    int stall_every; /* every n-th request is refused with a STALL */
    int short_every; /* every n-th reply ends after 10 bytes */
    int press_every; /* a button report precedes every n-th reply */
    bool wrong_echo; /* the echoed page never matches */
} lf_model_hid_faults;

typedef struct lf_model_hid lf_model_hid;

/* eeprom[n]: the raw bytes from page 0 on, with length prefix (copied; at most LF_MODEL_EEPROM_MAX;
 * the rest reads as 0xff). */
LF_NODISCARD lf_status lf_model_hid_create(const void *eeprom, size_t n,
                                           const lf_model_hid_faults *faults, lf_model_hid **out);
/* Writes the raw EEPROM with this JSON text. Returns its size; 0: it does not fit into out[max]. */
size_t lf_model_hid_eeprom(const char *json, size_t n, uint8_t *out, size_t max);
/* Accepts NULL. */
void lf_model_hid_destroy(lf_model_hid *hid);
/* SET_REPORT of the feature report, without its id; n is the length the host sent. Returns n or an
 * errno as above. */
int lf_model_hid_feature(lf_model_hid *hid, const uint8_t *data, size_t n);
/* The next packet of input reports into out[max]; if it does not fit, the rest follows with the
 * next call. -EAGAIN: none. At most 64 packets wait; newer ones are dropped. */
int lf_model_hid_input(lf_model_hid *hid, uint8_t *out, size_t max);
/* Sets the buttons that are down: bit 0 = square, 1 = left, 2 = right, 3 = circle. Sends an
 * unsolicited report, which repeats echo and data of the last reply. Before the first reply these
 * are zeros, which looks like a page 0 of zeros. */
void lf_model_hid_press(lf_model_hid *hid, uint8_t buttons);
/* The number of requests so far that are not exactly a page read: another command or length, or
 * bytes that should be 0. It must stay 0, because the EEPROM might be writable. Such requests are
 * refused with a STALL. */
uint64_t lf_model_hid_violations(const lf_model_hid *hid);

/* ------------------------------------------------------------------------------- model_gud.c -- */

/* A GUD display, protocol version 1 (include/drm/gud.h of Linux). It refuses everything that the
 * protocol forbids, in any order: with a STALL, then GET_STATUS. With status_on_set, only
 * GET_STATUS reports errors in the data of SET requests. SET_BUFFER announces the content of the
 * next bulk transfers. There is one connector, and one property each of the plane (rotation) and of
 * the connector (backlight), which every state must contain. A rectangle that fails leaves its
 * upper half inverted. */
typedef struct lf_model_gud_options {
    int width, height;        /* its only mode, unless a fault changes it */
    const uint8_t *formats;   /* GUD format numbers, best first; copied */
    int n_formats;            /* at most 8 */
    uint32_t max_buffer_size; /* bytes; 0 = no limit */
    bool lz4, status_on_set, full_update;
    const uint8_t *edid; /* NULL = none; copied */
    size_t n_edid;       /* multiple of 128, at most 2048 */
} lf_model_gud_options;

/* Zeroed is a healthy device. Counts are from 1; 0 = never. */
typedef struct lf_model_gud_faults {
    uint64_t stall_every;  /* every n-th SET_BUFFER is refused as BUSY */
    uint64_t fail_every;   /* every n-th bulk transfer ends with a STALL half way */
    uint64_t hang_every;   /* every n-th bulk transfer is never accepted */
    uint64_t unplug_after; /* it is gone after this many rectangles */
    uint64_t bytes_per_s;  /* its speed, for the code that drives it (lf_model_gud_delay_ns) */
    int fault;             /* one of lf_model_gud_fault */
} lf_model_gud_faults;

/* Faults in a display's description of itself. */
typedef enum lf_model_gud_fault {
    LF_GUD_HONEST,
    LF_GUD_WRONG_MAGIC,
    LF_GUD_VERSION_0,
    LF_GUD_VERSION_9,
    LF_GUD_SHORT_DESCRIPTOR,
    LF_GUD_NO_FORMATS,
    LF_GUD_UNKNOWN_FORMATS,
    LF_GUD_MANY_FORMATS, /* 200 formats */
    LF_GUD_NO_CONNECTORS,
    LF_GUD_MODE_0X0,
    LF_GUD_MODE_65535,      /* 65535 x 65535: products overflow 32 bits */
    LF_GUD_MODES_CUT,       /* the list ends within a mode */
    LF_GUD_TINY_BUFFER,     /* max_buffer_size below one row */
    LF_GUD_SHORT_EDID,      /* 100 bytes */
    LF_GUD_NO_MODES,        /* no modes and no EDID */
    LF_GUD_COMPRESSED_FULL, /* FULL_UPDATE together with LZ4, which the protocol forbids */
    LF_GUD_BAD_STATUS,      /* GET_STATUS returns 200 */
    LF_GUD_FAULTS,
} lf_model_gud_fault;

typedef struct lf_model_gud lf_model_gud;

LF_NODISCARD lf_status lf_model_gud_create(const lf_model_gud_options *options,
                                           const lf_model_gud_faults *faults, lf_model_gud **out);
/* Accepts NULL. */
void lf_model_gud_destroy(lf_model_gud *gud);
/* A vendor request to the interface (bmRequestType 0xc1 or 0x41, wValue). in: fills data[n];
 * otherwise data[n] is the host's data. Returns bytes. */
int lf_model_gud_control(lf_model_gud *gud, bool in, uint8_t request, uint16_t value, uint8_t *data,
                         size_t n);
/* Data on the bulk endpoint. A rectangle may come in several pieces and is shown with its last
 * byte. Returns n. */
int lf_model_gud_bulk(lf_model_gud *gud, const uint8_t *data, size_t n);
/* How long a device of this speed takes for n bytes, in ns; 0 = no delay. */
uint64_t lf_model_gud_delay_ns(const lf_model_gud *gud, size_t n);

/* The shown pixels: [height][width] of r, g, b bytes; RGB565 is widened by repeating the high bits.
 * Valid until destroy. */
const uint8_t *lf_model_gud_pixels(const lf_model_gud *gud);
/* True once a mode is set and the display switched on. */
bool lf_model_gud_lit(const lf_model_gud *gud);

typedef struct lf_model_gud_counters {
    uint64_t rects, bytes, compressed_rects; /* shown; bytes on the bulk endpoint */
    uint64_t refused;                        /* requests that broke the protocol */
} lf_model_gud_counters;
void lf_model_gud_counters_get(const lf_model_gud *gud, lf_model_gud_counters *out);

/* ----------------------------------------------------------------------------------- model.c -- */

/* A whole USB device: descriptors, the standard requests of USB 2.0 chapter 9 and of the HID class,
 * and the two models above as interfaces, HID first. VID:PID 04d8:ef7e with HID ("HoloPlay",
 * "Looking Glass Factory"), otherwise 1d50:614d. High speed; one configuration. GET_REPORT is
 * refused; reports come on the interrupt endpoint. */
typedef struct lf_model lf_model;

/* Addresses of the endpoints, if their interface exists. */
enum { LF_MODEL_HID_ENDPOINT = 0x81, LF_MODEL_GUD_ENDPOINT = 0x02 };

/* hid and gud (one of them may be NULL) are borrowed until destroy. */
LF_NODISCARD lf_status lf_model_create(lf_model_hid *hid, lf_model_gud *gud, lf_model **out);
/* Accepts NULL. */
void lf_model_destroy(lf_model *model);
/* A transfer on endpoint 0: setup as on the wire; data[n] with n <= wLength. Returns bytes. The
 * host controller handles SET_ADDRESS itself. */
int lf_model_control(lf_model *model, const uint8_t setup[8], uint8_t *data, size_t n);
/* A transfer on another endpoint (address with the direction bit). Returns bytes. A STALL halts the
 * endpoint until the host clears it (CLEAR_FEATURE ENDPOINT_HALT, sent by libusb_clear_halt) or
 * sets the configuration. */
int lf_model_transfer(lf_model *model, uint8_t endpoint, uint8_t *data, size_t n);

/* An EDID like a panel's (VESA E-EDID A2). Name and serial are cut at 13 characters. The format
 * cannot hold a side over 4095 pixels; the EDID then has no timing. */
void lf_model_edid(const char *name, const char *serial, int width, int height, uint8_t out[128]);

#endif
