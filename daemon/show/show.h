/* show: a panel kept alive. It opens the device that is asked for, gives it the newest frame at its
 * own pace, tries again when it is missing, looks when something is plugged in, reads its buttons
 * and compares a cached calibration with the panel's own. It knows nobody: what happens is told by
 * events, and whoever made it composes.
 *
 * Life: create, watch_plugs, open …, then stop (nothing is opened any more), close, drain, end,
 * destroy. Everything is the event thread's, and so are the events; they come from the event loop,
 * from lf_inbox_read, or from within a call. */
#ifndef LF_DAEMON_SHOW_H
#define LF_DAEMON_SHOW_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"
#include "daemon/threads/inbox.h"
#include "device/device.h"
#include "device/hid/buttons.h"

typedef struct lf_show lf_show;

/* A frame that is on the panel. */
typedef struct lf_shown {
    int64_t generation;
    lf_level level;
    double passes;
    bool reconstructed;
    char card[LF_CARD_TEXT]; /* the words of a card in the place of a picture; empty: it is one */
} lf_shown;

/* None may be NULL; what is passed is borrowed until the function returns. An event may ask the
 * show and pump it, but not open, stop or end it. */
typedef struct lf_show_events {
    /* lf_show_open with this `answer` has ended: err NULL = the device is there. */
    void (*opened)(void *context, void *answer, const lf_error *err);
    /* lf_show_list with this `answer` has ended: err NULL = these are the devices there are. */
    void (*listed)(void *context, void *answer, const lf_device_info *devices, int n,
                   const lf_error *err);
    /* Which device there is, or why there is none, is another. */
    void (*changed)(void *context);
    /* Frames are made for this lens from now on (NULL: for none) and carry the number `panel`.
     * views: the device wants the views too. is_new: the calibration is not the one before. */
    void (*lens)(void *context, const lf_calibration *calibration, uint64_t panel, bool views,
                 bool is_new);
    /* A frame is on the panel. */
    void (*shown)(void *context, const lf_shown *shown);
    /* What lf_show_keeps answers, or lf_show_await_files was called for, may be another. err not
     * NULL: files could not be written. */
    void (*kept)(void *context, const lf_error *err);
    /* A button of the panel was pressed. */
    void (*pressed)(void *context, lf_button button);
} lf_show_events;

/* Where a show lives; all of it is borrowed and outlives it. */
typedef struct lf_show_home {
    sd_event *event;
    lf_inbox *inbox;         /* read by the event thread */
    lf_mailbox *mailbox;     /* the frames; the show is its consumer */
    const char *calibration; /* a file in the place of the devices' own; NULL = none */
} lf_show_home;

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_create(const lf_show_home *home, const lf_show_events *events,
                                      void *context, lf_show **out_show);
/* Watches udev for what is plugged in; without udev panels are looked for from time to time. */
void lf_show_watch_plugs(lf_show *show);

/* Opens a device in the place of the one there is now, which stays on failure where it need not be
 * closed first; where it had to be, it is opened again. Else on failure there is none (LF_E_NODEV,
 * LF_E_BUSY, LF_E_IO: tried again from time to time). The first one asked for is wanted whether it
 * is there or not. The event `opened` follows, with answer, which is not looked at. LF_E_ARG: the
 * spec is longer than 511 bytes, nothing was begun; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_open(lf_show *show, const char *spec, void *answer, lf_error *err);
/* Looks for the devices there are; the event `listed` follows, with answer. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_list(lf_show *show, void *answer);
/* There may be a new frame: gives it to the panel, if it can take one. */
void lf_show_pump(lf_show *show);

/* Whether a device that keeps what it shows in files holds this generation there, at that level or
 * better, with its views; true for any other device, and where there is none. */
bool lf_show_keeps(lf_show *show, int64_t generation, lf_level level);
/* Somebody waits for them: what is shown now is written soon, and the event `kept` follows, perhaps
 * from within. */
void lf_show_await_files(lf_show *show);

/* What the device is, or what was asked for and why it is not there; false: there is none. */
bool lf_show_info(const lf_show *show, lf_device_info *out);
/* The spec of the device that is open, or could not be opened. */
const char *lf_show_spec(const lf_show *show);
/* Why there is none; NULL = there is one, or nothing is known against it. */
const char *lf_show_problem(const lf_show *show);
/* The calibration of the last panel there was; NULL = it has none. Until the next `lens`. */
const lf_calibration *lf_show_calibration(const lf_show *show);
/* Updates, bytes and errors of all devices so far. */
lf_device_counters lf_show_counters(const lf_show *show);

/* From now on no device is opened; what comes to an end is told as LF_E_CANCELLED. */
void lf_show_stop(lf_show *show);
/* Waits for what was pushed, at most timeout_ms, and begins to close. */
void lf_show_close(lf_show *show, int timeout_ms);
/* Waits until all is closed, until lf_time_now is `end` at the latest; false = it is not. */
bool lf_show_drain(lf_show *show, double end);
/* Ends the threads, and answers what was not opened yet; the inbox must be read once more before
 * the show is destroyed. Accepts NULL. */
void lf_show_end(lf_show *show);
/* After lf_show_end. Accepts NULL. */
void lf_show_destroy(lf_show *show);

#endif
