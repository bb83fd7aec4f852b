/* opener: opens, closes and looks for devices on threads of its own, because real ones take
 * seconds: an EEPROM that does not answer, a display that still has a push under way. There are
 * several queues, so that nothing waits for a faulty panel but what is about panels; within a queue
 * everything happens in the order of the calls, so that a device is closed before it is opened
 * again. */
#ifndef LF_DAEMON_OPENER_H
#define LF_DAEMON_OPENER_H

#include "daemon/threads/worker.h"
#include "device/device.h"
#include "device/find/edid.h"
#include "device/hid/buttons.h"

typedef enum lf_opener_kind {
    LF_OPENER_OPEN,    /* a device by its spec */
    LF_OPENER_CLOSE,   /* an open device, or its buttons */
    LF_OPENER_LIST,    /* the devices there are */
    LF_OPENER_BUTTONS, /* the buttons of the panel with this serial number */
    /* whether what is plugged in has another calibration for a display than the cached one */
    LF_OPENER_CHECK,
} lf_opener_kind;

/* A thread each. */
typedef enum lf_opener_queue {
    LF_QUEUE_PANELS,  /* opening and closing whatever is hardware, or may be (auto) */
    LF_QUEUE_FILES,   /* opening and closing what is no hardware: it waits for none */
    LF_QUEUE_BUTTONS, /* buttons and checks: they read EEPROMs and drives */
    LF_QUEUE_LIST,    /* listing, which opens nothing */
    LF_OPENER_QUEUES,
} lf_opener_queue;

/* The queue in which a device of this spec is opened and closed. */
lf_opener_queue lf_opener_queue_of(const char *spec);

#define LF_LISTED_DEVICES 16

typedef struct lf_opener_request {
    lf_task task; /* posted when it is done; the poster sets done */
    lf_opener_kind kind;
    char spec[512];          /* OPEN; BUTTONS: the serial number */
    const char *calibration; /* OPEN: a file, NULL = the device's own; borrowed */
    char first[512]; /* OPEN: where "auto" begins: the panel that was there last; empty = none */
    bool panel_only; /* OPEN: "auto" that finds no panel fails like lf_device_find, and is not a
                        device that shows nothing */
    lf_calibration used; /* CHECK: the cached one … */
    lf_edid display;     /* … and what it was found for */
    /* the poster's own */
    void *owner, *answer;
    struct lf_opener_request *next;
    uint64_t number;  /* OPEN: rises with every device asked for, so that the last one wins */
    char before[512]; /* OPEN: what had to be closed for it; empty = nothing */
    bool again;       /* OPEN: a device that is missing is tried again */
    bool asked_for;   /* OPEN: somebody waits for the answer */
    /* the outcome */
    lf_status status;
    bool denied;     /* CHECK: what is plugged in has another one */
    lf_status found; /* OPEN: what lf_device_find said; LF_OK when it was not asked */
    lf_error err;    /* OPEN: when status is not LF_OK */
    /* OPEN: the poster's to take, else closed with the request; CLOSE: the one to close */
    lf_device *device;
    lf_buttons *buttons;     /* BUTTONS and CLOSE: likewise; LF_E_NODEV: that panel has none */
    int n_devices;           /* LIST */
    lf_device_info *devices; /* [n_devices], owned */
} lf_opener_request;

/* A zeroed request; NULL = out of memory. */
lf_opener_request *lf_opener_request_create(lf_opener_kind kind);
/* Closes the device and buttons that nobody took, which may block. */
void lf_opener_request_destroy(lf_opener_request *request);
/* The same, as what `done` of a task is. */
void lf_opener_request_forget(void *reader, lf_task *task);

typedef struct lf_opener lf_opener;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_opener_create(lf_inbox *inbox, lf_opener **out_opener);
/* Ends when the requests under way have. What is left is closed, or posted as LF_E_CANCELLED.
 * Accepts NULL. */
void lf_opener_destroy(lf_opener *opener);
/* Does the request in its queue. */
void lf_opener_submit(lf_opener *opener, lf_opener_request *request);
/* Waits until all is done, until lf_time_now is end at the latest; false = it is not. */
bool lf_opener_drain(lf_opener *opener, double end);

#endif
