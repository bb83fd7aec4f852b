/* The clock and the timers of a test, by wrapped functions (wrap_test_* in tests/module.mk): time
 * stands still until the test moves it, and timers are due at once and tell how long they are. */
#ifndef LF_TESTS_DAEMON_OWN_CLOCK_H
#define LF_TESTS_DAEMON_OWN_CLOCK_H

#include <systemd/sd-event.h>

#include "base/thread.h"

static double clock_now, woken_in; /* seconds; woken_in below 0: no timer was set */

double __wrap_lf_time_now(void);
double __wrap_lf_time_now(void)
{
    return clock_now;
}

int __real_sd_event_source_set_time_relative(sd_event_source *source, uint64_t usec);
int __wrap_sd_event_source_set_time_relative(sd_event_source *source, uint64_t usec);
int __wrap_sd_event_source_set_time_relative(sd_event_source *source, uint64_t usec)
{
    woken_in = (double)usec * 1e-6;
    return __real_sd_event_source_set_time_relative(source, 0);
}

#endif
