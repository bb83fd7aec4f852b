#include "daemon/media/pace.h"

#include "base/thread.h"

void lf_pace_start(lf_pace *pace, int rate, int per, uint64_t now)
{
    *pace = (lf_pace){.rate = rate, .per = per, .t0 = now, .shown = now};
}

/* In whole seconds and a rest, so that nothing overflows and no error adds up. */
static uint64_t offset_of(const lf_pace *pace, int64_t frame)
{
    const uint64_t rate = (uint64_t)pace->rate, per = (uint64_t)pace->per, k = (uint64_t)frame,
                   turns = k / rate, rest = k % rate;
    return turns * per * LF_NS_PER_S +
           (uint64_t)((double)rest * (double)per / (double)rate * (double)LF_NS_PER_S);
}

uint64_t lf_pace_due(const lf_pace *pace, int64_t frame)
{
    return pace->t0 + offset_of(pace, frame);
}

lf_pace_verdict lf_pace_judge(lf_pace *pace, int64_t frame, uint64_t now, bool *out_moved)
{
    const uint64_t due = lf_pace_due(pace, frame);
    if (out_moved)
        *out_moved = false;
    if (pace->paused > 0 || now < due)
        return LF_PACE_WAIT;
    const uint64_t period = lf_pace_due(pace, frame + 1) - due;
    if (frame > 0 && now >= due + period && now - pace->shown < period)
        return LF_PACE_DROP;
    if (now - due > LF_PACE_MOST_LAG_NS && now - due > period) {
        pace->t0 += now - due;
        if (out_moved)
            *out_moved = true;
    }
    pace->shown = now;
    return LF_PACE_SHOW;
}

void lf_pace_pause(lf_pace *pace, bool paused, uint64_t now)
{
    if (paused && pace->paused == 0)
        pace->paused = now > 0 ? now : 1;
    if (!paused && pace->paused > 0) {
        pace->t0 += now - pace->paused;
        pace->paused = 0;
    }
}
