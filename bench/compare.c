/* quiltbench compare SCENE: the error of two ways to render after equal CPU time, over several
 * seeds, taken in turns so that a machine that slows down slows both. */
#include <math.h>
#include <stdio.h>

#include "bench/bench.h"
#include "bench/trial.h"

enum { BASELINE, OURS, N_CONTENDERS };

typedef struct comparison {
    lf_trial_options options;
    lf_contender contenders[N_CONTENDERS];
    double min_ratio; /* 0 = not asked for */
    lf_trial trial;
    lf_measure measures[N_CONTENDERS][LF_MAX_SEEDS]; /* packed: n_seeds of each */
} comparison;

enum { OPTION_OURS = LF_TRIAL_OPTION_OWN, OPTION_BASELINE, OPTION_MIN_RATIO };

static const struct option table[] = {
    LF_TRIAL_OPTIONS_LONG,
    {"ours", required_argument, NULL, OPTION_OURS},
    {"baseline", required_argument, NULL, OPTION_BASELINE},
    {"min-ratio", required_argument, NULL, OPTION_MIN_RATIO},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench compare SCENE [options]\n"
           "Compare the relMSE (mean over the views) of two integrators at equal total CPU "
           "time. Their runs alternate.\n\n"
           "  --time SECONDS            CPU time per run (10)\n"
           "  --seeds N                 runs per integrator (8)\n"
           "  --ours NAME:ESTIMATOR     integrator to test (mvpt:mwis)\n"
           "  --baseline NAME:ESTIMATOR integrator to compare with (vpt:mis)\n"
           "  --min-ratio R             exit with status 1 if the median ratio is below R\n");
    lf_trial_print_help();
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    comparison *c = context;
    switch (code) {
    case OPTION_OURS:
        return lf_contender_parse("--ours", text, &c->contenders[OURS], err);
    case OPTION_BASELINE:
        return lf_contender_parse("--baseline", text, &c->contenders[BASELINE], err);
    default:
        return lf_parse_double("--min-ratio", text, 0, 1e9, &c->min_ratio, err);
    }
}

static const lf_measure *measures_of(const comparison *c, int contender)
{
    return &c->measures[0][0] + contender * c->options.n_seeds;
}

static lf_spread errors_of(const lf_measure *measures, int n)
{
    double values[LF_MAX_SEEDS];
    for (int i = 0; i < n; i++)
        values[i] = measures[i].rel_mse;
    return lf_spread_of(values, n);
}

static lf_spread ratios_of(const comparison *c, double *out_ratio)
{
    for (int i = 0; i < c->options.n_seeds; i++)
        out_ratio[i] = lf_measure_ratio(measures_of(c, BASELINE) + i, measures_of(c, OURS) + i);
    return lf_spread_of(out_ratio, c->options.n_seeds);
}

static json_t *run_json(const lf_measure *m)
{
    return json_pack("{s:f, s:f, s:f, s:f}", "rel_mse", m->rel_mse, "cpu_seconds", m->cpu_seconds,
                     "native_spp", m->stats.native_spp_mean, "effective_spp",
                     m->stats.effective_spp_mean);
}

/* A line of CSV each. */
static json_t *runs_of_both(const comparison *c)
{
    json_t *runs = json_array();
    for (int i = 0; i < N_CONTENDERS * c->options.n_seeds; i++) {
        const int who = i / c->options.n_seeds, seed = i % c->options.n_seeds;
        json_t *run = lf_contender_json(&c->contenders[who]);
        json_object_set_new(run, "run", json_integer(seed + 1));
        json_object_update_new(run, run_json(measures_of(c, who) + seed));
        json_array_append_new(runs, run);
    }
    return runs;
}

static json_t *contender_json(const comparison *c, int contender)
{
    const lf_contender *who = &c->contenders[contender];
    const lf_measure *measures = measures_of(c, contender);
    lf_spread error = errors_of(measures, c->options.n_seeds);
    json_t *runs = json_array();
    for (int i = 0; i < c->options.n_seeds; i++)
        json_array_append_new(runs, run_json(&measures[i]));
    return json_pack("{s:s, s:s, s:f, s:f, s:f, s:o}", "integrator", who->integrator, "estimator",
                     lf_estimator_name(who->estimator), "rel_mse_median", error.median,
                     "rel_mse_low", error.low, "rel_mse_high", error.high, "runs", runs);
}

static json_t *comparison_json(const comparison *c)
{
    double ratio[LF_MAX_SEEDS] = {0.0};
    lf_spread ratios = ratios_of(c, ratio);
    json_t *object = lf_trial_json(&c->trial, &c->options);
    json_t *list = json_array();
    for (int i = 0; i < c->options.n_seeds; i++)
        json_array_append_new(list, lf_bench_number(ratio[i]));
    json_object_set_new(object, "cpu_seconds", json_real(c->options.seconds));
    json_object_set_new(object, "ours", contender_json(c, OURS));
    json_object_set_new(object, "baseline", contender_json(c, BASELINE));
    json_object_set_new(object, "ratio_median", lf_bench_number(ratios.median));
    json_object_set_new(object, "ratio_low", lf_bench_number(ratios.low));
    json_object_set_new(object, "ratio_high", lf_bench_number(ratios.high));
    json_object_set_new(object, "ratios", list);
    return object;
}

static void print_contender(const comparison *c, int contender)
{
    const lf_contender *who = &c->contenders[contender];
    const lf_measure *measures = measures_of(c, contender);
    int n = c->options.n_seeds;
    lf_spread error = errors_of(measures, n);
    double cpu = 0;
    double native = 0;
    double effective = 0;
    for (int i = 0; i < n; i++) {
        cpu += measures[i].cpu_seconds / n;
        native += measures[i].stats.native_spp_mean / n;
        effective += measures[i].stats.effective_spp_mean / n;
    }
    printf("%-10s %-6s %12.4g   (%.4g .. %.4g) %10.2f %10.3f %11.2f\n", who->integrator,
           lf_estimator_name(who->estimator), error.median, error.low, error.high, cpu, native,
           effective);
}

static void print_table(const comparison *c)
{
    double ratio[LF_MAX_SEEDS];
    lf_spread ratios = ratios_of(c, ratio);
    lf_trial_print(&c->trial, &c->options);
    printf("\n                    relMSE median  (low .. high)          CPU s   native spp  "
           "effective\n");
    print_contender(c, BASELINE);
    print_contender(c, OURS);
    if (isfinite(ratios.median))
        printf("\n"
               "ratio at equal time (%g CPU seconds): %.2f (median over seeds; %.2f .. %.2f)\n",
               c->options.seconds, ratios.median, ratios.low, ratios.high);
    else
        puts("\n"
             "no ratio: an error is not above the error of the reference; raise --reference-spp "
             "or --reference-time");
}

static lf_status report(const comparison *c, lf_error *err)
{
    const lf_trial_options *options = &c->options;
    double ratio[LF_MAX_SEEDS];
    double median = ratios_of(c, ratio).median;
    lf_status status = LF_OK;
    if (!lf_trial_is_quiet(options))
        print_table(c);
    if (options->json)
        status = lf_bench_write_json(options->json, comparison_json(c), err);
    if (status == LF_OK && options->csv)
        status = lf_bench_write_csv(options->csv, runs_of_both(c), err);
    if (status == LF_OK && c->min_ratio > 0 && !(median >= c->min_ratio))
        return lf_error_set(err, LF_E_STATE, options->operand,
                            "the median ratio is %.2f, below the minimum %g (--min-ratio)", median,
                            c->min_ratio);
    return status;
}

static lf_status run(comparison *c, lf_pool *pool, lf_error *err)
{
    const lf_budget budget = {.cpu_seconds = c->options.seconds};
    lf_status status = lf_trial_open(&c->trial, c->options.operand, &c->options, pool, err);
    if (status == LF_OK)
        status = lf_trial_reference(&c->trial, &c->options, err);
    if (status == LF_OK)
        status = lf_trial_all(&c->trial, c->contenders, N_CONTENDERS, &c->options, &budget, 1,
                              &c->measures[0][0], err);
    if (status == LF_OK)
        status = report(c, err);
    lf_trial_close(&c->trial);
    return status;
}

int lf_bench_compare(int argc, char **argv)
{
    comparison c = {
        .contenders =
            {[BASELINE] = {"vpt", LF_ESTIMATOR_MIS}, [OURS] = {"mvpt", LF_ESTIMATOR_MWIS}},
        .options = {.seconds = 10,
                    .n_seeds = 8,
                    .reference = {"mvpt", LF_ESTIMATOR_CV},
                    .reference_spp = 128,
                    .epsilon = 1e-2},
    };
    const lf_trial_command command = {"compare", "SCENE", table, print_help, take, &c};
    lf_pool *pool = NULL;
    lf_error err = {0};
    bool done = false;
    if (lf_trial_parse(&command, argc, argv, &c.options, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_status status = lf_bench_pool(c.options.common.threads, &pool, &err);
    if (status == LF_OK)
        status = run(&c, pool, &err);
    lf_pool_destroy(pool);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
