/* The inside of show.h, shared by show.c (the device and what is told of it), show_open.c (opening
 * and trying again), show_push.c (frames), show_kept.c (what of them is in files), show_buttons.c,
 * show_check.c (a cached calibration) and show_plugs.c (what udev tells). */
#ifndef LF_DAEMON_SHOW_INTERNAL_H
#define LF_DAEMON_SHOW_INTERNAL_H

#include <systemd/sd-device.h>

#include "daemon/show/opener.h"
#include "daemon/show/show.h"

enum { LF_KEPT_PENDING = 8 };

/* Something that is done one at a time, and once more when it was asked for meanwhile. */
typedef enum lf_search {
    LF_SEARCH_REST,
    LF_SEARCH_BUSY,
    LF_SEARCH_AGAIN, /* busy, and asked for again */
} lf_search;

typedef enum lf_push_state {
    LF_PUSH_WHOLE,   /* the next push must be the whole frame */
    LF_PUSH_CHANGES, /* the next push may be what has changed */
    LF_PUSH_BUSY,    /* a push is under way */
} lf_push_state;

/* What the panel is being given. */
typedef struct lf_push {
    lf_push_state state;
    lf_shown frame;   /* under way */
    bool lacks_views; /* it came without its own */
} lf_push;

/* A push that ended well, as it may be found in the files of the device. */
typedef struct lf_kept_push {
    uint64_t number; /* of those that ended well, from 1 */
    int64_t generation;
    lf_level level;
} lf_kept_push;

/* What of that is in the files of a device that has some. */
typedef struct lf_kept {
    uint64_t pushes; /* that ended well, on this device */
    int n;           /* pushes with a generation or level of their own, not in the files yet … */
    lf_kept_push pending[LF_KEPT_PENDING]; /* … in their order; the last stands for those that were
                                              too many */
    lf_kept_push held;                     /* the newest that is; number 0 = none */
    bool awaited;
    bool lost; /* they were removed; a new device comes for them */
} lf_kept;

/* What is being opened. */
typedef struct lf_opening {
    char wanted[512]; /* the spec asked for, which is tried again when a device has gone */
    char last[512];   /* the panel that was open last, as its spec; empty = none yet */
    lf_opener_request *busy[LF_OPENER_QUEUES]; /* under way; NULL = none … */
    lf_opener_request *waiting; /* … and those behind them, in the order of calls */
    uint64_t requests;          /* so many so far; the number of the one … */
    uint64_t taken;             /* … whose device is, or was last, the panel's */
    lf_status found;            /* what lf_device_find said last, for "auto" */
    bool plugged;               /* something was, since a device was last looked for */
    sd_event_source *retry;
    double retry_at;       /* lf_time_now when retry is due */
    uint64_t backoff_usec; /* before the next attempt that is not hurried */
} lf_opening;

struct lf_show {
    lf_show_home home;
    lf_show_events events;
    void *context;
    lf_opener *opener;
    bool stopping;
    lf_device *device; /* NULL while unplugged */
    sd_event_source *device_io;
    char spec[512];            /* the one that is open, or could not be opened */
    lf_error problem;          /* why there is none; status LF_OK = nothing is known */
    lf_device_counters before; /* of devices closed by now */
    /* the last panel there was, and is if there is one */
    uint64_t number; /* rises with every panel that is not the one before; frames carry it */
    lf_calibration calibration;
    bool has_calibration;
    bool has_views; /* it takes the views behind a frame too */
    lf_push push;
    lf_kept kept;
    lf_opening opening;
    lf_buttons *buttons; /* of the panel; NULL = none */
    sd_event_source *buttons_io;
    lf_search seeking;  /* buttons */
    lf_search checking; /* whether a calibration from the cache is the panel's own */
    sd_device_monitor *plugs;
    bool told_of_plugs; /* there is an udev to tell what is plugged in */
};

/* ------------------------------------------------------------------------------------ show.c -- */

/* Whether nothing but a stand-in is there. */
bool lf_show_is_empty(const lf_show *show);
/* Closes a device or buttons (either may be NULL), which may wait for the panel, on the opener's
 * threads. */
void lf_show_discard(lf_show *show, lf_device *device, lf_buttons *buttons);
/* Lets go of the device; its counters are kept. */
void lf_show_let_go(lf_show *show);
/* The device said that it is gone. */
void lf_show_gone(lf_show *show, const char *why);
/* The panel is this device from now on (taken over whatever comes of it). */
LF_NODISCARD lf_status lf_show_take(lf_show *show, lf_device *device, lf_error *err);

/* ------------------------------------------------------------------------------- show_open.c -- */

/* A device that was there has gone, and is wanted again. */
void lf_show_reopen_soon(lf_show *show);
/* Opens what is wanted anew. */
void lf_show_open_again(lf_show *show);
/* Looks at the panel again after usec: pushes what failed, or opens what is missing. */
void lf_show_retry(lf_show *show, uint64_t usec);
void lf_show_cancel_retry(lf_show *show);
/* Something was plugged in: a device that is missing is tried again soon; at once, where it is a
 * panel that is there with all its parts and rights. */
void lf_show_plugged(lf_show *show, bool whole);
/* Devices that wait to be opened are not opened any more. */
void lf_show_drop_requests(lf_show *show);

/* ------------------------------------------------------------------------------- show_push.c -- */

/* Asks the device what became of the push under way. */
void lf_show_dispatch(lf_show *show);

/* ------------------------------------------------------------------------------- show_kept.c -- */

/* Another device. */
void lf_show_forget_kept(lf_show *show);
/* The push under way has ended well. */
void lf_show_count_push(lf_show *show);
/* Looks what the files hold by now, and tells. */
void lf_show_look_at_files(lf_show *show);

/* ---------------------------------------------------------------------------- show_buttons.c -- */

/* Looks for the buttons of the panel that was opened. */
void lf_show_find_buttons(lf_show *show);
void lf_show_drop_buttons(lf_show *show);

/* ------------------------------------------------------------------------------ show_check.c -- */

/* Something was plugged in that may be where the panel's own calibration is. */
void lf_show_check_calibration(lf_show *show);

/* ------------------------------------------------------------------------------ show_plugs.c -- */

void lf_show_unwatch_plugs(lf_show *show);

#endif
