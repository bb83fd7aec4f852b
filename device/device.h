/* device: displays that take a panel frame. Each kind of device is a table of functions in a file
 * of its own; the rest of quiltd includes only this header. To add a kind, write device/KIND.c with
 * an lf_device_ops, name it in device/device_table.h and in the table of device/device.c, and test
 * it in tests/device/.
 *
 * Threads: all calls on a device come from one thread (the daemon's event thread) and return within
 * 5 ms. Exceptions are destroy, flush, and the copies in push and views (1 ms for a whole Portrait,
 * 28 ms for 7680x4320). Longer work (encoding, transfers, files) runs on the device's own thread or
 * asynchronously, and is announced through the poll descriptor. Different devices may be used by
 * different threads.
 *
 * Life cycle: open -> (push -> dispatch … until READY)* -> destroy.
 *
 * Unplugging is normal, not a failure: dispatch returns LF_DEVICE_GONE (or push LF_E_NODEV). After
 * that only info, counters and destroy may be called. The caller opens again when it likes, and
 * gets LF_E_NODEV until the device is back.
 *
 * Coordinates: pixels of the panel, row 0 at the top, display-encoded RGB that is shown
 * unchanged. */
#ifndef LF_DEVICE_H
#define LF_DEVICE_H

#include "base/calibration.h"
#include "base/image.h"

typedef struct lf_device lf_device;

/* Description of a device, for device.list and status. Strings are sanitised UTF-8: no control
 * characters, cut at a character. */
typedef struct lf_device_info {
    char spec[512]; /* value of --device for this device: "sim:/run/x", "none" */
    char kind[16];  /* kind in the table: "sim", "none" */
    char model[64]; /* the display's own name (EDID), if any */
    char serial[64];
    char calibration_from[256]; /* source of the calibration; empty = none */
    bool calibration_cached;    /* it comes from the cache; the panel's own was not available */
    char output[64];            /* "file", connector, USB address */
    char problem[256];          /* the problem and its remedy; empty = none */
} lf_device_info;

typedef enum lf_device_event {
    LF_DEVICE_READY, /* takes the next frame */
    LF_DEVICE_BUSY,  /* the last push is still in progress */
    LF_DEVICE_GONE,  /* unplugged: only info, counters and destroy from now on */
    LF_DEVICE_LOST,  /* like GONE: the folder that it writes into was removed */
    /* The last push failed and was not shown: the panel shows older or unknown contents. Reported
     * once. The device takes a frame now (as READY), which must be pushed whole. */
    LF_DEVICE_RETRY,
} lf_device_event;

typedef struct lf_device_counters {
    uint64_t updates; /* rectangles shown */
    uint64_t bytes;   /* bytes on the wire for them */
    uint64_t errors;  /* failed pushes, and files that could not be written */
} lf_device_counters;

/* One kind of device. A member may be NULL only if its comment says so.
 *
 * Functions get devices that open made, or half-made ones in destroy. No other code writes into a
 * device. Functions do not log; information for the user goes into lf_error or
 * lf_device_info.problem. */
typedef struct lf_device_ops {
    /* The word before the colon of a spec: lower case, no colon, not "auto". */
    const char *kind;

    /* It shows frames. False: it takes and counts frames in place of a panel. */
    bool is_panel;
    /* Real hardware: opening and closing may take as long as a faulty panel takes, udev reports
     * when it comes back, and buttons may belong to it. False: memory and files. */
    bool is_hardware;
    /* True if two arguments may name the same device, so that one must be closed before the other
     * is opened. May look at files. NULL = any two may. */
    bool (*same)(const char *argument, const char *other);
    /* The length of the prefix of the argument that names the folder the device writes into. A
     * client that opens the device writes there. NULL = it writes nowhere. */
    size_t (*folder)(const char *argument);
    /* Suffix for an argument that forbids following links on the way to that folder. NULL = it
     * writes nowhere. */
    const char *no_links;

    /* Finds the connected panels of this kind without disturbing them or their users: no exclusive
     * opening, no mode setting. Fills at most max entries of out and returns their number. spec is
     * what open takes, with kind and colon; problem says if another program uses it. Returns 0 both
     * if nothing is found and if nothing is accessible.
     *
     * A device that may be a panel but does not identify itself gets an empty model, with the
     * reason in problem. It is listed, but "auto" never takes it.
     *
     * NULL = devices of this kind cannot be found, only named. Called rarely (at the start, after
     * an unplug, for device.list) and never by the event thread. Takes some 50 ms, or 1 s if a
     * desktop does not answer (window). */
    int (*probe)(lf_device_info *out, int max);

    /* Opens the device that `argument` names: the text after the colon, "" when absent. calibration
     * (may be NULL; copied) overrides the device's own. Leaves the panel's contents; the first push
     * is whole. On LF_OK *out_device is owned by the caller, with its ops set, and is READY. On
     * failure nothing is kept and *out_device is untouched:
     *   LF_E_NODEV   not connected (now): retry when a device is plugged in
     *   LF_E_BUSY    another program (another daemon, or this one) has it
     *   LF_E_ARG     the argument is invalid: retrying is useless
     *   LF_E_FORMAT  its calibration is damaged
     *   LF_E_IO, LF_E_NOMEM */
    lf_status (*open)(const char *argument, const lf_calibration *calibration,
                      lf_device **out_device, lf_error *err);

    /* Waits for a push in progress (at most 1 s, then drops it), writes pending files, ends the
     * device's threads, releases the panel, frees. Accepts half-built and unplugged devices, but
     * not NULL. May block, but not for ever: a desktop that does not answer is abandoned after 1 s
     * more. Until it answers, open returns LF_E_BUSY. */
    void (*destroy)(lf_device *device);

    /* Fills *out; fast, never communicates with the device. */
    void (*info)(const lf_device *device, lf_device_info *out);

    /* The panel's size and lens. NULL: the device has none; nothing is interlaced for it, and it
     * takes pushes with frame NULL. Valid and constant until destroy. */
    const lf_calibration *(*calibration)(const lf_device *device);

    /* Shows rects[n] of frame (the calibration's screen size, 3 channels). n may be 0: nothing
     * changes, but the push counts. The pixels are copied or sent before it returns; frame and
     * rects are not kept. generation: of the frame, for devices that record it.
     *
     * To be called only when the device is ready: just opened, or dispatch returned READY or RETRY
     * after the last push. After LF_OK the device is busy until dispatch reports otherwise. On
     * failure nothing was taken:
     *   LF_E_STATE   the last push is still in progress
     *   LF_E_NODEV   unplugged
     *   LF_E_ARG     wrong shape, a rectangle outside the panel, or more than
     *                LF_DEVICE_MAX_RECTS */
    lf_status (*push)(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                      uint64_t generation);

    /* Passes a frame's views to devices that also show views (the simulated one), before the push
     * of that frame. The newest views win. They are copied, or silently declined. columns x rows
     * tiles, view 0 at the bottom left. The copy takes time (10 ms for 45 views of a Portrait, more
     * the first time): call it only for frames that are pushed. NULL = not wanted. */
    void (*views)(lf_device *device, const lf_views8 *views, int columns, int rows);

    /* A descriptor, owned by the device and constant until destroy. It polls readable (level
     * triggered) while dispatch has news: after every push that ended or failed, and on unplugging.
     * -1 = the device is always READY, also right after a push. */
    int (*poll_fd)(const lf_device *device);

    /* Clears the descriptor's readiness and returns the state. May be called at any time. */
    lf_device_event (*dispatch)(lf_device *device);

    /* For devices that keep what they show in files. Counts the successful pushes since open that
     * are completely in these files, with the views given before them. awaited: a client waits for
     * the last push, so it is written as soon as possible. poll_fd then polls readable once when it
     * is written or has failed. NULL = no such files.
     *   LF_E_IO      the last attempt to write failed; info.problem says why
     *   LF_E_NODEV   the folder was removed; dispatch will return LF_DEVICE_LOST */
    lf_status (*kept)(lf_device *device, bool awaited, uint64_t *out_pushes);

    /* Totals since open. */
    void (*counters)(const lf_device *device, lf_device_counters *out);

    /* Waits until the push in progress has ended and everything shown is on the device (sim: in its
     * files), at most timeout_ms. Does not replace dispatch, which still reports how the push
     * ended. LF_E_TIMEOUT; LF_E_NODEV unplugged; LF_E_IO a file could not be written. May block:
     * called only at the end and by tests. */
    lf_status (*flush)(lf_device *device, int timeout_ms);
} lf_device_ops;

#define LF_DEVICE_MAX_RECTS 4096

/* First field of every device. */
struct lf_device {
    const lf_device_ops *ops;
};

/* Opens the first panel found that identifies itself as one and can be opened. first: the spec to
 * try first, empty = any; the device now at this spec must pass the same checks. On failure
 * *out_device is untouched, and err holds the reason:
 *   LF_E_NODEV   no panel is connected, or none with a known calibration: retry when a device is
 *                plugged in
 *   LF_E_BUSY    another program has it
 *   LF_E_IO      a panel cannot be used now: it does not answer, its calibration cannot be read,
 *                no permission */
LF_NODISCARD lf_status lf_device_find(const char *first, const lf_calibration *calibration,
                                      lf_device **out_device, lf_error *err);
/* A "none" device whose info.problem is `problem`. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_none_create(const char *problem, lf_device **out_device, lf_error *err);
/* Opens by spec "KIND[:ARGUMENT]" (at most 511 bytes). "auto" = the panel that lf_device_find
 * finds, otherwise "none" with the reason in info.problem. Errors of lf_device_ops.open; LF_E_ARG
 * for an unknown kind. On LF_OK the caller owns *out_device.
 *   none                        takes and counts frames, shows nothing, has no calibration
 *   drm[:OUTPUT]                a display output without a desktop: device/drm/drm.c
 *   window[:MONITOR]            a monitor of a desktop: device/window/window.c
 *   usb[:BUS-PORT]              a display with an open protocol over USB: device/usb/usb.c; if the
 *                               kernel's driver uses the display, the result is a drm device
 *   sim:DIR[,OPTION=VALUE…]     files in DIR: device/sim/sim.c */
LF_NODISCARD lf_status lf_device_open(const char *spec, const lf_calibration *calibration,
                                      lf_device **out_device, lf_error *err);
/* Accepts NULL. */
void lf_device_destroy(lf_device *device);

/* Queries about a spec, before anything is opened. Any thread; only lf_device_same looks at
 * files. */

/* True if it is "auto", which leaves the choice to lf_device_find. */
bool lf_device_is_auto(const char *spec);
/* "auto", then the kinds of the table; NULL after the last. */
const char *lf_device_kind_at(int index);
/* True if it names a device of this kind. */
bool lf_device_has_kind(const char *spec, const char *kind);
/* lf_device_ops.is_panel of its kind; true for "auto" and for unknown kinds. */
bool lf_device_is_panel(const char *spec);
/* lf_device_ops.is_hardware of its kind; true for "auto" and for unknown kinds. */
bool lf_device_is_hardware(const char *spec);
/* True if spec may name the same device as `open`, the spec of an open device. */
bool lf_device_same(const char *open, const char *spec);
/* The start and length, within spec, of the folder that the device writes into; NULL = it writes
 * nowhere. */
const char *lf_device_folder(const char *spec, size_t *out_length);
/* The spec (lf_free) of the same device with its folder replaced by `folder`, a canonical path that
 * was checked. The new spec forbids following links, so that a link created after the check has no
 * effect. spec must name a folder. NULL = out of memory. */
char *lf_device_allowed_spec(const char *spec, const char *folder);

/* Devices that could be opened now, panels first, "none" last; returns how many were written (at
 * most max). */
int lf_device_list(lf_device_info *out, int max);

#endif
