/* turns: the event loop, and the CPU time of its turns. A turn is one sd_event_run. */
#ifndef LF_DAEMON_TURNS_H
#define LF_DAEMON_TURNS_H

#include <systemd/sd-event.h>

/* Runs the loop until it exits; returns the exit code, or the negative error of sd_event_run.
 * *longest (borrowed, read by the same thread) becomes the CPU time of the longest turn so far, in
 * seconds. CPU time of other threads and processes does not count. */
int lf_turns_run(sd_event *event, double *longest);

#endif
