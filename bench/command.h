/* The command line of a command of quiltbench: options shared with the other programs, its own
 * options as a table, and operands. */
#ifndef LF_BENCH_COMMAND_H
#define LF_BENCH_COMMAND_H

#include "base/param.h"
#include "bench/timing.h"
#include "daemon/output/options.h"

typedef struct lf_bench_command {
    const char *name;
    const char *shared;  /* names of options from lf_option_params */
    const lf_param *own; /* table of its own options; every row has a name */
    void (*print_help)(void);
    int least, most;      /* number of operands */
    const char *operands; /* the expected operands: "one SCENE" */
} lf_bench_command;

/* Rows of tables. field: offsetof an int for LF_PARAM_WHOLE, a double for LF_PARAM_NUMBER. */
#define LF_BENCH_FIELD(kind, word, field, unit, least, most, usual, what)                          \
    {                                                                                              \
        .name = word, .option = word, .argument = unit, .help = what, .type = kind,                \
        .place = field, .low = least, .high = most, .initial = usual                               \
    }
/* Rows of most commands, for the fields `int repeat` and `const char *json`. */
#define LF_BENCH_REPEAT(field, times, what)                                                        \
    LF_BENCH_FIELD(LF_PARAM_WHOLE, "repeat", field, "N", 1, LF_TIMING_MAX, times, what)
#define LF_BENCH_JSON(field)                                                                       \
    LF_BENCH_FIELD(LF_PARAM_TEXT, "json", field, "FILE", 0, 0, 0,                                  \
                   "write the numbers as JSON (-: standard output)")

/* Sets *arguments to the defaults of its table, then reads all options; argv[optind] is then the
 * first operand. False: end with *out_code; help or an error has been printed. */
bool lf_bench_command_begin(const lf_bench_command *command, int argc, char **argv,
                            lf_options *shared, void *arguments, int *out_code);

#endif
