/* prometheus: what a daemon answers to `status`, as the lines that Prometheus reads (text format
 * 0.0.4), for the textfile collector of its node exporter. Thread: any. */
#ifndef LF_DAEMON_PROMETHEUS_H
#define LF_DAEMON_PROMETHEUS_H

#include <jansson.h>
#include <stdio.h>

/* Writes HELP, TYPE and the samples of every quantity that is known: what is null in the status, or
 * not in it (a daemon of another version), is left out. status NULL: no daemon answers, quiltd_up
 * is 0 and nothing else is said. Errors of out are left for the caller to look at (ferror). */
void lf_prometheus_write(const json_t *status, FILE *out);

#endif
