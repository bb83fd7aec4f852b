/* The command line of one command of quiltbench: options that it shares with the other programs,
 * its own as a table of its arguments' fields, and operands. */
#ifndef LF_BENCH_COMMAND_H
#define LF_BENCH_COMMAND_H

#include "base/param.h"
#include "bench/timing.h"
#include "daemon/output/options.h"

typedef struct lf_bench_command {
    const char *name;
    const char *shared;  /* which of lf_option_params */
    const lf_param *own; /* of the struct that is filled, every row with a name */
    void (*print_help)(void);
    int least, most;      /* operands */
    const char *operands; /* what it expects of them: "one SCENE" */
} lf_bench_command;

/* Rows of tables. field: offsetof in the struct, of an int for LF_PARAM_WHOLE, a double for
 * LF_PARAM_NUMBER. */
#define LF_BENCH_FIELD(kind, word, field, unit, least, most, usual, what)                          \
    {                                                                                              \
        .name = word, .option = word, .argument = unit, .help = what, .type = kind,                \
        .place = field, .low = least, .high = most, .initial = usual                               \
    }
/* Those of most commands, for the fields `int repeat` and `const char *json`. */
#define LF_BENCH_REPEAT(field, times, what)                                                        \
    LF_BENCH_FIELD(LF_PARAM_WHOLE, "repeat", field, "N", 1, LF_TIMING_MAX, times, what)
#define LF_BENCH_JSON(field)                                                                       \
    LF_BENCH_FIELD(LF_PARAM_TEXT, "json", field, "FILE", 0, 0, 0,                                  \
                   "write the numbers as JSON (-: standard output)")

/* Sets *arguments to the initial values of its table, then takes all options; argv[optind] is the
 * first operand then. false: *out_code is what to end with, after help was asked for and printed,
 * or what is wrong was told. */
bool lf_bench_command_begin(const lf_bench_command *command, int argc, char **argv,
                            lf_options *shared, void *arguments, int *out_code);

#endif
