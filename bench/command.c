#include "bench/command.h"

#include "bench/bench.h"

static lf_status read_line(const lf_bench_command *command, int argc, char **argv,
                           lf_options *shared, void *arguments, bool *out_done, lf_error *err)
{
    const lf_options_part parts[] = {
        {lf_option_params, command->shared, shared}, {command->own, NULL, arguments}, {0}};
    const lf_options_rules rules = {.program = LF_BENCH_PROGRAM,
                                    .letters = ":",
                                    .parts = parts,
                                    .print_help = command->print_help};
    lf_param_defaults(command->own, arguments);
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (argc - optind < command->least || argc - optind > command->most)
        return lf_error_set(err, LF_E_ARG, command->name, "expects %s; see quiltbench %s --help",
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
