/* opener: opens, closes and finds devices on threads of its own, because real devices take seconds:
 * an EEPROM that does not answer, a display with a push in progress. There are several queues, so
 * that a faulty panel delays only requests about panels. Each queue runs in the order of the calls,
 * so that a device is closed before it is opened again. */
#ifndef LF_DAEMON_OPENER_H
#define LF_DAEMON_OPENER_H

#include "daemon/threads/worker.h"
#include "device/device.h"
#include "device/find/edid.h"
#include "device/find/find.h"
#include "device/hid/buttons.h"

typedef enum lf_opener_kind {
    LF_OPENER_OPEN,    /* open a device by its spec */
    LF_OPENER_CLOSE,   /* close a device or buttons */
    LF_OPENER_LIST,    /* list the devices */
    LF_OPENER_BUTTONS, /* open the buttons of the panel with this serial number */
    /* check whether the connected panel's calibration differs from the cached one */
    LF_OPENER_CHECK,
    LF_OPENER_EXAMINE, /* list devices and calibrations for `look` */
} lf_opener_kind;

/* Each queue has a thread. */
typedef enum lf_opener_queue {
    LF_QUEUE_PANELS,  /* opening and closing hardware, or devices that may be hardware (auto) */
    LF_QUEUE_FILES,   /* opening and closing devices that are not hardware, without waiting for
                       * hardware */
    LF_QUEUE_BUTTONS, /* buttons, checks and examinations: they read EEPROMs and drives */
    LF_QUEUE_LIST,    /* listing, which opens nothing */
    LF_OPENER_QUEUES,
} lf_opener_queue;

/* The queue in which a device of this spec is opened and closed. */
lf_opener_queue lf_opener_queue_of(const char *spec);

#define LF_LISTED_DEVICES 16

/* Gets what an examination has found. */
typedef void (*lf_look_fn)(void *answer, const lf_device_info *devices, int n_devices,
                           const lf_found *found, int n_found);

typedef struct lf_opener_request {
    lf_task task; /* posted when done; the poster sets `done` */
    lf_opener_kind kind;
    char spec[512];          /* OPEN; BUTTONS: the serial number */
    const char *calibration; /* OPEN: a file, NULL = the device's own; borrowed */
    char first[512]; /* OPEN: the first panel that "auto" tries: the last one used; empty = none */
    bool panel_only; /* OPEN: if "auto" finds no panel, fail like lf_device_find instead of opening
                      * a device that shows nothing */
    lf_calibration used; /* CHECK: the cached calibration … */
    lf_edid display;     /* … and the display it was found for */
    lf_look_fn look;     /* EXAMINE: called on the queue's thread, with `answer` */
    /* the poster's own */
    void *owner, *answer;
    struct lf_opener_request *next;
    uint64_t number;  /* OPEN: rises with each request, so that the last one wins */
    char before[512]; /* OPEN: spec of the device closed for it; empty = none */
    bool again;       /* OPEN: an automatic retry */
    bool asked_for;   /* OPEN: a client waits for the answer */
    /* the outcome */
    lf_status status;
    bool denied;     /* CHECK: the connected panel's calibration differs */
    lf_status found; /* OPEN: result of lf_device_find; LF_OK if it was not called */
    lf_error err;    /* OPEN: valid if status is not LF_OK */
    /* OPEN: the new device, which the poster may take; otherwise it is closed with the request.
     * CLOSE: the device to close. */
    lf_device *device;
    lf_buttons *buttons;     /* BUTTONS and CLOSE: likewise; LF_E_NODEV: the panel has no buttons */
    int n_devices;           /* LIST, EXAMINE */
    lf_device_info *devices; /* [n_devices], owned */
} lf_opener_request;

/* A zeroed request; NULL = out of memory. */
lf_opener_request *lf_opener_request_create(lf_opener_kind kind);
/* Closes a device and buttons that the poster did not take; may block. */
void lf_opener_request_destroy(lf_opener_request *request);
/* lf_opener_request_destroy with the signature of `done`. */
void lf_opener_request_forget(void *reader, lf_task *task);

typedef struct lf_opener lf_opener;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_opener_create(lf_inbox *inbox, lf_opener **out_opener);
/* Waits for the requests in progress. The others are closed, or posted as LF_E_CANCELLED. Accepts
 * NULL. */
void lf_opener_destroy(lf_opener *opener);
/* Queues the request. */
void lf_opener_submit(lf_opener *opener, lf_opener_request *request);
/* Waits until all requests are done, at most until lf_time_now is `end`; false = not all are. */
bool lf_opener_drain(lf_opener *opener, double end);

#endif
