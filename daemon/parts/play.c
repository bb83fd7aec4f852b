#include "daemon/parts/play.h"

#include <math.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/parts/play_pace.h"

/* A frame that is not coarse after this time is skipped for the next one. */
#define PATIENCE_SECONDS 3.0

/* A time exactly at a frame belongs to that frame, despite rounding. */
#define ROUNDING 1e-6

struct lf_play {
    lf_play_events events;
    void *context;
    lf_pace pace;
    bool on;
    lf_play_range range;
    double begun; /* lf_time_now at the first frame */
    int frame;    /* last frame requested; negative: none */
};

static void ask_for(lf_play *play, int frame)
{
    play->pace.on_its_way = play->events.due(play->context, frame);
    if (play->pace.on_its_way)
        play->frame = frame;
    else
        play->on = false;
}

/* Requests the frame that is due, if the one before was shown. */
static void go_on(lf_play *play)
{
    const lf_play_range *r = &play->range;
    const lf_pace *pace = &play->pace;
    if (!play->on || pace->on_its_way)
        return;
    double now = lf_time_now(), n = r->to - r->from + 1.0,
           k = floor((now - play->begun) * r->rate + ROUNDING);
    if (play->frame >= 0 && !lf_pace_is_shown(pace) && now < pace->loaded + PATIENCE_SECONDS) {
        lf_pace_wake_at(pace, pace->loaded + PATIENCE_SECONDS);
        return;
    }
    int due = r->from + (int)(r->once ? fmin(k, n - 1) : fmod(k, n));
    bool last = r->once && due == r->to;
    if (due != play->frame)
        ask_for(play, due);
    else if (!last)
        lf_pace_wake_at(pace, play->begun + (k + 1) / r->rate);
    play->on = play->on && !last;
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    go_on(context);
    return 0;
}

void lf_play_begin(lf_play *play, const lf_play_range *range)
{
    play->on = true;
    play->range = *range;
    play->begun = lf_time_now();
    play->frame = -1;
    go_on(play);
}

void lf_play_stop(lf_play *play)
{
    play->on = false;
    lf_pace_rest(&play->pace);
}

void lf_play_loaded(lf_play *play, int64_t generation, const lf_error *err)
{
    lf_pace_loaded(&play->pace, generation);
    if (!err) {
        go_on(play);
        return;
    }
    if (err->status != LF_E_CANCELLED)
        lf_log_error(err);
    lf_play_stop(play);
}

void lf_play_shown(lf_play *play, int64_t generation, lf_level level)
{
    lf_pace_shown(&play->pace, generation, level);
    go_on(play);
}

void lf_play_again(lf_play *play)
{
    play->frame = -1;
    go_on(play);
}

const lf_play_range *lf_play_now(const lf_play *play)
{
    return play->on ? &play->range : NULL;
}

lf_status lf_play_create(sd_event *event, const lf_play_events *events, void *context,
                         lf_play **out_play)
{
    lf_play *play = lf_calloc(1, sizeof *play);
    if (!play)
        return LF_E_NOMEM;
    *play = (lf_play){.events = *events, .context = context};
    if (lf_pace_init(&play->pace, event, on_time, play) != LF_OK) {
        lf_play_destroy(play);
        return LF_E_NOMEM;
    }
    *out_play = play;
    return LF_OK;
}

void lf_play_destroy(lf_play *play)
{
    if (play)
        lf_pace_finish(&play->pace);
    lf_free(play);
}
