/* play: plays frames of a scene in real time, with at most one load in progress. It depends on
 * neither scene nor server: its owner loads the frames it requests and reports the outcome. Thread:
 * event. */
#ifndef LF_DAEMON_PLAY_H
#define LF_DAEMON_PLAY_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

typedef struct lf_play lf_play;

/* What is played. */
typedef struct lf_play_range {
    double rate; /* frames per second */
    int from, to;
    bool once; /* stop after the last frame; otherwise loop */
} lf_play_range;

typedef struct lf_play_events {
    /* Load this frame. Call lf_play_loaded when the load has ended, but not from within. False: it
     * cannot be loaded, which ends the playback. */
    bool (*due)(void *context, int frame);
} lf_play_events;

/* events is copied, event borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_play_create(sd_event *event, const lf_play_events *events, void *context,
                                      lf_play **out_play);
/* Accepts NULL. */
void lf_play_destroy(lf_play *play);
/* Starts playback. The first frame is due at once. The next one is the frame due by the clock, once
 * the current frame is shown coarse or has taken long. */
void lf_play_begin(lf_play *play, const lf_play_range *range);
void lf_play_stop(lf_play *play);
/* Outcome of the requested frame: its generation. err not NULL: the load failed; playback ends with
 * a line in the log, without one for LF_E_CANCELLED. */
void lf_play_loaded(lf_play *play, int64_t generation, const lf_error *err);
/* The panel shows this generation at this level. */
void lf_play_shown(lf_play *play, int64_t generation, lf_level level);
/* The played file was read again, so its frames have changed. */
void lf_play_again(lf_play *play);
/* The current playback; NULL: none. */
const lf_play_range *lf_play_now(const lf_play *play);

#endif
