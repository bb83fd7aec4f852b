/* ctl_help: the daemon's methods as people read them, from their schemas. Writes to stdout. */
#ifndef LF_DAEMON_CTL_HELP_H
#define LF_DAEMON_CTL_HELP_H

#include <jansson.h>

/* What a method is for, its parameters with their words, units, ranges and defaults, its answer and
 * an example. entry: as hello has it. */
void lf_ctl_print_method(const char *name, const json_t *entry);
/* All of hello: a line for each method and parameter, and for each notification. */
void lf_ctl_print_methods(const json_t *hello);

#endif
