/* ctl_help: help on the daemon's methods, from their schemas. Writes to stdout. */
#ifndef LF_DAEMON_CTL_HELP_H
#define LF_DAEMON_CTL_HELP_H

#include <jansson.h>

/* Prints a method's purpose, parameters with values, units, ranges and defaults, result and
 * example. entry: from `hello`. */
void lf_ctl_print_method(const char *name, const json_t *entry);
/* Prints all of `hello`: one line per method, parameter and notification. */
void lf_ctl_print_methods(const json_t *hello);

#endif
