/* completion: what shells complete on the command line of a program, written from its tables (never
 * by hand, so that it cannot lack an option). Thread: any. */
#ifndef LF_DAEMON_COMPLETION_H
#define LF_DAEMON_COMPLETION_H

#include <stdio.h>

#include "daemon/output/options.h"

/* Writes the completion of rules->program for "bash", "zsh" or "fish": every option of its parts
 * and of its own table, their words where they have some and files where they may be one, the first
 * operand and what may follow it. LF_E_ARG: another shell. Errors of out are the caller's. */
LF_NODISCARD lf_status lf_completion_write(const lf_options_rules *rules, const char *shell,
                                           FILE *out, lf_error *err);

#endif
