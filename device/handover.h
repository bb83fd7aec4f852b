/* How a push gets from the event thread to a thread of the device's own, and its end back: what
 * devices that show a whole picture from memory share (drm, usb, window). Such a device begins with
 * an lf_handover and takes what stands here for the event thread into its table as it is. The
 * picture and its rectangles belong to the event thread until a push, then to the device's thread
 * until it says how the push ended; nothing is queued. Private to device/. */
#ifndef LF_DEVICE_HANDOVER_H
#define LF_DEVICE_HANDOVER_H

#include <pthread.h>

#include "device/device.h"

typedef struct lf_handover {
    lf_device base; /* set by the device, before init */
    /* polls readable for the device's thread: lf_handover_take has something to tell */
    int wake_fd;
    int tell_fd; /* lf_device_ops.poll_fd */
    bool made, has_lock, has_ended, has_thread;
    pthread_t thread;

    /* of whoever's turn it is */
    lf_image8 picture; /* what the panel shows, or shall show: 3 channels */
    int n_rects;       /* what of it is new */
    lf_rect *rects;    /* [LF_DEVICE_MAX_RECTS] */

    pthread_mutex_t lock;
    pthread_cond_t ended;
    /* under lock */
    bool pushed; /* a push waits for the device's thread */
    bool busy;   /* a push waits or is under way */
    bool retry;  /* a failed push is to be told */
    bool gone, stop;
    lf_device_counters counters;
    char problem[256];
} lf_handover;

/* ------------------------------------------------------------------------ the event thread's -- */

/* Zeroed picture of this size, no thread yet; takes as long as writing it does. On failure finish
 * takes what is there. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_handover_init(lf_handover *h, int width, int height, lf_error *err);
/* Starts the device's thread (lf_thread_start). LF_E_NOMEM. */
LF_NODISCARD lf_status lf_handover_start(lf_handover *h, void *(*main)(void *), void *context,
                                         const char *name, lf_error *err);
/* Waits for a push under way (at most 1 s) and asks the thread, which start has made, to end. */
void lf_handover_ask_stop(lf_handover *h);
/* The same where there is a thread, and joins it: for threads that end by themselves, whatever
 * their device does. */
void lf_handover_stop(lf_handover *h);
/* When there is no thread (any more). Accepts zeroed and half-made ones. */
void lf_handover_finish(lf_handover *h);

/* The members of lf_device_ops of the same names. Pushing copies the rectangles: what memory takes
 * (1 ms for a whole Portrait, 8 ms for 7680x4320). */
LF_NODISCARD lf_status lf_handover_push(lf_device *device, const lf_image8 *frame,
                                        const lf_rect *rects, int n, uint64_t generation);
int lf_handover_poll_fd(const lf_device *device);
lf_device_event lf_handover_dispatch(lf_device *device);
void lf_handover_counters(const lf_device *device, lf_device_counters *out);
LF_NODISCARD lf_status lf_handover_flush(lf_device *device, int timeout_ms);
/* The last word of lf_handover_problem_set. */
void lf_handover_problem(const lf_handover *h, char out[256]);

/* ----------------------------------------------------------------------- the device thread's -- */

typedef enum lf_handover_word {
    LF_HANDOVER_NOTHING,
    LF_HANDOVER_PUSH, /* picture and rects are this thread's now, until lf_handover_end */
    LF_HANDOVER_STOP, /* told until the thread ends */
} lf_handover_word;

/* What there is to do; empties wake_fd. */
lf_handover_word lf_handover_take(lf_handover *h);
/* The push has ended: shown (bytes were written for it), or not. */
void lf_handover_end(lf_handover *h, bool shown, uint64_t bytes);
/* What was shown is lost, without a push: unless one is waiting or under way (false) the caller is
 * asked for the whole picture. */
bool lf_handover_lost(lf_handover *h);
/* The device was unplugged: nothing is pushed any more. */
void lf_handover_gone(lf_handover *h);
/* What is wrong with the device, "" = nothing; sanitised. */
void lf_handover_problem_set(lf_handover *h, const char *text);

#endif
