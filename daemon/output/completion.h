/* completion: shell completion scripts, generated from a program's option tables so that no option
 * is missing. Thread: any. */
#ifndef LF_DAEMON_COMPLETION_H
#define LF_DAEMON_COMPLETION_H

#include <stdio.h>

#include "daemon/output/options.h"

/* Writes the completion of rules->program for "bash", "zsh" or "fish". It covers the options of all
 * parts and of the program's own table, with their words or files; the first operand; and its
 * followers. LF_E_ARG: another shell. The caller checks errors of out. */
LF_NODISCARD lf_status lf_completion_write(const lf_options_rules *rules, const char *shell,
                                           FILE *out, lf_error *err);

/* A command that reads its command line with lf_options_read. argv[0] is its name. */
typedef struct lf_completion_command {
    const char *name; /* the operand; NULL: the program without one */
    int (*run)(int argc, char **argv);
} lf_completion_command;

/* Like lf_completion_write, for a program whose first operand is a command. Completes the commands
 * and, after any command, the options of all commands. Runs each command without arguments; it ends
 * where it would read them. */
LF_NODISCARD lf_status lf_completion_write_commands(const char *program,
                                                    const lf_completion_command *commands, int n,
                                                    const char *shell, FILE *out, lf_error *err);
/* For lf_options_read: true if only the rules were wanted. */
bool lf_completion_takes_rules(const lf_options_rules *rules);

#endif
