#include "daemon/parts/play_pace.h"

#include <math.h>

#include "base/thread.h"

lf_status lf_pace_init(lf_pace *pace, sd_event *event, sd_event_time_handler_t on_time,
                       void *context)
{
    *pace = (lf_pace){0};
    if (sd_event_add_time_relative(event, &pace->timer, CLOCK_MONOTONIC, 0, 0, on_time, context) <
        0)
        return LF_E_NOMEM;
    lf_pace_rest(pace);
    return LF_OK;
}

void lf_pace_finish(lf_pace *pace)
{
    sd_event_source_disable_unref(pace->timer);
    *pace = (lf_pace){0};
}

void lf_pace_wake_at(const lf_pace *pace, double time)
{
    double seconds = fmax(time - lf_time_now(), 0);
    (void)sd_event_source_set_time_relative(pace->timer, (uint64_t)ceil(seconds * 1e6));
    (void)sd_event_source_set_enabled(pace->timer, SD_EVENT_ONESHOT);
}

void lf_pace_rest(const lf_pace *pace)
{
    (void)sd_event_source_set_enabled(pace->timer, SD_EVENT_OFF);
}

void lf_pace_loaded(lf_pace *pace, int64_t generation)
{
    pace->on_its_way = false;
    pace->generation = generation;
    pace->loaded = lf_time_now();
}

void lf_pace_shown(lf_pace *pace, int64_t generation, lf_level level)
{
    pace->shown = generation;
    pace->level = level;
}

bool lf_pace_is_shown(const lf_pace *pace)
{
    return pace->shown >= pace->generation && pace->level >= LF_LEVEL_COARSE;
}
