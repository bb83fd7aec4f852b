/* Timers that are due when a test says so: for programs of one thread that are linked with
 * --wrap=sd_event_add_time_relative,--wrap=sd_event_source_set_time_relative. */
#ifndef LF_TESTS_WEB_CLOCK_H
#define LF_TESTS_WEB_CLOCK_H

#include "tests/testing.h"

#include <systemd/sd-event.h>

enum { MAX_TIMERS = 16384 };
#define NEVER_USEC ((uint64_t)3600000000)

static struct timer {
    sd_event_source *source;
    uint64_t due_usec; /* by the test's clock */
} timers[MAX_TIMERS];
static int n_timers;
static uint64_t now_usec;

int __real_sd_event_add_time_relative(sd_event *event, sd_event_source **source, clockid_t clock,
                                      uint64_t usec, uint64_t accuracy,
                                      sd_event_time_handler_t callback, void *context);
int __wrap_sd_event_add_time_relative(sd_event *event, sd_event_source **source, clockid_t clock,
                                      uint64_t usec, uint64_t accuracy,
                                      sd_event_time_handler_t callback, void *context);
int __wrap_sd_event_add_time_relative(sd_event *event, sd_event_source **source, clockid_t clock,
                                      uint64_t usec, uint64_t accuracy,
                                      sd_event_time_handler_t callback, void *context)
{
    const int result = __real_sd_event_add_time_relative(
        event, source, clock, usec > 0 ? NEVER_USEC : 0, accuracy, callback, context);
    assert_true(n_timers < MAX_TIMERS);
    if (result >= 0)
        timers[n_timers++] = (struct timer){sd_event_source_ref(*source), now_usec + usec};
    return result;
}

int __real_sd_event_source_set_time_relative(sd_event_source *source, uint64_t usec);
int __wrap_sd_event_source_set_time_relative(sd_event_source *source, uint64_t usec);
int __wrap_sd_event_source_set_time_relative(sd_event_source *source, uint64_t usec)
{
    for (int i = 0; i < n_timers; i++)
        if (timers[i].source == source)
            timers[i].due_usec = now_usec + usec;
    return __real_sd_event_source_set_time_relative(source, usec > 0 ? NEVER_USEC : 0);
}

/* Runs until nothing happens any more. */
static inline void lf_clock_settle(sd_event *event)
{
    for (int quiet = 0; quiet < 3;)
        quiet = sd_event_run(event, 2000) > 0 ? 0 : quiet + 1;
}

/* So much time passes at once. */
static inline void lf_clock_pass(sd_event *event, double seconds)
{
    lf_clock_settle(event);
    now_usec += (uint64_t)(seconds * 1e6);
    for (int i = 0; i < n_timers; i++) {
        if (timers[i].due_usec > now_usec)
            continue;
        timers[i].due_usec = UINT64_MAX;
        __real_sd_event_source_set_time_relative(timers[i].source, 0);
    }
    lf_clock_settle(event);
}

static inline void lf_clock_finish(void)
{
    while (n_timers > 0)
        sd_event_source_unref(timers[--n_timers].source);
}

#endif
