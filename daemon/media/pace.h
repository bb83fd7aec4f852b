/* pace: when the frames of a video are due, and which are late. Pure; times are lf_time_now_ns.
 *
 * Frame k is due at t0 + k / fps. Thread: one at a time. */
#ifndef LF_DAEMON_PACE_H
#define LF_DAEMON_PACE_H

#include <stdbool.h>
#include <stdint.h>

/* A lag beyond this moves t0: the clock waits for a decoder that is too slow. */
#define LF_PACE_MOST_LAG_NS UINT64_C(500000000)

typedef struct lf_pace {
    int rate, per;   /* frames per second: rate / per */
    uint64_t t0;     /* time of frame 0 */
    uint64_t shown;  /* time at which the last frame was shown */
    uint64_t paused; /* time at which it was paused; 0: it runs */
} lf_pace;

typedef enum lf_pace_verdict {
    LF_PACE_WAIT, /* until lf_pace_due */
    LF_PACE_SHOW, /* now */
    LF_PACE_DROP  /* it is late, and the frame before was shown less than 1 / fps ago */
} lf_pace_verdict;

/* Frame 0 is due now. */
void lf_pace_start(lf_pace *pace, int rate, int per, uint64_t now);
uint64_t lf_pace_due(const lf_pace *pace, int64_t frame);
/* Judges a frame that has arrived; its time may already be over. A verdict other than WAIT counts
 * as carried out. *out_moved (may be NULL): the clock has waited. */
lf_pace_verdict lf_pace_judge(lf_pace *pace, int64_t frame, uint64_t now, bool *out_moved);
/* Stops the clock, or lets it go on. While it is stopped no frame is due. */
void lf_pace_pause(lf_pace *pace, bool paused, uint64_t now);

#endif
