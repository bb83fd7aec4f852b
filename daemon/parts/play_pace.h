/* One load at a time, and whether its image is shown: what play and play_list share. Private to
 * them. Thread: event. */
#ifndef LF_DAEMON_PLAY_PACE_H
#define LF_DAEMON_PLAY_PACE_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

typedef struct lf_pace {
    sd_event_source *timer;
    bool on_its_way;    /* a load is in progress; afterwards … */
    int64_t generation; /* … its generation … */
    double loaded;      /* … and when it was loaded (lf_time_now) */
    /* on the panel */
    int64_t shown;
    lf_level level;
} lf_pace;

/* The timer rests, and calls on_time with the context. LF_E_NOMEM: zeroed. */
LF_NODISCARD lf_status lf_pace_init(lf_pace *pace, sd_event *event, sd_event_time_handler_t on_time,
                                    void *context);
/* Accepts a zeroed pace. */
void lf_pace_finish(lf_pace *pace);
/* Sets the timer to a time of lf_time_now. */
void lf_pace_wake_at(const lf_pace *pace, double time);
/* Ends a timer that was set. */
void lf_pace_rest(const lf_pace *pace);
/* The load has ended, with this generation. */
void lf_pace_loaded(lf_pace *pace, int64_t generation);
void lf_pace_shown(lf_pace *pace, int64_t generation, lf_level level);
/* True if the image of the last load, or a later one, is shown and at least coarse. */
bool lf_pace_is_shown(const lf_pace *pace);

#endif
