/* quiltrender --read-chart: pitch, phase and skew of a lens sheet from a photo of a chart. */
#ifndef LF_DAEMON_READ_CHART_H
#define LF_DAEMON_READ_CHART_H

#include "daemon/tools/render_arguments.h"

/* Reads a->of_print.photo, prints the result, and writes it to a->out if that is not NULL. Returns
 * the exit status; errors have been logged. Thread: the main thread. */
int lf_read_chart(const lf_render_arguments *a);

#endif
