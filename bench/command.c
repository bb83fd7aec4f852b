#include "bench/command.h"

#include <string.h>

#include "bench/bench.h"

#define MAX_OPTIONS 32

typedef struct taker {
    const lf_param *own;
    void *arguments;
} taker;

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    const taker *to = context;
    return lf_param_from_text(&to->own[code - LF_OPTION_OWN], text, to->arguments, err);
}

static lf_status read_line(const lf_bench_command *command, int argc, char **argv,
                           lf_options *shared, void *arguments, bool *out_done, lf_error *err)
{
    struct option table[MAX_OPTIONS + 1];
    taker to = {command->own, arguments};
    const lf_options_rules rules = {LF_BENCH_PROGRAM, ":",  table, command->print_help,
                                    shared,           take, &to};
    int n = 0;
    for (; command->shared[n].name; n++)
        table[n] = command->shared[n];
    lf_options_append(table, n, MAX_OPTIONS, command->own, LF_OPTION_OWN);
    lf_param_defaults(command->own, arguments);
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (argc - optind < command->least || argc - optind > command->most)
        return lf_error_set(err, LF_E_ARG, command->name, "expects %s (see quiltbench %s --help)",
                            command->operands, command->name);
    return LF_OK;
}

bool lf_bench_command_begin(const lf_bench_command *command, int argc, char **argv,
                            lf_options *shared, void *arguments, int *out_code)
{
    lf_error err = {0};
    bool done = false;
    lf_status status = read_line(command, argc, argv, shared, arguments, &done, &err);
    *out_code = status == LF_OK ? LF_EXIT_OK : lf_usage_error(LF_BENCH_PROGRAM, &err);
    return status == LF_OK && !done;
}
