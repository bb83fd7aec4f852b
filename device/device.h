/* device: displays that take a panel frame. A device is a member of a table of functions, one file a member; the rest of
 * quiltd knows only this page. Written so that a new member can be made by reading it alone.
 *
 * Threads: every call comes from one thread (the daemon's event thread) and must return within 5 ms: whatever takes longer
 * (encoding, transfers) happens in the device's own thread or asynchronously, announced through the poll descriptor.
 * Unplugging is normal: LF_E_NODEV, after which only destroy may be called. */
#ifndef LF_DEVICE_H
#define LF_DEVICE_H

#include "base/calibration.h"
#include "base/image.h"

typedef struct lf_device lf_device;

/* What a device is, for device.list and status. Strings are sanitised UTF-8. */
typedef struct lf_device_info {
    char spec[512];    /* what --device takes to get this one: "sim:/run/x", "none" */
    char kind[16];     /* member of the table: "sim", "none" */
    char model[64], serial[64];
    char calibration_from[256]; /* where the calibration came from; empty = none */
    char output[64];   /* "file", connector, USB address */
    char problem[256]; /* what is wrong and what to do; empty = nothing */
} lf_device_info;

typedef enum lf_device_event {
    LF_DEVICE_READY,   /* takes the next frame */
    LF_DEVICE_BUSY,    /* the last push is still under way */
    LF_DEVICE_GONE,    /* unplugged */
    LF_DEVICE_RETRY,   /* the last push failed, was not shown, and must be pushed again (whole frame) */
} lf_device_event;

typedef struct lf_device_counters {
    uint64_t updates;      /* rectangles shown */
    uint64_t bytes;        /* bytes on the wire */
    uint64_t errors;       /* failed pushes */
} lf_device_counters;

/* One member of the table. */
typedef struct lf_device_ops {
    /* Word before the colon of a spec. */
    const char *kind;
    /* Opens what `argument` (behind the colon; "" when absent) names. calibration (may be NULL) overrides the device's own. On LF_OK
     * *out_device is owned by the caller. LF_E_NODEV not there; LF_E_BUSY another daemon has it; LF_E_ARG bad option. */
    lf_status (*open)(const char *argument, const lf_calibration *calibration, lf_device **out_device, lf_error *err);
    /* Ends pushes in flight (within 1 s), writes what is owed, frees. Accepts half-built devices; never NULL. */
    void (*destroy)(lf_device *device);
    /* Fills *out; cheap. */
    void (*info)(const lf_device *device, lf_device_info *out);
    /* NULL when the device has none: nothing is interlaced for it. Valid until destroy. */
    const lf_calibration *(*calibration)(const lf_device *device);
    /* Shows rects[n] of frame (the panel's size, 3 channels). The pixels are copied (or sent) before it returns; frame is not kept.
     * Only when the last event was READY. seq rises by one a frame. generation is what the frame shows. */
    lf_status (*push)(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n, uint64_t generation);
    /* Gives the views behind the frame to devices that show them too (the simulated one); NULL = not wanted. Copies, or
     * declines without a word when busy. */
    void (*views)(lf_device *device, const lf_views8 *views, int columns, int rows);
    /* A descriptor that polls readable when the state may have changed; -1 = the state never changes. */
    int (*poll_fd)(const lf_device *device);
    /* Consumes readiness and tells the state. */
    lf_device_event (*dispatch)(lf_device *device);
    void (*counters)(const lf_device *device, lf_device_counters *out);
    /* Waits until everything pushed is on the device (sim: in its files), at most timeout_ms. LF_E_TIMEOUT. May block: called
     * only at the end and by tests. */
    lf_status (*flush)(lf_device *device, int timeout_ms);
} lf_device_ops;

/* First field of every device. */
struct lf_device {
    const lf_device_ops *ops;
};

/* Opens by spec "KIND[:ARGUMENT]"; "auto" = the first panel found, else "none". */
LF_NODISCARD lf_status lf_device_open(const char *spec, const lf_calibration *calibration, lf_device **out_device, lf_error *err);
/* Accepts NULL. */
void lf_device_destroy(lf_device *device);
/* Devices that could be opened now; returns how many were written (at most max). */
int lf_device_list(lf_device_info *out, int max);

#endif
