/* device: displays that take a panel frame. A device is a member of a table of functions, one file
 * a member; the rest of quiltd knows only this page. Written so that a new member can be made by
 * reading it alone: make device/KIND.c with an lf_device_ops, name it in device/device_table.h and
 * in the table of device/device.c, test it in tests/device/.
 *
 * Threads: every call on a device comes from one thread (the daemon's event thread) and must return
 * within 5 ms, destroy and flush excepted, and push and views where they copy what they are given
 * (1 ms for a whole Portrait, 28 ms for 7680x4320): whatever takes longer (encoding, transfers,
 * files) happens in the device's own thread or asynchronously and is announced through the poll
 * descriptor. Different devices may be used by different threads. Life: open -> (push -> dispatch …
 * until READY)* -> destroy. Unplugging is normal, not a failure: dispatch says LF_DEVICE_GONE (or
 * push LF_E_NODEV), after which only info, counters and destroy may be called; the caller opens
 * again when it likes, and gets LF_E_NODEV until the device is back. Coordinates: pixels of the
 * panel, row 0 at the top, display-encoded RGB that is shown unchanged. */
#ifndef LF_DEVICE_H
#define LF_DEVICE_H

#include "base/calibration.h"
#include "base/image.h"

typedef struct lf_device lf_device;

/* What a device is, for device.list and status. Strings are sanitised UTF-8: no control characters,
 * cut at a character. */
typedef struct lf_device_info {
    char spec[512]; /* what --device takes to get this one: "sim:/run/x", "none" */
    char kind[16];  /* member of the table: "sim", "none" */
    char model[64]; /* the display's own name (EDID), where it has one */
    char serial[64];
    char calibration_from[256]; /* where the calibration came from; empty = none */
    bool calibration_cached;    /* it was read before; the panel's own was not there */
    char output[64];            /* "file", connector, USB address */
    char problem[256];          /* what is wrong and what to do; empty = nothing */
} lf_device_info;

typedef enum lf_device_event {
    LF_DEVICE_READY, /* takes the next frame */
    LF_DEVICE_BUSY,  /* the last push is still under way */
    LF_DEVICE_GONE,  /* unplugged: only info, counters and destroy from now on */
    LF_DEVICE_LOST,  /* the same: the folder that it writes into was removed */
    /* the last push failed and was not shown: the panel's contents are the older ones, or unknown.
       Told once; takes a frame now (as READY), which must be pushed whole */
    LF_DEVICE_RETRY,
} lf_device_event;

typedef struct lf_device_counters {
    uint64_t updates; /* rectangles shown */
    uint64_t bytes;   /* bytes on the wire for them */
    uint64_t errors;  /* failed pushes, and files that a device with files could not write */
} lf_device_counters;

/* One member of the table. Members may be NULL only where that is said.
 *
 * Every function gets devices that open made, or half-made ones in destroy; nobody else writes into
 * a device. Functions do not log; what the user should know goes into lf_error or
 * lf_device_info.problem. */
typedef struct lf_device_ops {
    /* Word before the colon of a spec: lower case, no colon, not "auto". */
    const char *kind;

    /* It shows something. False: it takes and counts frames in the place of a panel. */
    bool is_panel;
    /* It is plugged in: opening and closing it may take as long as a faulty panel takes, udev tells
     * when it comes back, and buttons may belong to it. False: memory and files. */
    bool is_hardware;
    /* Whether two arguments may name the same device, so that one must be closed before the other
     * is opened. May look at files. NULL = any two may. */
    bool (*same)(const char *argument, const char *other);
    /* How much of the argument, from its start, names the folder that the device writes into: a
     * client that opens it writes there. NULL = it writes nowhere. */
    size_t (*folder)(const char *argument);
    /* What is put behind an argument so that no link is followed on the way to that folder. NULL =
     * it writes nowhere. */
    const char *no_links;

    /* Finds the panels of this kind that are there now, without disturbing them or whoever uses
     * them: no exclusive opening, no mode setting. Fills at most max entries of out (spec is what
     * open takes, with the kind and the colon; problem says when it is used by somebody else) and
     * returns their number; nothing found and nothing accessible are both 0. What may be a panel
     * but does not say so is told with model empty and why in problem: it is listed, and never
     * taken by "auto". NULL = devices of this kind cannot be found, only named. Called rarely (at
     * the start, after a unplug, for device.list), and never by the event thread: takes some 50 ms,
     * and 1 s where a desktop does not answer (window). */
    int (*probe)(lf_device_info *out, int max);

    /* Opens what `argument` names: the text behind the colon, "" when absent. calibration (may be
     * NULL; copied) overrides the device's own. Leaves the panel as it is: the first push is whole.
     * On LF_OK *out_device is owned by the caller, with its ops set, and in state READY. On failure
     * nothing is kept and *out_device is untouched:
     *   LF_E_NODEV   it is not there (now): worth trying again when something is plugged in
     *   LF_E_BUSY    another program (another daemon, or this one) has it
     *   LF_E_ARG     the argument cannot be understood: trying again is useless
     *   LF_E_FORMAT  its calibration is damaged
     *   LF_E_IO, LF_E_NOMEM */
    lf_status (*open)(const char *argument, const lf_calibration *calibration,
                      lf_device **out_device, lf_error *err);

    /* Waits for a push in flight (at most 1 s, then drops it), writes what is owed, ends the
     * device's threads, gives the panel back, frees. Accepts half-built and unplugged devices;
     * never NULL. May block, but not for ever: what does not answer (a desktop) is left behind
     * after 1 s more, and until it does, open says LF_E_BUSY. */
    void (*destroy)(lf_device *device);

    /* Fills *out; cheap, never talks to the device. */
    void (*info)(const lf_device *device, lf_device_info *out);

    /* The panel's size and lens; NULL when the device has none: nothing is interlaced for it, and
     * it takes pushes with frame NULL. Valid and unchanging until destroy. */
    const lf_calibration *(*calibration)(const lf_device *device);

    /* Shows rects[n] of frame (the calibration's screen size, 3 channels). n may be 0: nothing
     * changes, but the push counts. The pixels are copied (or sent) before it returns; neither
     * frame nor rects are kept. generation is what the frame shows, for devices that write it down.
     * Only when the device is ready: just opened, or dispatch said READY or RETRY after the last
     * push. After LF_OK the device is busy until dispatch says otherwise. Not LF_OK: nothing was
     * taken.
     *   LF_E_STATE   the last push is still under way
     *   LF_E_NODEV   unplugged
     *   LF_E_ARG     wrong shape, a rectangle outside of the panel, or more than
     *                LF_DEVICE_MAX_RECTS */
    lf_status (*push)(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                      uint64_t generation);

    /* Gives the views behind a frame to devices that show them too (the simulated one), before the
     * push of that frame; the newest win. Copied, or declined without a word. columns x rows tiles,
     * view 0 at the bottom left. Copying takes what memory takes (10 ms for 45 views of a Portrait,
     * more the first time): call it for frames that are pushed only. NULL = not wanted. */
    void (*views)(lf_device *device, const lf_views8 *views, int columns, int rows);

    /* A descriptor, the device's own and the same until destroy, that polls readable (level
     * triggered) whenever dispatch has something new to tell: after every push that ended or
     * failed, and on unplugging. -1 = the device is always READY, also right after a push. */
    int (*poll_fd)(const lf_device *device);

    /* Consumes readiness and tells the state. May be called at any time. */
    lf_device_event (*dispatch)(lf_device *device);

    /* How many of the pushes that ended well, counted since open, are whole in the files that the
     * device keeps of what it shows, with the views given before them. awaited: somebody waits for
     * the last one: it is written as soon as may be, and poll_fd polls readable once when it is, or
     * could not be. NULL = it has no such files.
     *   LF_E_IO      the last attempt to write failed; info.problem says how
     *   LF_E_NODEV   they were removed with their folder; dispatch will say LF_DEVICE_LOST */
    lf_status (*kept)(lf_device *device, bool awaited, uint64_t *out_pushes);

    /* Totals since open. */
    void (*counters)(const lf_device *device, lf_device_counters *out);

    /* Waits until the push under way has ended and everything shown is on the device (sim: in its
     * files), at most timeout_ms. Does not replace dispatch: how the push ended is still told
     * there. LF_E_TIMEOUT; LF_E_NODEV unplugged; LF_E_IO a file could not be written. May block:
     * called only at the end and by tests. */
    lf_status (*flush)(lf_device *device, int timeout_ms);
} lf_device_ops;

#define LF_DEVICE_MAX_RECTS 4096

/* First field of every device. */
struct lf_device {
    const lf_device_ops *ops;
};

/* Opens the first panel found that says that it is one and can be opened. first: the spec of the
 * one to begin with, empty = any; what is there now under that name must be a panel like all
 * others. On failure *out_device is untouched, and err says why:
 *   LF_E_NODEV   no panel is there, or none whose calibration is known: worth trying again when
 *                something is plugged in
 *   LF_E_BUSY    another program has it
 *   LF_E_IO      there is one that cannot be used for now: it does not answer, its calibration
 *                cannot be read, no permission */
LF_NODISCARD lf_status lf_device_find(const char *first, const lf_calibration *calibration,
                                      lf_device **out_device, lf_error *err);
/* A "none" whose info.problem says `problem`. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_none_create(const char *problem, lf_device **out_device, lf_error *err);
/* Opens by spec "KIND[:ARGUMENT]" (at most 511 bytes). "auto" = what lf_device_find finds, else
 * "none" with info.problem saying why there is nothing. Errors as lf_device_ops.open; LF_E_ARG for
 * an unknown kind. On LF_OK the caller owns *out_device.
 *   none                        takes and counts everything, shows nothing, has no calibration
 *   drm[:OUTPUT]                a display output without a desktop: device/drm/drm.c
 *   window[:MONITOR]            a monitor of a desktop: device/window/window.c
 *   usb[:BUS-PORT]              a display with an open protocol over USB: device/usb/usb.c; where
 *                               the kernel's driver shows on it, a drm device is what comes out
 *   sim:DIR[,OPTION=VALUE…]     files in DIR: device/sim/sim.c */
LF_NODISCARD lf_status lf_device_open(const char *spec, const lf_calibration *calibration,
                                      lf_device **out_device, lf_error *err);
/* Accepts NULL. */
void lf_device_destroy(lf_device *device);

/* What a spec says before anything is opened. Any thread; only lf_device_same looks at files. */

/* Whether it leaves the choice to lf_device_find: "auto". */
bool lf_device_is_auto(const char *spec);
/* "auto", then the kinds of the table; NULL after the last. */
const char *lf_device_kind_at(int index);
/* Whether it names a device of that kind. */
bool lf_device_has_kind(const char *spec, const char *kind);
/* lf_device_ops.is_panel of its kind; true for "auto" and for kinds that there are none of. */
bool lf_device_is_panel(const char *spec);
/* lf_device_ops.is_hardware of its kind; true for "auto" and for kinds that there are none of. */
bool lf_device_is_hardware(const char *spec);
/* Whether spec may name the device that `open`, the spec of an open one, names. */
bool lf_device_same(const char *open, const char *spec);
/* Where in spec the folder begins that such a device writes into, and its length; NULL = it writes
 * nowhere. */
const char *lf_device_folder(const char *spec, size_t *out_length);
/* The spec (lf_free) of the same device with `folder`, a canonical name that was found to be
 * allowed, in the place of its own: no link is followed when it is opened, so that what is swapped
 * for one meanwhile leads nowhere. spec names a folder. NULL = out of memory. */
char *lf_device_allowed_spec(const char *spec, const char *folder);

/* Devices that could be opened now, panels first, "none" last; returns how many were written (at
 * most max). */
int lf_device_list(lf_device_info *out, int max);

#endif
