/* quiltbench views SCENE: error against the number of views for the same number of base paths in
 * every view (Fraboni et al. 2022, Figure 9): what sharing is worth before its price. N views of
 * one cone; were every base path as good for every view, relMSE would fall as 1/N. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/trial.h"

#define MAX_COUNTS 16

typedef struct study {
    lf_trial_options options;
    lf_contender who;
    int counts[MAX_COUNTS];
    int n_counts;
    int spp;
    const char *plot;
    lf_pool *pool;
    json_t *scene;                           /* what lf_trial_json says of the last trial */
    double errors[MAX_COUNTS][LF_MAX_SEEDS]; /* relMSE x base paths a view pixel / spp */
    double paths[MAX_COUNTS];                /* base paths a view pixel, mean over seeds */
    lf_interval rel_mse[MAX_COUNTS];
    lf_interval exponent; /* of N: 95 % over the seeds' own fits */
    double exponent_se;
} study;

enum { OPTION_COUNTS = LF_TRIAL_OPTION_OWN, OPTION_CONTENDER, OPTION_SPP, OPTION_PLOT };

static const struct option table[] = {
    LF_TRIAL_OPTIONS_LONG,
    {"counts", required_argument, NULL, OPTION_COUNTS},
    {"contender", required_argument, NULL, OPTION_CONTENDER},
    {"spp", required_argument, NULL, OPTION_SPP},
    {"plot", required_argument, NULL, OPTION_PLOT},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench views SCENE [options]\n"
           "Measure relMSE for 1, 2, 4, … views in one cone, each with the same number of base "
           "paths, and fit the exponent of N.\n\n"
           "  --counts LIST             numbers of views in ascending order "
           "(1,2,4,8,16,32,45,64)\n"
           "  --spp N                   base paths per view pixel (8)\n"
           "  --contender NAME:ESTIMATOR  integrator to test (mvpt:mwis)\n"
           "  --seeds N                 runs per number of views (8)\n"
           "  --plot PREFIX             plot to PREFIX.svg and PREFIX.png with gnuplot "
           "(PREFIX.gp, PREFIX.dat)\n");
    lf_trial_print_help();
}

static lf_status take_counts(study *s, const char *text, lf_error *err)
{
    char word[16];
    int number = 0;
    s->n_counts = 0;
    for (const char *at = text; at;) {
        size_t n = strcspn(at, ",");
        snprintf(word, sizeof word, "%.*s", (int)(n < sizeof word ? n : sizeof word - 1), at);
        lf_status status = lf_parse_small("--counts", word, 1, LF_MAX_VIEWS, &number, err);
        if (status != LF_OK)
            return status;
        if (s->n_counts == MAX_COUNTS || (s->n_counts > 0 && number <= s->counts[s->n_counts - 1]))
            return lf_error_set(err, LF_E_ARG, "--counts",
                                "expects at most %d numbers in ascending order", MAX_COUNTS);
        s->counts[s->n_counts++] = number;
        at = at[n] ? at + n + 1 : NULL;
    }
    return LF_OK;
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    study *s = context;
    switch (code) {
    case OPTION_COUNTS:
        return take_counts(s, text, err);
    case OPTION_CONTENDER:
        return lf_contender_parse("--contender", text, &s->who, err);
    case OPTION_SPP:
        return lf_parse_small("--spp", text, 1, 1 << 20, &s->spp, err);
    default:
        s->plot = text;
        return LF_OK;
    }
}

/* Samples for holes come on top of the passes: they count as paths. */
static lf_status run_count(study *s, int i, lf_error *err)
{
    lf_trial_options options = s->options;
    lf_trial trial = {0};
    lf_measure measures[LF_MAX_SEEDS] = {0};
    const lf_budget budget = {.passes = (int64_t)s->spp * s->counts[i]};
    options.common.views = s->counts[i];
    lf_status status = lf_trial_open(&trial, options.operand, &options, s->pool, err);
    if (status == LF_OK)
        status = lf_trial_reference(&trial, &options, err);
    if (status == LF_OK)
        status = lf_trial_all(&trial, &s->who, 1, &options, &budget, 1, measures, err);
    for (int seed = 0; seed < options.n_seeds && status == LF_OK; seed++) {
        double paths = (double)measures[seed].stats.base_paths / ((double)trial.n / 3);
        s->paths[i] += paths / options.n_seeds;
        s->errors[i][seed] = measures[seed].rel_mse * paths / s->spp;
    }
    s->rel_mse[i] = lf_log_interval(s->errors[i], options.n_seeds, 0.95);
    if (status == LF_OK) {
        json_decref(s->scene);
        s->scene = lf_trial_json(&trial, &options);
        json_object_del(s->scene, "reference"); /* one for every number of views */
        json_object_del(s->scene, "views");
    }
    lf_trial_close(&trial);
    return status;
}

/* A line through every seed's own points; the seeds are independent. */
static void fit(study *s)
{
    double slopes[LF_MAX_SEEDS];
    double x[MAX_COUNTS];
    double y[MAX_COUNTS];
    int n = s->options.n_seeds;
    for (int seed = 0; seed < n; seed++) {
        for (int i = 0; i < s->n_counts; i++) {
            x[i] = log(s->counts[i]);
            y[i] = log(s->errors[i][seed]);
        }
        slopes[seed] = s->n_counts > 1 ? lf_fit_line(x, y, s->n_counts).slope : (double)NAN;
    }
    s->exponent = lf_mean_interval(slopes, n, 0.95);
    s->exponent_se =
        n > 1 ? (s->exponent.high - s->exponent.estimate) / lf_student_quantile(0.975, n - 1)
              : (double)NAN;
}

static json_t *counts_json(const study *s)
{
    json_t *list = json_array();
    for (int i = 0; i < s->n_counts; i++) {
        json_t *runs = json_array();
        for (int seed = 0; seed < s->options.n_seeds; seed++)
            json_array_append_new(runs, lf_bench_number(s->errors[i][seed]));
        json_array_append_new(list, json_pack("{s:i, s:f, s:o, s:o}", "views", s->counts[i],
                                              "base_paths", s->paths[i], "rel_mse",
                                              lf_interval_json(s->rel_mse[i]), "runs", runs));
    }
    return list;
}

static json_t *study_json(const study *s)
{
    return json_pack("{s:O, s:s, s:s, s:i, s:o, s:o, s:o}", "setting", s->scene, "integrator",
                     s->who.integrator, "estimator", lf_estimator_name(s->who.estimator), "spp",
                     s->spp, "exponent", lf_interval_json(s->exponent), "exponent_se",
                     lf_bench_number(s->exponent_se), "counts", counts_json(s));
}

static void print_count(const study *s, int i)
{
    const lf_interval *e = &s->rel_mse[i];
    printf("%5d   ", s->counts[i]);
    lf_bench_put_short(stdout, 9, 3, e->estimate);
    lf_bench_put_short(stdout, 10, 3, e->low);
    fputs(" .. ", stdout);
    lf_bench_put_short(stdout, -9, 3, e->high);
    lf_bench_put_short(stdout, 11, 3, e->estimate * s->counts[i]);
    printf("   %7.2f\n", s->paths[i]);
}

static void print_table(const study *s)
{
    printf("%s: %s %s, %d base paths per view pixel, %d seeds\n\n", s->options.operand,
           s->who.integrator, lf_estimator_name(s->who.estimator), s->spp, s->options.n_seeds);
    printf("views      relMSE  (95 %%)                  x views   base paths\n");
    for (int i = 0; i < s->n_counts; i++)
        print_count(s, i);
    if (!isfinite(s->exponent.low)) {
        puts("\n"
             "- and no exponent: both need at least two seeds, two numbers of views, and errors "
             "above the error of the reference (--seeds, --counts, --reference-spp)");
        return;
    }
    printf("\n"
           "relMSE (at %d base paths) falls as N^%.3f, standard error %.3f (95 %%: %.3f .. "
           "%.3f); required: N^-0.8: %s\n",
           s->spp, s->exponent.estimate, s->exponent_se, s->exponent.low, s->exponent.high,
           s->exponent.estimate <= -0.8 ? "met" : "not met");
}

static lf_status plot(const study *s, lf_error *err)
{
    char *data = NULL;
    char *commands = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&data, &size);
    if (out) {
        fputs("# views, relMSE, low, high\n", out);
        for (int i = 0; i < s->n_counts; i++)
            fprintf(out, "%d %.6g %.6g %.6g\n", s->counts[i], s->rel_mse[i].estimate,
                    s->rel_mse[i].low, s->rel_mse[i].high);
        fclose(out);
    }
    if (asprintf(&commands,
                 "set logscale xy\n"
                 "set format y '10^{%%L}'\n"
                 "set xlabel 'views'\n"
                 "set ylabel 'relMSE at %d base paths per view pixel'\n"
                 "plot data with yerrorlines pointtype 5 title '%s %s', %.6g/x with lines "
                 "dashtype 2 title '1/N'",
                 s->spp, s->who.integrator, lf_estimator_name(s->who.estimator),
                 s->rel_mse[0].estimate * s->counts[0]) < 0)
        commands = NULL;
    lf_status status = data && commands ? lf_bench_plot(s->plot, data, commands, err)
                                        : lf_error_set(err, LF_E_NOMEM, s->plot, "out of memory");
    free(data);
    free(commands);
    return status;
}

static lf_status run(study *s, lf_error *err)
{
    lf_status status = lf_bench_pool(s->options.common.threads, &s->pool, err);
    for (int i = 0; i < s->n_counts && status == LF_OK; i++)
        status = run_count(s, i, err);
    if (status != LF_OK)
        return status;
    fit(s);
    if (!lf_trial_is_quiet(&s->options))
        print_table(s);
    if (s->options.json)
        status = lf_bench_write_json(s->options.json, study_json(s), err);
    if (status == LF_OK && s->options.csv)
        status = lf_bench_write_csv(s->options.csv, counts_json(s), err);
    return status == LF_OK && s->plot ? plot(s, err) : status;
}

int lf_bench_views(int argc, char **argv)
{
    study s = {
        .options = {.common = {.view_width = 60, .view_height = 80},
                    .n_seeds = 8,
                    .reference = {"mvpt", LF_ESTIMATOR_CV},
                    .reference_spp = 32,
                    .epsilon = 1e-2},
        .who = {"mvpt", LF_ESTIMATOR_MWIS},
        .counts = {1, 2, 4, 8, 16, 32, 45, 64},
        .n_counts = 8,
        .spp = 8,
    };
    const lf_trial_command command = {"views", "SCENE", table, print_help, take, &s};
    lf_error err = {0};
    bool done = false;
    if (lf_trial_parse(&command, argc, argv, &s.options, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_bench_plot_begin(s.plot);
    lf_status status = run(&s, &err);
    json_decref(s.scene);
    lf_pool_destroy(s.pool);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
