/* movie_clock: when the frames of a video are due, and which are late. Pure; times are
 * lf_time_now_ns.
 *
 * Frame k is due at t0 + k / fps. Thread: one at a time. */
#ifndef LF_DAEMON_MOVIE_CLOCK_H
#define LF_DAEMON_MOVIE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

/* A lag beyond this moves t0: the clock waits for a decoder that is too slow. */
#define LF_CLOCK_MOST_LAG_NS UINT64_C(500000000)

typedef struct lf_movie_clock {
    int rate, per;   /* frames per second: rate / per */
    uint64_t t0;     /* time of frame 0 */
    uint64_t shown;  /* time at which the last frame was shown */
    uint64_t paused; /* time at which it was paused; 0: it runs */
} lf_movie_clock;

typedef enum lf_clock_verdict {
    LF_CLOCK_WAIT, /* until lf_movie_clock_due */
    LF_CLOCK_SHOW, /* now */
    LF_CLOCK_DROP  /* it is late, and the frame before was shown less than 1 / fps ago */
} lf_clock_verdict;

/* Frame 0 is due now. */
void lf_movie_clock_start(lf_movie_clock *clock, int rate, int per, uint64_t now);
uint64_t lf_movie_clock_due(const lf_movie_clock *clock, int64_t frame);
/* Judges a frame that has arrived; its time may already be over. A verdict other than WAIT counts
 * as carried out. *out_moved (may be NULL): the clock has waited. */
lf_clock_verdict lf_movie_clock_judge(lf_movie_clock *clock, int64_t frame, uint64_t now,
                                      bool *out_moved);
/* Makes a frame due now if its time is already over: frames from it on are as late as it is. */
void lf_movie_clock_resume(lf_movie_clock *clock, int64_t frame, uint64_t now);
/* Stops the clock, or lets it go on. While it is stopped no frame is due. */
void lf_movie_clock_pause(lf_movie_clock *clock, bool paused, uint64_t now);

#endif
