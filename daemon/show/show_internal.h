/* Internals of show.h, shared by show.c (the device and its reports), show_open.c (opening and
 * retries), show_push.c (frames), show_kept.c (frames in files), show_buttons.c, show_check.c (a
 * cached calibration) and show_plugs.c (udev events). */
#ifndef LF_DAEMON_SHOW_INTERNAL_H
#define LF_DAEMON_SHOW_INTERNAL_H

#include <systemd/sd-device.h>

#include "daemon/show/opener.h"
#include "daemon/show/show.h"

enum { LF_KEPT_PENDING = 8 };

/* A task that runs once at a time, and again if it was requested meanwhile. */
typedef enum lf_search {
    LF_SEARCH_REST,
    LF_SEARCH_BUSY,
    LF_SEARCH_AGAIN, /* busy, and requested again */
} lf_search;

typedef enum lf_push_state {
    LF_PUSH_WHOLE,   /* the next push must be a whole frame */
    LF_PUSH_CHANGES, /* the next push may be the changed rectangles */
    LF_PUSH_BUSY,    /* a push is in progress */
} lf_push_state;

/* The push in progress. */
typedef struct lf_push {
    lf_push_state state;
    lf_shown frame;   /* the frame pushed */
    bool lacks_views; /* it came without its views */
} lf_push;

/* A successful push, for comparison with the device's files. */
typedef struct lf_kept_push {
    uint64_t number; /* count of successful pushes, from 1 */
    int64_t generation;
    lf_level level;
} lf_kept_push;

/* The state of the device's files, for devices that write some. */
typedef struct lf_kept {
    uint64_t pushes; /* successful pushes on this device */
    int n;           /* pushes, with a generation or level of their own, that are not in the files
                      * yet … */
    /* … in order; if there are too many, the last one replaces the rest */
    lf_kept_push pending[LF_KEPT_PENDING];
    lf_kept_push held; /* the newest push in the files; number 0 = none */
    bool awaited;
    bool lost; /* the files were removed; a new device is opened for them */
} lf_kept;

/* Requests to open devices. */
typedef struct lf_opening {
    char wanted[512]; /* the requested spec, retried when its device is gone */
    char last[512];   /* spec of the panel that was open last; empty = none yet */
    lf_opener_request *busy[LF_OPENER_QUEUES]; /* in progress; NULL = none … */
    lf_opener_request *waiting; /* … and those queued after them, in the order of calls */
    uint64_t requests;          /* number of requests so far */
    uint64_t taken;             /* number of the request whose device is or was last the panel's */
    lf_status found;            /* last result of lf_device_find, for "auto" */
    bool plugged;               /* a device was plugged in since the last search */
    sd_event_source *retry;
    double retry_at;       /* lf_time_now when retry is due */
    uint64_t backoff_usec; /* delay before the next regular retry */
} lf_opening;

struct lf_show {
    lf_show_home home;
    lf_show_events events;
    void *context;
    lf_opener *opener;
    bool stopping;
    lf_device *device; /* NULL while unplugged */
    sd_event_source *device_io;
    char spec[512];            /* the device that is open, or could not be opened */
    lf_error problem;          /* why there is no device; status LF_OK = no error known */
    lf_device_counters before; /* totals of closed devices */
    /* the current panel, or the last one */
    uint64_t number; /* rises with every change of panel; frames carry it */
    lf_calibration calibration;
    bool has_calibration;
    bool has_views; /* it also takes a frame's views */
    lf_push push;
    lf_kept kept;
    lf_opening opening;
    lf_buttons *buttons; /* of the panel; NULL = none */
    sd_event_source *buttons_io;
    lf_search seeking;  /* buttons */
    lf_search checking; /* comparing a cached calibration with the panel's own */
    sd_device_monitor *plugs;
    bool told_of_plugs; /* udev reports plugged devices */
};

/* ------------------------------------------------------------------------------------ show.c -- */

/* True if there is no device, or only a stand-in. */
bool lf_show_is_empty(const lf_show *show);
/* Closes a device or buttons (either may be NULL) on the opener's threads, because closing may wait
 * for the panel. */
void lf_show_discard(lf_show *show, lf_device *device, lf_buttons *buttons);
/* Discards the device; keeps its counters. */
void lf_show_let_go(lf_show *show);
/* The device has reported that it is gone. */
void lf_show_gone(lf_show *show, const char *why);
/* Makes this device the panel; takes ownership, also on failure. */
LF_NODISCARD lf_status lf_show_take(lf_show *show, lf_device *device, lf_error *err);

/* ------------------------------------------------------------------------------- show_open.c -- */

/* The device is gone; it will be opened again. */
void lf_show_reopen_soon(lf_show *show);
/* Opens the wanted device again. */
void lf_show_open_again(lf_show *show);
/* Schedules a retry after usec: pushes a failed frame again, or opens the missing device. */
void lf_show_retry(lf_show *show, uint64_t usec);
void lf_show_cancel_retry(lf_show *show);
/* Something was plugged in: retries a missing device soon, or at once if `whole`: a panel is
 * connected with all its parts and access rights. */
void lf_show_plugged(lf_show *show, bool whole);
/* Cancels queued requests to open devices. */
void lf_show_drop_requests(lf_show *show);

/* ------------------------------------------------------------------------------- show_push.c -- */

/* Asks the device for the result of the push in progress. */
void lf_show_dispatch(lf_show *show);

/* ------------------------------------------------------------------------------- show_kept.c -- */

/* The device has changed: resets the records of files. */
void lf_show_forget_kept(lf_show *show);
/* The push in progress was successful. */
void lf_show_count_push(lf_show *show);
/* Checks what the files hold, and reports it. */
void lf_show_look_at_files(lf_show *show);

/* ---------------------------------------------------------------------------- show_buttons.c -- */

/* Searches for the buttons of the panel. */
void lf_show_find_buttons(lf_show *show);
void lf_show_drop_buttons(lf_show *show);

/* ------------------------------------------------------------------------------ show_check.c -- */

/* A device was plugged in that may hold the panel's own calibration. */
void lf_show_check_calibration(lf_show *show);

/* ------------------------------------------------------------------------------ show_plugs.c -- */

void lf_show_unwatch_plugs(lf_show *show);

#endif
