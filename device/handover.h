/* Passes pushes from the event thread to a device's own thread, and their results back. Shared by
 * devices that show a whole picture from memory (drm, usb, window). Such a device begins with an
 * lf_handover and uses the event thread's functions below directly in its table. The picture and
 * its rectangles belong to the event thread until a push, then to the device's thread until it
 * reports the end of the push; nothing is queued. Private to device/. */
#ifndef LF_DEVICE_HANDOVER_H
#define LF_DEVICE_HANDOVER_H

#include <pthread.h>

#include "device/device.h"

typedef struct lf_handover {
    lf_device base; /* set by the device, before init */
    /* polls readable for the device's thread when lf_handover_take has news */
    int wake_fd;
    int tell_fd; /* lf_device_ops.poll_fd */
    bool made, has_lock, has_ended, has_thread;
    pthread_t thread;

    /* owned by the thread whose turn it is */
    lf_image8 picture; /* what the panel shows or is to show: 3 channels */
    int n_rects;       /* number of changed rectangles */
    lf_rect *rects;    /* [LF_DEVICE_MAX_RECTS] */

    pthread_mutex_t lock;
    pthread_cond_t ended;
    /* under lock */
    bool pushed; /* a push waits for the device's thread */
    bool busy;   /* a push waits or is in progress */
    bool retry;  /* a failed push is to be reported */
    bool gone, stop;
    lf_device_counters counters;
    char problem[256];
} lf_handover;

/* ------------------------------------------------------------------------ the event thread's -- */

/* Creates a zeroed picture of this size, and no thread yet. Takes as long as writing the picture.
 * After a failure call finish. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_handover_init(lf_handover *h, int width, int height, lf_error *err);
/* Starts the device's thread (lf_thread_start). LF_E_NOMEM. */
LF_NODISCARD lf_status lf_handover_start(lf_handover *h, void *(*main)(void *), void *context,
                                         const char *name, lf_error *err);
/* Waits for a push in progress (at most 1 s) and asks the thread made by start to end. */
void lf_handover_ask_stop(lf_handover *h);
/* If there is a thread, asks it to end and joins it. For threads that end by themselves whatever
 * their device does. */
void lf_handover_stop(lf_handover *h);
/* To be called without a running thread. Accepts zeroed and half-made handovers. */
void lf_handover_finish(lf_handover *h);

/* Members of lf_device_ops with the same names. push copies the rectangles: 1 ms for a whole
 * Portrait, 8 ms for 7680x4320. */
LF_NODISCARD lf_status lf_handover_push(lf_device *device, const lf_image8 *frame,
                                        const lf_rect *rects, int n, uint64_t generation);
int lf_handover_poll_fd(const lf_device *device);
lf_device_event lf_handover_dispatch(lf_device *device);
void lf_handover_counters(const lf_device *device, lf_device_counters *out);
LF_NODISCARD lf_status lf_handover_flush(lf_device *device, int timeout_ms);
/* The last text set by lf_handover_problem_set. */
void lf_handover_problem(const lf_handover *h, char out[256]);

/* ----------------------------------------------------------------------- the device thread's -- */

typedef enum lf_handover_word {
    LF_HANDOVER_NOTHING,
    LF_HANDOVER_PUSH, /* picture and rects belong to this thread until lf_handover_end */
    LF_HANDOVER_STOP, /* returned until the thread ends */
} lf_handover_word;

/* The next task; clears wake_fd. */
lf_handover_word lf_handover_take(lf_handover *h);
/* The push has ended. shown: it was successful and took `bytes` on the wire. */
void lf_handover_end(lf_handover *h, bool shown, uint64_t bytes);
/* The shown contents were lost without a push. Requests the whole picture from the caller; false:
 * not requested, because a push is waiting or in progress. */
bool lf_handover_lost(lf_handover *h);
/* The device was unplugged: there are no more pushes. */
void lf_handover_gone(lf_handover *h);
/* Sets the device's problem, "" = none; sanitised. */
void lf_handover_problem_set(lf_handover *h, const char *text);

#endif
