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

/* A command that reads a command line of its own, by lf_options_read. argv[0] is its name. */
typedef struct lf_completion_command {
    const char *name; /* the operand; NULL: what the program does without one */
    int (*run)(int argc, char **argv);
} lf_completion_command;

/* The same of a program whose first operand is a command: all commands and, behind any of them, the
 * options of all. They are run without arguments, and end where they would read them. */
LF_NODISCARD lf_status lf_completion_write_commands(const char *program,
                                                    const lf_completion_command *commands, int n,
                                                    const char *shell, FILE *out, lf_error *err);
/* For lf_options_read: whether the rules were only asked for. */
bool lf_completion_takes_rules(const lf_options_rules *rules);

#endif
