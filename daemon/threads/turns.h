/* turns: the event loop, and how much of its thread's time its turns take. A turn is what one
 * source of events has done at a time. */
#ifndef LF_DAEMON_TURNS_H
#define LF_DAEMON_TURNS_H

#include <systemd/sd-event.h>

/* Runs the loop until it is told to exit; returns what sd_event_loop does. *longest (borrowed; to
 * be read by the same thread) becomes the CPU time of the longest turn so far, in seconds: what
 * other threads and processes take meanwhile does not count. */
int lf_turns_run(sd_event *event, double *longest);

#endif
