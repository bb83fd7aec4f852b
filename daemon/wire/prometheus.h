/* prometheus: converts a daemon's `status` to Prometheus text format 0.0.4, for the textfile
 * collector of the node exporter. Thread: any. */
#ifndef LF_DAEMON_PROMETHEUS_H
#define LF_DAEMON_PROMETHEUS_H

#include <jansson.h>
#include <stdio.h>

/* Writes HELP, TYPE and samples of every known quantity. Omits quantities that are null or missing
 * in the status, for example from another version of the daemon. status NULL: no daemon answers;
 * writes only quiltd_up 0. The caller checks errors of out (ferror). */
void lf_prometheus_write(const json_t *status, FILE *out);

#endif
