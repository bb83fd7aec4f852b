/* show: keeps a panel running. It opens the requested device, pushes the newest frame at the
 * device's pace, retries a missing device, reacts to plugged devices, reads buttons, and compares a
 * cached calibration with the panel's own. It depends on neither the server nor the engine. It
 * reports through the callbacks of lf_show_events, and its owner reacts.
 *
 * Life cycle: create, watch_plugs, open …, then stop (no device is opened any more), close, drain,
 * end, destroy.
 *
 * Thread: event, including the callbacks. They come from the event loop, from lf_inbox_read, or
 * from within a call. */
#ifndef LF_DAEMON_SHOW_H
#define LF_DAEMON_SHOW_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"
#include "daemon/show/opener.h"
#include "daemon/threads/inbox.h"
#include "device/device.h"
#include "device/hid/buttons.h"

typedef struct lf_show lf_show;

/* The frame on the panel. */
typedef struct lf_shown {
    int64_t generation;
    lf_level level;
    double passes;
    bool reconstructed;
    bool fades;              /* mixed with an earlier image; its level is at most coarse */
    bool moves;              /* one of many frames of a video */
    char card[LF_CARD_TEXT]; /* text of a card shown instead of a picture; empty: a picture */
} lf_shown;

/* No member may be NULL. Arguments are borrowed until the function returns. A callback may query
 * and pump the show, but not open, stop or end it. */
typedef struct lf_show_events {
    /* lf_show_open with this `answer` has ended; err NULL = the device is open. */
    void (*opened)(void *context, void *answer, const lf_error *err);
    /* lf_show_list with this `answer` has ended; err NULL = devices[n] are the devices found. */
    void (*listed)(void *context, void *answer, const lf_device_info *devices, int n,
                   const lf_error *err);
    /* lf_show_examine with this `answer` has ended; err NULL = `look` has got what was found. */
    void (*examined)(void *context, void *answer, const lf_error *err);
    /* The device, or the reason why there is none, has changed. */
    void (*changed)(void *context);
    /* From now on make frames for this calibration (NULL: for none) with the number `panel`. views:
     * the device also wants the views. is_new: the calibration has changed. */
    void (*lens)(void *context, const lf_calibration *calibration, uint64_t panel, bool views,
                 bool is_new);
    /* A frame is shown on the panel. */
    void (*shown)(void *context, const lf_shown *shown);
    /* The result of lf_show_keeps, or the files awaited by lf_show_await_files, may have changed.
     * err not NULL: files could not be written. */
    void (*kept)(void *context, const lf_error *err);
    /* A button of the panel was pressed. */
    void (*pressed)(void *context, lf_button button);
} lf_show_events;

/* Environment of the show; all of it is borrowed and must outlive it. */
typedef struct lf_show_home {
    sd_event *event;
    lf_inbox *inbox;         /* read by the event thread */
    lf_mailbox *mailbox;     /* source of frames; the show is its consumer */
    const char *calibration; /* a file used instead of the device's own; NULL = none */
} lf_show_home;

/* events is copied. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_create(const lf_show_home *home, const lf_show_events *events,
                                      void *context, lf_show **out_show);
/* Watches udev for plugged devices. Without udev, panels are searched for from time to time. */
void lf_show_watch_plugs(lf_show *show);

/* Opens a device instead of the current one. The event `opened` follows with `answer`, which the
 * show does not interpret.
 *
 * On failure the current device stays if it need not be closed first; otherwise it is opened again.
 * If there was none, there is none after the failure, and the show retries after LF_E_NODEV,
 * LF_E_BUSY and LF_E_IO. The first spec requested stays wanted whether or not its device is
 * connected. LF_E_ARG: the spec is longer than 511 bytes and nothing was begun; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_open(lf_show *show, const char *spec, void *answer, lf_error *err);
/* Searches for devices; the event `listed` follows with `answer`. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_list(lf_show *show, void *answer);
/* Searches for devices and for calibrations, which may take a minute: `look` is called with them
 * and with `answer`, on the thread that has searched. The event `examined` follows. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_show_examine(lf_show *show, lf_look_fn look, void *answer);
/* A new frame may be ready: pushes it if the panel can take one. */
void lf_show_pump(lf_show *show);

/* For a device that writes what it shows to files: true if they hold this generation at this level
 * or better, with its views. True for any other device, and without a device. */
bool lf_show_keeps(lf_show *show, int64_t generation, lf_level level);
/* A client waits for the files: writes the current frame soon. The event `kept` follows, possibly
 * from within. */
void lf_show_await_files(lf_show *show);

/* Describes the device, or the requested one and why it is missing; false: neither. */
bool lf_show_info(const lf_show *show, lf_device_info *out);
/* The spec of the device that is open or could not be opened. */
const char *lf_show_spec(const lf_show *show);
/* The spec that was last chosen: of the device that is open, or that is searched for. */
const char *lf_show_wanted(const lf_show *show);
/* Why there is no device; NULL = there is one, or no error is known. */
const char *lf_show_problem(const lf_show *show);
/* The calibration of the last panel; NULL = it has none. Valid until the next event `lens`. */
const lf_calibration *lf_show_calibration(const lf_show *show);
/* Updates, bytes and errors of all devices so far. */
lf_device_counters lf_show_counters(const lf_show *show);

/* From now on opens no device; requests that end are reported as LF_E_CANCELLED. */
void lf_show_stop(lf_show *show);
/* Waits for the push in progress, at most timeout_ms, and begins to close the device. */
void lf_show_close(lf_show *show, int timeout_ms);
/* Waits until all devices are closed, at most until lf_time_now is `end`; false = not all are. */
bool lf_show_drain(lf_show *show, double end);
/* Ends the threads and answers pending requests. The inbox must be read once more before the show
 * is destroyed. Accepts NULL. */
void lf_show_end(lf_show *show);
/* After lf_show_end. Accepts NULL. */
void lf_show_destroy(lf_show *show);

#endif
