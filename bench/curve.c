/* quiltbench curve SCENE: error against CPU time at doubling budgets, what one contender is worth
 * in the time of another, and where the time goes. The first contender is the baseline. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/trial.h"

#define MAX_CONTENDERS 8
#define CONFIDENCE 0.95

/* One contender at one budget, over all seeds. */
typedef struct point {
    double cpu_seconds, native_spp, effective_spp, correlation[2]; /* means */
    double without; /* share of view pixels that N/W answers for and that have none */
    lf_interval rel_mse, worst_view;
    lf_interval equal_time, equal_error; /* how many times better than the baseline */
    /* equal_error leans on the baseline's line beyond its last point in some seed */
    bool beyond;
} point;

/* Where the time of one contender goes, at the last budget, over all seeds. NaN = does not apply.
 */
typedef struct cost {
    double path_us, shift_ns, lookup_ns, contributions_per_path, escape_share;
    lf_interval slope; /* of log error over log time */
} cost;

typedef struct curve {
    lf_trial_options options;
    lf_contender contenders[MAX_CONTENDERS];
    int n_contenders;
    int n_budgets;
    const char *plot;
    lf_trial trial;
    lf_measure *measures; /* [contender][seed][budget] */
    point points[MAX_CONTENDERS][LF_MAX_BUDGETS];
    cost costs[MAX_CONTENDERS];
} curve;

/* --------------------------------------------------------------------------------- arguments -- */

enum { OPTION_CONTENDERS = LF_TRIAL_OPTION_OWN, OPTION_BUDGETS, OPTION_PLOT };

static const struct option table[] = {
    LF_TRIAL_OPTIONS_LONG,
    {"contenders", required_argument, NULL, OPTION_CONTENDERS},
    {"budgets", required_argument, NULL, OPTION_BUDGETS},
    {"plot", required_argument, NULL, OPTION_PLOT},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench curve SCENE [options]\n"
           "Measure relMSE against CPU time at doubling budgets, with 95 %% intervals over the "
           "seeds. Contenders alternate.\n\n"
           "  --contenders LIST         NAME:ESTIMATOR,…; the first is the baseline "
           "(vpt:mwis,mvpt:mwis)\n"
           "  --time SECONDS            CPU time of the shortest budget (1)\n"
           "  --budgets N               number of budgets, each twice the one before (5)\n"
           "  --seeds N                 runs per contender (8)\n"
           "  --plot PREFIX             plot to PREFIX.svg and PREFIX.png with gnuplot "
           "(PREFIX.gp, PREFIX.dat)\n");
    lf_trial_print_help();
}

static lf_status take_contenders(curve *c, const char *text, lf_error *err)
{
    char word[64];
    lf_status status = LF_OK;
    c->n_contenders = 0;
    for (const char *at = text; at && status == LF_OK;) {
        size_t n = strcspn(at, ",");
        if (c->n_contenders == MAX_CONTENDERS)
            return lf_error_set(err, LF_E_ARG, "--contenders", "expects at most %d contenders",
                                MAX_CONTENDERS);
        snprintf(word, sizeof word, "%.*s", (int)(n < sizeof word ? n : sizeof word - 1), at);
        status = lf_contender_parse("--contenders", word, &c->contenders[c->n_contenders], err);
        c->n_contenders += status == LF_OK;
        at = at[n] ? at + n + 1 : NULL;
    }
    return status;
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    curve *c = context;
    switch (code) {
    case OPTION_CONTENDERS:
        return take_contenders(c, text, err);
    case OPTION_BUDGETS:
        return lf_parse_small("--budgets", text, 1, LF_MAX_BUDGETS, &c->n_budgets, err);
    default:
        c->plot = text;
        return LF_OK;
    }
}

/* ---------------------------------------------------------------------------------- analysis -- */

static const lf_measure *measure_of(const curve *c, int contender, int seed, int budget)
{
    return &c->measures[((size_t)contender * (size_t)c->options.n_seeds + (size_t)seed) *
                            (size_t)c->n_budgets +
                        (size_t)budget];
}

/* When the baseline is as good as this, in the curve of the same seed. */
static double equal_error_ratio(const curve *c, int seed, const lf_measure *ours, bool *out_beyond)
{
    double times[LF_MAX_BUDGETS];
    double errors[LF_MAX_BUDGETS];
    for (int b = 0; b < c->n_budgets; b++) {
        times[b] = measure_of(c, 0, seed, b)->cpu_seconds;
        errors[b] = measure_of(c, 0, seed, b)->rel_mse;
    }
    return lf_time_of_error(times, errors, c->n_budgets, ours->rel_mse, out_beyond) /
           ours->cpu_seconds;
}

static void find_point(const curve *c, int contender, int budget, point *out)
{
    double error[LF_MAX_SEEDS];
    double worst[LF_MAX_SEEDS];
    double equal_time[LF_MAX_SEEDS];
    double equal_error[LF_MAX_SEEDS];
    int n = c->options.n_seeds;
    *out = (point){0};
    for (int i = 0; i < n; i++) {
        const lf_measure *m = measure_of(c, contender, i, budget);
        bool beyond = false;
        out->cpu_seconds += m->cpu_seconds / n;
        out->native_spp += m->stats.native_spp_mean / n;
        out->effective_spp += m->stats.effective_spp_mean / n;
        out->without += lf_without_ratio(&c->trial, &c->contenders[contender], m) / n;
        out->correlation[0] += m->correlation[0] / n;
        out->correlation[1] += m->correlation[1] / n;
        error[i] = m->rel_mse;
        worst[i] = m->worst_view;
        equal_time[i] = lf_measure_ratio(measure_of(c, 0, i, budget), m);
        equal_error[i] = equal_error_ratio(c, i, m, &beyond);
        out->beyond |= beyond;
    }
    out->rel_mse = lf_log_interval(error, n, CONFIDENCE);
    out->worst_view = lf_log_interval(worst, n, CONFIDENCE);
    out->equal_time = lf_log_interval(equal_time, n, CONFIDENCE);
    out->equal_error = lf_log_interval(equal_error, n, CONFIDENCE);
}

/* How fast the error falls: -1 for independent samples. */
static lf_interval find_slope(const curve *c, int contender)
{
    double slopes[LF_MAX_SEEDS];
    for (int i = 0; i < c->options.n_seeds; i++) {
        double x[LF_MAX_BUDGETS];
        double y[LF_MAX_BUDGETS];
        for (int b = 0; b < c->n_budgets; b++) {
            x[b] = log(measure_of(c, contender, i, b)->cpu_seconds);
            y[b] = log(measure_of(c, contender, i, b)->rel_mse);
        }
        slopes[i] = c->n_budgets > 1 ? lf_fit_line(x, y, c->n_budgets).slope : (double)NAN;
    }
    return lf_mean_interval(slopes, c->options.n_seeds, CONFIDENCE);
}

static double share(double part, double whole)
{
    return part >= 0 && whole > 0 ? part / whole : (double)NAN;
}

static void find_cost(const curve *c, int contender, cost *out)
{
    double cpu = 0;
    double paths = 0;
    double contributions = 0;
    double lookups = 0;
    for (int i = 0; i < c->options.n_seeds; i++) {
        const lf_measure *m = measure_of(c, contender, i, c->n_budgets - 1);
        cpu += m->cpu_seconds;
        paths += (double)m->stats.base_paths;
        contributions += (double)m->stats.contributions;
        lookups += (double)m->stats.volume_lookups;
    }
    bool alone = !lf_integrator_named(c->contenders[contender].integrator)->shares;
    *out = (cost){
        .path_us = share(1e6 * cpu, paths),
        .lookup_ns = share(1e9 * cpu, lookups),
        .contributions_per_path = share(contributions, paths),
        /* a pivot of what shares nothing is one contribution */
        .escape_share = alone ? 1 - share(contributions, paths) : (double)NAN,
        .slope = find_slope(c, contender),
    };
    out->shift_ns =
        alone ? (double)NAN
              : 1e3 * (out->path_us - c->costs[0].path_us) / c->trial.settings.camera.n_views;
}

static void analyse(curve *c)
{
    for (int i = 0; i < c->n_contenders; i++) {
        for (int b = 0; b < c->n_budgets; b++)
            find_point(c, i, b, &c->points[i][b]);
        find_cost(c, i, &c->costs[i]);
    }
}

/* --------------------------------------------------------------------------------- reporting -- */

static json_t *run_json(const lf_measure *m)
{
    return json_pack("{s:o, s:o, s:f, s:f, s:f, s:I}", "rel_mse", lf_bench_number(m->rel_mse),
                     "worst_view", lf_bench_number(m->worst_view), "cpu_seconds", m->cpu_seconds,
                     "native_spp", m->stats.native_spp_mean, "effective_spp",
                     m->stats.effective_spp_mean, "nonfinite", (json_int_t)m->n_nonfinite);
}

static json_t *runs_json(const curve *c, int contender, int budget)
{
    json_t *list = json_array();
    for (int i = 0; i < c->options.n_seeds; i++)
        json_array_append_new(list, run_json(measure_of(c, contender, i, budget)));
    return list;
}

/* A line of CSV each. */
static json_t *all_runs(const curve *c)
{
    json_t *list = json_array();
    const int n = c->options.n_seeds;
    for (int i = 0; i < c->n_contenders * c->n_budgets * n; i++) {
        const int who = i / n / c->n_budgets, budget = i / n % c->n_budgets;
        json_t *run = lf_contender_json(&c->contenders[who]);
        json_object_set_new(run, "budget", json_real(ldexp(c->options.seconds, budget)));
        json_object_set_new(run, "run", json_integer(i % n + 1));
        json_object_update_new(run, run_json(measure_of(c, who, i % n, budget)));
        json_array_append_new(list, run);
    }
    return list;
}

static json_t *point_json(const curve *c, int contender, int budget)
{
    const point *p = &c->points[contender][budget];
    return json_pack("{s:f, s:f, s:f, s:f, s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o}", "budget",
                     ldexp(c->options.seconds, budget), "cpu_seconds", p->cpu_seconds, "native_spp",
                     p->native_spp, "effective_spp", p->effective_spp, "correlation_1",
                     lf_bench_number(p->correlation[0]), "correlation_10",
                     lf_bench_number(p->correlation[1]), "rel_mse", lf_interval_json(p->rel_mse),
                     "worst_view", lf_interval_json(p->worst_view), "equal_time_ratio",
                     lf_interval_json(p->equal_time), "equal_error_ratio",
                     lf_interval_json(p->equal_error), "equal_error_beyond", p->beyond, "runs",
                     runs_json(c, contender, budget));
}

static json_t *contender_json(const curve *c, int contender)
{
    const lf_contender *who = &c->contenders[contender];
    const cost *spent = &c->costs[contender];
    json_t *points = json_array();
    for (int b = 0; b < c->n_budgets; b++)
        json_array_append_new(points, point_json(c, contender, b));
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "integrator", who->integrator,
                     "estimator", lf_estimator_name(who->estimator), "slope",
                     lf_interval_json(spent->slope), "path_us", lf_bench_number(spent->path_us),
                     "shift_ns", lf_bench_number(spent->shift_ns), "lookup_ns",
                     lf_bench_number(spent->lookup_ns), "contributions_per_path",
                     lf_bench_number(spent->contributions_per_path), "escape_share",
                     lf_bench_number(spent->escape_share), "budgets", points);
}

static json_t *curve_json(const curve *c)
{
    json_t *object = lf_trial_json(&c->trial, &c->options);
    json_t *list = json_array();
    for (int i = 0; i < c->n_contenders; i++)
        json_array_append_new(list, contender_json(c, i));
    json_object_set_new(object, "confidence", json_real(CONFIDENCE));
    json_object_set_new(object, "contenders", list);
    return object;
}

static void print_ratio(lf_interval ratio, bool beyond)
{
    fputs("   ", stdout);
    lf_bench_put(stdout, 6, 2, ratio.estimate);
    fputs(beyond ? "*" : "", stdout);
    if (isfinite(ratio.low))
        printf(" (%.2f .. %.2f)", ratio.low, ratio.high);
}

static void print_points(const curve *c, int contender)
{
    for (int b = 0; b < c->n_budgets; b++) {
        const point *p = &c->points[contender][b];
        printf("%-10s %-5s %7.2f  ", c->contenders[contender].integrator,
               lf_estimator_name(c->contenders[contender].estimator), p->cpu_seconds);
        lf_bench_put_short(stdout, 9, 3, p->rel_mse.estimate);
        lf_bench_put_short(stdout, 10, 3, p->rel_mse.low);
        fputs(" .. ", stdout);
        lf_bench_put_short(stdout, -9, 3, p->rel_mse.high);
        lf_bench_put_short(stdout, 10, 3, p->worst_view.estimate);
        printf(" %7.2f %6.2f", p->native_spp, p->effective_spp / p->native_spp);
        lf_bench_put(stdout, 7, 2, p->correlation[0]);
        lf_bench_put(stdout, 7, 2, p->correlation[1]);
        if (contender > 0) {
            print_ratio(p->equal_time, false);
            print_ratio(p->equal_error, p->beyond);
        }
        putchar('\n');
    }
}

/* Why numbers are missing. */
static void print_notes(const curve *c)
{
    double without = 0;
    int of = 0;
    bool beyond = false, error = false, ratio = false, correlation = false;
    for (int i = 0; i < c->n_contenders * c->n_budgets; i++) {
        const int who = i / c->n_budgets;
        const point *p = &c->points[who][i % c->n_budgets];
        of = p->without > without ? who : of;
        without = fmax(without, p->without);
        beyond |= p->beyond;
        error |= !isfinite(p->rel_mse.estimate) || !isfinite(p->worst_view.estimate);
        ratio |=
            who > 0 && !(isfinite(p->equal_time.estimate) && isfinite(p->equal_error.estimate));
        correlation |= !isfinite(p->correlation[0]) || !isfinite(p->correlation[1]);
    }
    if (beyond)
        printf("* the baseline has no run of this length: its curve is extrapolated, to at most %g "
               "times its time\n",
               LF_BEYOND);
    if (without > LF_NOTABLE_SHARE)
        printf("N/W is undefined for up to %.2g %% of the view pixels of %s: no sample has reached "
               "them, so they show only unscattered light; use a longer --time\n",
               100 * without, c->contenders[of].integrator);
    if (c->options.n_seeds < 2)
        puts("- intervals: need at least two seeds (--seeds)");
    else if (error)
        puts("- relMSE: not above the error of the reference in some run; raise --reference-spp or "
             "--reference-time");
    if (ratio && c->options.n_seeds >= 2)
        printf("- ratios: an error is not above the error of the reference, or the baseline needs "
               "over %g times its longest run (--budgets)\n",
               LF_BEYOND);
    if (correlation)
        printf("- correlations: none of the %d views are this far apart, or no error exceeds the "
               "error of the reference\n",
               c->trial.settings.camera.n_views);
}

static void print_table(const curve *c)
{
    lf_trial_print(&c->trial, &c->options);
    printf("every run renders a new film; 95 %% intervals over the seeds, Student's t on "
           "logarithms\n"
           "eff = effective per native spp; corr = error correlation between views 1 and 10 "
           "apart; ratios against %s %s\n\n"
           "                    CPU s     relMSE  (95 %%)                worst view native    "
           "eff  corr1 corr10    equal time             equal error\n",
           c->contenders[0].integrator, lf_estimator_name(c->contenders[0].estimator));
    for (int i = 0; i < c->n_contenders; i++)
        print_points(c, i);
    printf(
        "\n                   path us   shift ns  look-up ns  contributions/path  escape share    "
        "slope\n");
    for (int i = 0; i < c->n_contenders; i++) {
        const cost *spent = &c->costs[i];
        printf("%-10s %-5s", c->contenders[i].integrator,
               lf_estimator_name(c->contenders[i].estimator));
        lf_bench_put(stdout, 10, 2, spent->path_us);
        lf_bench_put(stdout, 11, 1, spent->shift_ns);
        lf_bench_put(stdout, 12, 1, spent->lookup_ns);
        lf_bench_put(stdout, 20, 3, spent->contributions_per_path);
        lf_bench_put(stdout, 14, 3, spent->escape_share);
        lf_bench_put(stdout, 9, 3, spent->slope.estimate);
        if (isfinite(spent->slope.low))
            printf(" (%.3f .. %.3f)", spent->slope.low, spent->slope.high);
        putchar('\n');
    }
    print_notes(c);
}

static char *plot_data(const curve *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs("# CPU seconds, relMSE, low, high\n", out);
    for (int i = 0; i < c->n_contenders; i++) {
        for (int b = 0; b < c->n_budgets; b++) {
            const point *p = &c->points[i][b];
            fprintf(out, "%.6g %.6g %.6g %.6g\n", p->cpu_seconds, p->rel_mse.estimate,
                    p->rel_mse.low, p->rel_mse.high);
        }
        fputs("\n\n", out);
    }
    return fclose(out) == 0 ? text : NULL;
}

static char *plot_commands(const curve *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs("set logscale xy\nset format y '10^{%L}'\nset xlabel 'CPU seconds'\nset ylabel 'relMSE, "
          "mean over the views'\nplot ",
          out);
    for (int i = 0; i < c->n_contenders; i++)
        fprintf(out, "%sdata index %d with yerrorlines pointtype %d title '%s %s'", i ? ", " : "",
                i, 5 + 2 * i, c->contenders[i].integrator,
                lf_estimator_name(c->contenders[i].estimator));
    return fclose(out) == 0 ? text : NULL;
}

static lf_status plot(const curve *c, lf_error *err)
{
    char *data = plot_data(c);
    char *commands = plot_commands(c);
    lf_status status = data && commands ? lf_bench_plot(c->plot, data, commands, err)
                                        : lf_error_set(err, LF_E_NOMEM, c->plot, "out of memory");
    free(data);
    free(commands);
    return status;
}

static lf_status report(const curve *c, lf_error *err)
{
    lf_status status = LF_OK;
    if (!lf_trial_is_quiet(&c->options))
        print_table(c);
    if (c->options.json)
        status = lf_bench_write_json(c->options.json, curve_json(c), err);
    if (status == LF_OK && c->options.csv)
        status = lf_bench_write_csv(c->options.csv, all_runs(c), err);
    return status == LF_OK && c->plot ? plot(c, err) : status;
}

static lf_status run(curve *c, lf_pool *pool, lf_error *err)
{
    lf_budget budgets[LF_MAX_BUDGETS] = {0};
    lf_status status = lf_trial_open(&c->trial, c->options.operand, &c->options, pool, err);
    for (int b = 0; b < c->n_budgets; b++)
        budgets[b].cpu_seconds = ldexp(c->options.seconds, b);
    c->measures =
        lf_calloc((size_t)c->n_contenders * (size_t)c->options.n_seeds * (size_t)c->n_budgets,
                  sizeof *c->measures);
    if (status == LF_OK && !c->measures)
        status = lf_error_set(err, LF_E_NOMEM, c->options.operand, "out of memory");
    if (status == LF_OK)
        status = lf_trial_reference(&c->trial, &c->options, err);
    if (status == LF_OK)
        status = lf_trial_all(&c->trial, c->contenders, c->n_contenders, &c->options, budgets,
                              c->n_budgets, c->measures, err);
    if (status == LF_OK) {
        analyse(c);
        status = report(c, err);
    }
    lf_free(c->measures);
    lf_trial_close(&c->trial);
    return status;
}

int lf_bench_curve(int argc, char **argv)
{
    curve c = {
        .options = {.seconds = 1,
                    .n_seeds = 8,
                    .reference = {"mvpt", LF_ESTIMATOR_CV},
                    .reference_spp = 128,
                    .epsilon = 1e-2},
        .contenders = {{"vpt", LF_ESTIMATOR_MWIS}, {"mvpt", LF_ESTIMATOR_MWIS}},
        .n_contenders = 2,
        .n_budgets = 5,
    };
    const lf_trial_command command = {"curve", "SCENE", table, print_help, take, &c};
    lf_pool *pool = NULL;
    lf_error err = {0};
    bool done = false;
    if (lf_trial_parse(&command, argc, argv, &c.options, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_bench_plot_begin(c.plot);
    lf_status status = lf_bench_pool(c.options.common.threads, &pool, &err);
    if (status == LF_OK)
        status = run(&c, pool, &err);
    lf_pool_destroy(pool);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
