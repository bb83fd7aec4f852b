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
        return lf_error_set(err, LF_E_ARG, option, "expects INTEGRATOR:ESTIMATOR, not \"%s\"",
                            text);
    snprintf(name, sizeof name, "%.*s", (int)(colon - text), text);
    lf_status status = lf_options_take(&parsed, LF_OPTION_INTEGRATOR, name, &taken, err);
    if (status == LF_OK)
        status = lf_options_take(&parsed, LF_OPTION_ESTIMATOR, colon + 1, &taken, err);
    if (status == LF_OK)
        *out = (lf_contender){parsed.integrator, parsed.estimator};
    return status;
}

/* Where an option may belong: to all trials, else to the command. */
typedef struct takers {
    lf_trial_options *options;
    const lf_trial_command *command;
} takers;

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    const takers *to = context;
    lf_trial_options *options = to->options;
    switch (code) {
    case LF_TRIAL_OPTION_TIME:
        return lf_parse_double("--time", text, 1e-2, 1e6, &options->seconds, err);
    case LF_TRIAL_OPTION_SEEDS:
        return lf_parse_small("--seeds", text, 1, LF_MAX_SEEDS, &options->n_seeds, err);
    case LF_TRIAL_OPTION_REFERENCE:
        return lf_contender_parse("--reference", text, &options->reference, err);
    case LF_TRIAL_OPTION_REFERENCE_SPP:
        options->reference_seconds = 0;
        return lf_parse_small("--reference-spp", text, 1, 1 << 24, &options->reference_spp, err);
    case LF_TRIAL_OPTION_REFERENCE_TIME:
        return lf_parse_double("--reference-time", text, 1e-2, 1e6, &options->reference_seconds,
                               err);
    case LF_TRIAL_OPTION_EPSILON:
        return lf_parse_double("--epsilon", text, 0, 1e9, &options->epsilon, err);
    case LF_TRIAL_OPTION_JSON:
        options->json = text;
        return LF_OK;
    default:
        return to->command->take(to->command->context, code, text, err);
    }
}

lf_status lf_trial_parse(const lf_trial_command *command, int argc, char **argv,
                         lf_trial_options *options, bool *out_done, lf_error *err)
{
    takers to = {options, command};
    const lf_options_rules rules = {
        LF_BENCH_PROGRAM, ":", command->table, command->print_help, &options->common, take, &to};
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (argc - optind != 1)
        return lf_error_set(err, LF_E_ARG, command->name,
                            "expects one %s (see quiltbench %s --help)", command->operand,
                            command->name);
    if (options->common.integrator || options->common.has_estimator ||
        options->common.target_error > 0)
        return lf_error_set(err, LF_E_ARG, command->name,
                            "INTEGRATOR:ESTIMATOR pairs say what runs, and budgets for how long "
                            "(see quiltbench %s --help)",
                            command->name);
    options->operand = argv[optind];
    return LF_OK;
}
