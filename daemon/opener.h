/* opener: opens, closes and looks for devices on threads of its own, because real ones take seconds: an EEPROM that does not answer,
 * a display that still has a push under way. There are several lanes, so that nothing waits for a faulty panel but what is about
 * panels; within a lane everything happens in the order of the calls, so that a device is closed before it is opened again. */
#ifndef LF_DAEMON_OPENER_H
#define LF_DAEMON_OPENER_H

#include "daemon/worker.h"
#include "device/buttons.h"
#include "device/device.h"
#include "device/edid.h"

typedef enum lf_errand_kind {
    LF_ERRAND_OPEN,    /* a device by its spec */
    LF_ERRAND_CLOSE,   /* an open device, or its buttons */
    LF_ERRAND_LIST,    /* the devices there are */
    LF_ERRAND_BUTTONS, /* the buttons of the panel with this serial number */
    LF_ERRAND_CHECK,   /* whether what is plugged in has another calibration for a display than the cached one */
} lf_errand_kind;

/* A thread each. */
typedef enum lf_lane {
    LF_LANE_PANELS,  /* opening and closing whatever is hardware, or may be (auto) */
    LF_LANE_FILES,   /* opening and closing sim and none, which have nothing in common with it */
    LF_LANE_BUTTONS, /* buttons and checks: they read EEPROMs and drives */
    LF_LANE_LIST,    /* listing, which opens nothing */
    LF_OPENER_LANES,
} lf_lane;

/* The lane in which a device of this spec is opened and closed. */
lf_lane lf_lane_of(const char *spec);

#define LF_LISTED_DEVICES 16

typedef struct lf_errand {
    lf_letter letter; /* posted when it is done; the poster sets open */
    lf_errand_kind kind;
    char spec[512];          /* OPEN; BUTTONS: the serial number */
    const char *calibration; /* OPEN: a file, NULL = the device's own; borrowed */
    char first[512];         /* OPEN: where "auto" begins: the panel that was there last; empty = none */
    bool panel_only;     /* OPEN: "auto" that finds no panel fails like lf_device_find, and is not a device that shows nothing */
    lf_calibration used; /* CHECK: the cached one … */
    lf_edid display;     /* … and what it was found for */
    /* the poster's own */
    void *ticket;
    struct lf_errand *next;
    uint64_t number;  /* OPEN: rises with every wish, so that the last one wins */
    char before[512]; /* OPEN: what had to be closed for it; empty = nothing */
    bool again;       /* OPEN: a device that is missing is tried again */
    bool at_start;    /* OPEN: the daemon's own, of the command line */
    /* the outcome */
    lf_status status;
    bool denied;         /* CHECK: what is plugged in has another one */
    lf_status found;     /* OPEN: what lf_device_find said; LF_OK when it was not asked */
    lf_error err;        /* OPEN: when status is not LF_OK */
    lf_device *device;   /* OPEN: the poster's to take, else closed with the errand; CLOSE: the one to close */
    lf_buttons *buttons; /* BUTTONS and CLOSE: likewise; LF_E_NODEV: that panel has none */
    int n_devices;       /* LIST */
    lf_device_info devices[LF_LISTED_DEVICES];
} lf_errand;

/* A zeroed errand; NULL = out of memory. */
lf_errand *lf_errand_create(lf_errand_kind kind);
/* Closes the device and buttons that nobody took, which may block. */
void lf_errand_destroy(lf_errand *errand);
/* The same, as what opens a letter. */
void lf_errand_forget(void *reader, lf_letter *letter);

typedef struct lf_opener lf_opener;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_opener_create(lf_inbox *inbox, lf_opener **out_opener);
/* Ends when the errands under way have. What is left is closed, or posted as LF_E_CANCELLED. Accepts NULL. */
void lf_opener_destroy(lf_opener *opener);
/* Does the errand in its lane. */
void lf_opener_queue(lf_opener *opener, lf_errand *errand);
/* Waits until all is done, until lf_time_now is end at the latest; false = it is not. */
bool lf_opener_drain(lf_opener *opener, double end);

#endif
