#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/trial.h"

lf_status lf_contender_parse(const char *option, const char *text, lf_contender *out, lf_error *err)
{
    lf_param rows[] = {*lf_param_find(lf_option_params, "integrator"),
                       *lf_param_find(lf_option_params, "estimator")};
    rows[0].option = option + 2; /* without dashes */
    rows[0].joined = ":";
    rows[0].argument = "INTEGRATOR";
    rows[0].place = offsetof(lf_contender, integrator);
    rows[1].argument = "ESTIMATOR";
    rows[1].has = 0;
    rows[1].place = offsetof(lf_contender, estimator);
    return lf_param_from_text(rows, text, out, err);
}

bool lf_trial_is_quiet(const lf_trial_options *options)
{
    return lf_bench_is_stdout(options->json) || lf_bench_is_stdout(options->csv);
}

void lf_trial_print_help(void)
{
    printf("  --reference NAME:ESTIMATOR  integrator of the reference; two renderings give its "
           "error (mvpt:cv)\n"
           "  --reference-spp N         samples per pixel of each reference rendering\n"
           "  --reference-time SECONDS  CPU time of each reference rendering, instead of "
           "--reference-spp\n"
           "  --epsilon E               epsilon of relMSE (0.01)\n"
           "  --json FILE               write all results as JSON (-: standard output)\n"
           "  --csv FILE                write the numbers as CSV (-: standard output)\n");
    lf_param_print_help(lf_option_params, LF_OPTIONS_VIEWS
                        " calibration sampler max-depth light-paths suffixes skip threads");
    lf_param_print_help(lf_integrator_params(), NULL);
    printf("  --seed S               random seed of the first run (1)\n" LF_OPTIONS_HELP_LAST);
}

/* The possible owners of an option: all trials, otherwise the command. */
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
    case LF_TRIAL_OPTION_CSV:
        options->csv = text;
        return LF_OK;
    default:
        return to->command->take(to->command->context, code, text, err);
    }
}

lf_status lf_trial_parse(const lf_trial_command *command, int argc, char **argv,
                         lf_trial_options *options, bool *out_done, lf_error *err)
{
    takers to = {options, command};
    const lf_options_part parts[] = {
        {lf_option_params,
         LF_OPTIONS_VIEWS " calibration target-error light-paths suffixes " LF_OPTIONS_RENDER,
         &options->common},
        {lf_integrator_params(), NULL, &options->common.choices},
        {0}};
    const lf_options_rules rules = {.program = LF_BENCH_PROGRAM,
                                    .letters = ":",
                                    .parts = parts,
                                    .table = command->table,
                                    .print_help = command->print_help,
                                    .take = take,
                                    .context = &to};
    options->common.seed = 1;
    options->common.tracing.offline = true;
    lf_status status = lf_options_read(argc, argv, &rules, out_done, err);
    if (status != LF_OK || *out_done)
        return status;
    if (argc - optind != 1)
        return lf_error_set(err, LF_E_ARG, command->name,
                            "expects one %s; see quiltbench %s --help", command->operand,
                            command->name);
    if (options->common.integrator || options->common.has_estimator ||
        options->common.target_error > 0)
        return lf_error_set(err, LF_E_ARG, command->name,
                            "does not take --integrator, --estimator and --target-error; use "
                            "INTEGRATOR:ESTIMATOR pairs and budgets (see quiltbench %s --help)",
                            command->name);
    if (lf_bench_is_stdout(options->json) && lf_bench_is_stdout(options->csv))
        return lf_error_set(
            err, LF_E_ARG, "--csv",
            "cannot write to standard output, because --json does; give a file name");
    options->operand = argv[optind];
    return LF_OK;
}

lf_status lf_trial_check_markdown(const char *path, lf_error *err)
{
    return lf_bench_is_stdout(path)
               ? lf_error_set(err, LF_E_ARG, "--markdown",
                              "the table is always printed to standard output; give a file name")
               : LF_OK;
}

static bool is_first(const char *at, size_t n, const char *name)
{
    return strlen(name) == n && strncmp(name, at, n) == 0;
}

lf_status lf_trial_check_names(const char *option, const char *list, const char *(*name_at)(int),
                               lf_error *err)
{
    for (const char *at = list; at;) {
        const size_t n = strcspn(at, ",");
        int i = 0;
        while (name_at(i) && !is_first(at, n, name_at(i)))
            i++;
        if (!name_at(i))
            return lf_error_set(err, LF_E_ARG, option,
                                "unknown scene \"%.*s\"; --help lists the scenes", (int)n, at);
        at = at[n] ? at + n + 1 : NULL;
    }
    return LF_OK;
}

bool lf_trial_names(const char *list, const char *name)
{
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (is_first(at, strcspn(at, ","), name))
            return true;
    return !list;
}
