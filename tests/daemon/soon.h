/* Timers that are due soon, and to the microsecond: for tests that are linked with
 * --wrap=sd_event_add_time_relative. */
#ifndef LF_TESTS_DAEMON_SOON_H
#define LF_TESTS_DAEMON_SOON_H

#include "tests/testing.h"

#include <systemd/sd-event.h>

enum { SOON_USEC = 5000, SOON_WAIT_S = 60 };

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
    (void)usec, (void)accuracy;
    return __real_sd_event_add_time_relative(event, source, clock, SOON_USEC, 1, callback, context);
}

#endif
