#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/trial.h"

lf_status lf_contender_parse(const char *option, const char *text, lf_contender *out, lf_error *err)
{
    char name[64];
    lf_options parsed = {0};
    bool taken = false;
    const char *colon = strchr(text, ':');

    if (!colon || (size_t)(colon - text) >= sizeof name)
        return lf_error_set(err, LF_E_ARG, option, "expects INTEGRATOR:ESTIMATOR, not \"%s\"", text);
    snprintf(name, sizeof name, "%.*s", (int)(colon - text), text);
    lf_status status = lf_options_take(&parsed, LF_OPTION_INTEGRATOR, name, &taken, err);
    if (status == LF_OK)
        status = lf_options_take(&parsed, LF_OPTION_ESTIMATOR, colon + 1, &taken, err);
    if (status == LF_OK)
        *out = (lf_contender){parsed.integrator, parsed.estimator};
    return status;
}

static lf_status take_int(const char *option, const char *text, int64_t high, int *out, lf_error *err)
{
    int64_t number = 0;
    lf_status status = lf_parse_int(option, text, 1, high, &number, err);

    if (status == LF_OK)
        *out = (int)number;
    return status;
}

static lf_status take(lf_trial_options *options, const lf_trial_command *command, int code, const char *text, lf_error *err)
{
    bool taken = false;
    lf_status status = lf_options_take(&options->common, code, text, &taken, err);

    if (status != LF_OK || taken)
        return status;
    switch (code) {
    case LF_TRIAL_OPTION_TIME:
        return lf_parse_double("--time", text, 1e-2, 1e6, &options->seconds, err);
    case LF_TRIAL_OPTION_SEEDS:
        return take_int("--seeds", text, LF_MAX_SEEDS, &options->n_seeds, err);
    case LF_TRIAL_OPTION_REFERENCE:
        return lf_contender_parse("--reference", text, &options->reference, err);
    case LF_TRIAL_OPTION_REFERENCE_SPP:
        options->reference_seconds = 0;
        return take_int("--reference-spp", text, 1 << 24, &options->reference_spp, err);
    case LF_TRIAL_OPTION_REFERENCE_TIME:
        return lf_parse_double("--reference-time", text, 1e-2, 1e6, &options->reference_seconds, err);
    case LF_TRIAL_OPTION_EPSILON:
        return lf_parse_double("--epsilon", text, 0, 1e9, &options->epsilon, err);
    case LF_TRIAL_OPTION_JSON:
        options->json = text;
        return LF_OK;
    default:
        return command->take(command->context, code, text, err);
    }
}

lf_status lf_trial_parse(const lf_trial_command *command, int argc, char **argv, lf_trial_options *options, bool *out_done,
                         lf_error *err)
{
    int code = 0;

    *out_done = false;
    for (;;) {
        lf_status status = lf_options_next(argc, argv, ":", command->table, &code, err);
        if (status != LF_OK)
            return status;
        if (code == -1)
            break;
        if (code == LF_OPTION_HELP || code == LF_OPTION_VERSION) {
            code == LF_OPTION_HELP ? command->print_help() : lf_print_version(LF_BENCH_PROGRAM);
            *out_done = true;
            return LF_OK;
        }
        status = take(options, command, code, optarg, err);
        if (status != LF_OK)
            return status;
    }
    if (argc - optind != 1)
        return lf_error_set(err, LF_E_ARG, command->name, "expects one %s (see quiltbench %s --help)", command->operand,
                            command->name);
    if (options->common.integrator || options->common.has_estimator || options->common.target_error > 0)
        return lf_error_set(err, LF_E_ARG, command->name,
                            "INTEGRATOR:ESTIMATOR pairs say what runs, and budgets for how long (see quiltbench %s --help)",
                            command->name);
    options->operand = argv[optind];
    return LF_OK;
}
