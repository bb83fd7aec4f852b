#include "daemon/media/movie_clock.h"

#include "base/thread.h"

void lf_movie_clock_start(lf_movie_clock *clock, int rate, int per, uint64_t now)
{
    *clock = (lf_movie_clock){.rate = rate, .per = per, .t0 = now, .shown = now};
}

/* In whole seconds and a rest, so that nothing overflows and no error adds up. */
static uint64_t offset_of(const lf_movie_clock *clock, int64_t frame)
{
    const uint64_t rate = (uint64_t)clock->rate, per = (uint64_t)clock->per, k = (uint64_t)frame,
                   turns = k / rate, rest = k % rate;
    return turns * per * LF_NS_PER_S +
           (uint64_t)((double)rest * (double)per / (double)rate * (double)LF_NS_PER_S);
}

uint64_t lf_movie_clock_due(const lf_movie_clock *clock, int64_t frame)
{
    return clock->t0 + offset_of(clock, frame);
}

lf_clock_verdict lf_movie_clock_judge(lf_movie_clock *clock, int64_t frame, uint64_t now,
                                      bool *out_moved)
{
    const uint64_t due = lf_movie_clock_due(clock, frame);
    if (out_moved)
        *out_moved = false;
    if (clock->paused > 0 || now < due)
        return LF_CLOCK_WAIT;
    const uint64_t period = lf_movie_clock_due(clock, frame + 1) - due;
    if (frame > 0 && now >= due + period && now - clock->shown < period)
        return LF_CLOCK_DROP;
    if (now - due > LF_CLOCK_MOST_LAG_NS && now - due > period) {
        clock->t0 += now - due;
        if (out_moved)
            *out_moved = true;
    }
    clock->shown = now;
    return LF_CLOCK_SHOW;
}

void lf_movie_clock_resume(lf_movie_clock *clock, int64_t frame, uint64_t now)
{
    const uint64_t due = lf_movie_clock_due(clock, frame),
                   at = clock->paused > 0 ? clock->paused : now;
    if (at > due)
        clock->t0 += at - due;
}

void lf_movie_clock_pause(lf_movie_clock *clock, bool paused, uint64_t now)
{
    if (paused && clock->paused == 0)
        clock->paused = now > 0 ? now : 1;
    if (!paused && clock->paused > 0) {
        clock->t0 += now - clock->paused;
        clock->paused = 0;
    }
}
