/* play: frames of a scene one after the other, at the clock's pace, and never more than one on its
 * way. It knows neither the scene nor the server: whoever made it loads the frames that it asks
 * for, and tells what became of them. Everything is the event thread's. */
#ifndef LF_DAEMON_PLAY_H
#define LF_DAEMON_PLAY_H

#include <systemd/sd-event.h>

#include "daemon/engine/mailbox.h"

typedef struct lf_play lf_play;

/* What is played. */
typedef struct lf_play_range {
    double rate; /* frames a second */
    int from, to;
    bool once; /* and then stops; else from the beginning again */
} lf_play_range;

typedef struct lf_play_events {
    /* This frame is to be loaded; lf_play_loaded is called when that has ended, and not from
     * within. false: it cannot be, which ends the playing. */
    bool (*due)(void *context, int frame);
} lf_play_events;

/* events is copied, event borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_play_create(sd_event *event, const lf_play_events *events, void *context,
                                      lf_play **out_play);
/* Accepts NULL. */
void lf_play_destroy(lf_play *play);
/* Plays from now on: the first frame at once, then whichever is due by the clock when the one
 * before is shown coarse, or has taken long. */
void lf_play_begin(lf_play *play, const lf_play_range *range);
void lf_play_stop(lf_play *play);
/* The frame that was due is this generation; err not NULL: it could not be loaded, which ends the
 * playing with a line in the log (LF_E_CANCELLED: without). */
void lf_play_loaded(lf_play *play, int64_t generation, const lf_error *err);
/* The panel shows this generation at that level. */
void lf_play_shown(lf_play *play, int64_t generation, lf_level level);
/* The file that is played was read again: its frames are others. */
void lf_play_again(lf_play *play);
/* What is played; NULL: nothing is. */
const lf_play_range *lf_play_now(const lf_play *play);

#endif
