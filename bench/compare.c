/* quiltbench compare SCENE: the error of two ways to render after equal CPU time, over several seeds, taken in turns so that
 * a machine that slows down slows both. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/metrics.h"
#include "daemon/options.h"
#include "daemon/output.h"
#include "daemon/render_job.h"

#define MAX_SEEDS 64
#define REFERENCE_SEED UINT64_C(0x5eed0000)

/* An integrator and the estimator that answers from its film. */
typedef struct contender {
    const char *integrator;
    lf_estimator estimator;
} contender;

typedef struct arguments {
    lf_options options;
    const char *scene, *json;
    contender ours, baseline, reference;
    double seconds; /* CPU, a run */
    int n_seeds;
    int reference_spp;
    double epsilon;
    double min_ratio; /* 0 = not asked for */
} arguments;

/* One run: what it took and how far it came. */
typedef struct outcome {
    double cpu_seconds, rel_mse; /* the reference's own error subtracted */
    double native_spp, effective_spp;
} outcome;

typedef struct comparison {
    const arguments *arguments;
    lf_scene *scene;
    lf_pool *pool;
    lf_render_settings settings;
    lf_layout layout;
    size_t n; /* floats of all views */
    float *reference, *picture;
    double reference_error; /* relMSE of the reference itself */
    double reference_cpu;
    outcome ours[MAX_SEEDS], baseline[MAX_SEEDS];
} comparison;

/* ------------------------------------------------------------------------------------------------------ arguments -- */

enum {
    OPTION_TIME = LF_OPTION_OWN,
    OPTION_SEEDS,
    OPTION_OURS,
    OPTION_BASELINE,
    OPTION_REFERENCE,
    OPTION_REFERENCE_SPP,
    OPTION_EPSILON,
    OPTION_MIN_RATIO,
    OPTION_JSON,
};

static const struct option table[] = {
    LF_OPTIONS_LONG("calibration"),
    {"time", required_argument, NULL, OPTION_TIME},
    {"seeds", required_argument, NULL, OPTION_SEEDS},
    {"ours", required_argument, NULL, OPTION_OURS},
    {"baseline", required_argument, NULL, OPTION_BASELINE},
    {"reference", required_argument, NULL, OPTION_REFERENCE},
    {"reference-spp", required_argument, NULL, OPTION_REFERENCE_SPP},
    {"epsilon", required_argument, NULL, OPTION_EPSILON},
    {"min-ratio", required_argument, NULL, OPTION_MIN_RATIO},
    {"json", required_argument, NULL, OPTION_JSON},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench compare SCENE [options]\n"
           "relMSE (mean over the views) of two integrators after equal CPU time, everything included; runs take turns.\n\n"
           "  --time SECONDS            CPU time of one run (10)\n"
           "  --seeds N                 runs of each (8)\n"
           "  --ours NAME:ESTIMATOR     (mvpt:mwis)\n"
           "  --baseline NAME:ESTIMATOR (vpt:mis)\n"
           "  --reference NAME:ESTIMATOR  renders the reference, twice, so that its own error is known (mvpt:cv)\n"
           "  --reference-spp N         of each of the two (128)\n"
           "  --epsilon E               of relMSE (0.01)\n"
           "  --min-ratio R             exit 1 when the median ratio is below this\n"
           "  --json FILE               everything as JSON (- for stdout)\n" LF_OPTIONS_HELP_VIEWS
           "  --calibration FILE     aspect and cone of a panel\n"
           "  --sampler NAME         owen (default) or independent\n"
           "  --max-depth N          longest path, in vertices after the camera (the scene's)\n"
           "  --threads N            worker threads (all CPUs)\n"
           "  --seed S               of the first run (1)\n"
           "  --help                 this text\n");
}

static lf_status parse_contender(const char *option, const char *text, contender *out, lf_error *err)
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
        *out = (contender){parsed.integrator, parsed.estimator};
    return status;
}

static lf_status take_number(arguments *a, int code, const char *text, lf_error *err)
{
    int64_t number = 0;
    bool seeds = code == OPTION_SEEDS;
    lf_status status = lf_parse_int(seeds ? "--seeds" : "--reference-spp", text, 1, seeds ? MAX_SEEDS : 1 << 24, &number, err);

    if (status == LF_OK)
        *(seeds ? &a->n_seeds : &a->reference_spp) = (int)number;
    return status;
}

static lf_status take(arguments *a, int code, const char *text, lf_error *err)
{
    switch (code) {
    case OPTION_TIME:
        return lf_parse_double("--time", text, 1e-2, 1e6, &a->seconds, err);
    case OPTION_SEEDS:
    case OPTION_REFERENCE_SPP:
        return take_number(a, code, text, err);
    case OPTION_OURS:
        return parse_contender("--ours", text, &a->ours, err);
    case OPTION_BASELINE:
        return parse_contender("--baseline", text, &a->baseline, err);
    case OPTION_REFERENCE:
        return parse_contender("--reference", text, &a->reference, err);
    case OPTION_EPSILON:
        return lf_parse_double("--epsilon", text, 0, 1e9, &a->epsilon, err);
    case OPTION_MIN_RATIO:
        return lf_parse_double("--min-ratio", text, 0, 1e9, &a->min_ratio, err);
    default:
        a->json = text;
        return LF_OK;
    }
}

static lf_status parse(arguments *a, int argc, char **argv, bool *out_done, lf_error *err)
{
    int code = 0;
    bool taken = false;

    *out_done = false;
    for (;;) {
        lf_status status = lf_options_next(argc, argv, ":", table, &code, err);
        if (status != LF_OK)
            return status;
        if (code == -1)
            break;
        if (code == LF_OPTION_HELP || code == LF_OPTION_VERSION) {
            code == LF_OPTION_HELP ? print_help() : lf_print_version(LF_BENCH_PROGRAM);
            *out_done = true;
            return LF_OK;
        }
        status = lf_options_take(&a->options, code, optarg, &taken, err);
        if (status == LF_OK && !taken)
            status = take(a, code, optarg, err);
        if (status != LF_OK)
            return status;
    }
    if (argc - optind != 1)
        return lf_error_set(err, LF_E_ARG, "compare", "expects one SCENE (see quiltbench compare --help)");
    if (a->options.integrator || a->options.has_estimator || a->options.target_error > 0)
        return lf_error_set(err, LF_E_ARG, "compare", "--ours and --baseline say what to compare, --time for how long");
    a->scene = argv[optind];
    return LF_OK;
}

/* ----------------------------------------------------------------------------------------------------------- runs -- */

/* Renders into c->picture. The clock runs from before the film is made until the picture is there. */
static lf_status render(comparison *c, const contender *who, uint64_t seed, const lf_budget *budget, outcome *out, lf_error *err)
{
    lf_render_settings settings = c->settings;
    lf_renderer *renderer = NULL;
    lf_render_times times;
    lf_render_stats stats;
    double start = lf_time_cpu();

    settings.integrator = who->integrator;
    settings.seed = seed;
    lf_status status = lf_renderer_create(c->scene, &settings, c->pool, &renderer, err);
    if (status != LF_OK)
        return status;
    lf_budget left = *budget;
    if (left.cpu_seconds > 0)
        left.cpu_seconds = fmax(1e-3, left.cpu_seconds - (lf_time_cpu() - start));
    status = lf_render_run(renderer, &left, who->estimator, c->picture, NULL, NULL, NULL, &times);
    out->cpu_seconds = lf_time_cpu() - start;
    lf_renderer_stats(renderer, &stats);
    out->native_spp = stats.native_spp_mean;
    out->effective_spp = stats.effective_spp_mean;
    lf_renderer_destroy(renderer);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, c->arguments->scene, "rendering failed");
}

/* The mean of two independent pictures; half their difference squared is the error of that mean. */
static lf_status render_reference(comparison *c, lf_error *err)
{
    const arguments *a = c->arguments;
    const lf_budget budget = {.passes = (int64_t)a->reference_spp * c->settings.camera.n_views};
    outcome first;
    outcome second;
    lf_status status = render(c, &a->reference, REFERENCE_SEED, &budget, &first, err);

    if (status != LF_OK)
        return status;
    memcpy(c->reference, c->picture, c->n * sizeof(float));
    status = render(c, &a->reference, REFERENCE_SEED + 1, &budget, &second, err);
    if (status != LF_OK)
        return status;
    double sum = 0;
    for (size_t i = 0; i < c->n; i++) {
        double mean = 0.5 * ((double)c->reference[i] + (double)c->picture[i]);
        double half = 0.5 * ((double)c->reference[i] - (double)c->picture[i]);
        sum += half * half / (mean * mean + a->epsilon);
        c->reference[i] = (float)mean;
    }
    c->reference_error = sum / (double)c->n;
    c->reference_cpu = first.cpu_seconds + second.cpu_seconds;
    return LF_OK;
}

static lf_status run_one(comparison *c, const contender *who, uint64_t seed, outcome *out, lf_error *err)
{
    const lf_budget budget = {.cpu_seconds = c->arguments->seconds};
    lf_status status = render(c, who, seed, &budget, out, err);

    if (status == LF_OK)
        out->rel_mse = lf_rel_mse(c->n, c->reference, c->picture, c->arguments->epsilon) - c->reference_error;
    return status;
}

static lf_status run_all(comparison *c, lf_error *err)
{
    const arguments *a = c->arguments;
    bool terminal = isatty(STDERR_FILENO) == 1;
    uint64_t seed = a->options.has_seed ? a->options.seed : 1;
    lf_status status = LF_OK;

    if (terminal)
        fprintf(stderr, "\r" LF_BENCH_PROGRAM ": reference\033[K");
    status = render_reference(c, err);
    for (int i = 0; i < a->n_seeds && status == LF_OK; i++) {
        if (terminal)
            fprintf(stderr, "\r" LF_BENCH_PROGRAM ": seed %d of %d\033[K", i + 1, a->n_seeds);
        bool ours_first = i % 2 == 0;
        for (int turn = 0; turn < 2 && status == LF_OK; turn++) {
            bool ours = ours_first == (turn == 0);
            status = run_one(c, ours ? &a->ours : &a->baseline, seed + (uint64_t)i, ours ? &c->ours[i] : &c->baseline[i], err);
        }
    }
    if (terminal)
        fputs("\r\033[K", stderr);
    return status;
}

/* --------------------------------------------------------------------------------------------------------- answer -- */

typedef struct spread {
    double median, low, high;
} spread;

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a;
    double y = *(const double *)b;

    return (x > y) - (x < y);
}

static spread spread_of(const double *values, int n)
{
    double sorted[MAX_SEEDS];

    memcpy(sorted, values, (size_t)n * sizeof *values);
    qsort(sorted, (size_t)n, sizeof *sorted, compare_doubles);
    return (spread){0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]), sorted[0], sorted[n - 1]};
}

static spread errors_of(const outcome *outcomes, int n)
{
    double values[MAX_SEEDS];

    for (int i = 0; i < n; i++)
        values[i] = outcomes[i].rel_mse;
    return spread_of(values, n);
}

/* Ratio of relMSE x CPU seconds: runs end within a pass of their time, and the error falls as one over it. */
static spread ratios_of(const comparison *c, double *out_ratio)
{
    int n = c->arguments->n_seeds;

    for (int i = 0; i < n; i++)
        out_ratio[i] = c->baseline[i].rel_mse * c->baseline[i].cpu_seconds / (c->ours[i].rel_mse * c->ours[i].cpu_seconds);
    return spread_of(out_ratio, n);
}

static json_t *contender_json(const contender *who, const outcome *outcomes, int n)
{
    spread error = errors_of(outcomes, n);
    json_t *runs = json_array();

    for (int i = 0; i < n; i++)
        json_array_append_new(runs, json_pack("{s:f, s:f, s:f, s:f}", "rel_mse", outcomes[i].rel_mse, "cpu_seconds",
                                              outcomes[i].cpu_seconds, "native_spp", outcomes[i].native_spp, "effective_spp",
                                              outcomes[i].effective_spp));
    return json_pack("{s:s, s:s, s:f, s:f, s:f, s:o}", "integrator", who->integrator, "estimator",
                     lf_estimator_name(who->estimator), "rel_mse_median", error.median, "rel_mse_low", error.low, "rel_mse_high",
                     error.high, "runs", runs);
}

static json_t *comparison_json(const comparison *c)
{
    const arguments *a = c->arguments;
    double ratio[MAX_SEEDS];
    spread ratios = ratios_of(c, ratio);
    json_t *list = json_array();

    for (int i = 0; i < a->n_seeds; i++)
        json_array_append_new(list, json_real(ratio[i]));
    return json_pack("{s:s, s:o, s:i, s:i, s:i, s:i, s:f, s:i, s:f, s:{s:s, s:s, s:i, s:f, s:f}, s:o, s:o, s:f, s:f, s:f, s:o}",
                     "scene", a->scene, "machine", lf_bench_machine(), "threads", lf_pool_threads(c->pool), "views",
                     c->settings.camera.n_views, "width", c->settings.width, "height", c->settings.height, "cpu_seconds",
                     a->seconds, "seeds", a->n_seeds, "epsilon", a->epsilon, "reference", "integrator", a->reference.integrator,
                     "estimator", lf_estimator_name(a->reference.estimator), "spp", 2 * a->reference_spp, "rel_mse",
                     c->reference_error, "cpu_seconds", c->reference_cpu, "ours", contender_json(&a->ours, c->ours, a->n_seeds),
                     "baseline", contender_json(&a->baseline, c->baseline, a->n_seeds), "ratio_median", ratios.median, "ratio_low",
                     ratios.low, "ratio_high", ratios.high, "ratios", list);
}

static void print_contender(const contender *who, const outcome *outcomes, int n)
{
    spread error = errors_of(outcomes, n);
    double cpu = 0;
    double native = 0;
    double effective = 0;

    for (int i = 0; i < n; i++) {
        cpu += outcomes[i].cpu_seconds / n;
        native += outcomes[i].native_spp / n;
        effective += outcomes[i].effective_spp / n;
    }
    printf("%-6s %-6s %12.4g   (%.4g .. %.4g) %10.2f %10.3f %11.2f\n", who->integrator, lf_estimator_name(who->estimator),
           error.median, error.low, error.high, cpu, native, effective);
}

static void print_table(const comparison *c)
{
    const arguments *a = c->arguments;
    double ratio[MAX_SEEDS];
    spread ratios = ratios_of(c, ratio);
    json_t *machine = lf_bench_machine();

    printf("%s: %d views of %dx%d, %g CPU seconds a run, %d seeds, relMSE with epsilon %g\n", a->scene, c->settings.camera.n_views,
           c->settings.width, c->settings.height, a->seconds, a->n_seeds, a->epsilon);
    printf("machine: %s, %d threads\n", json_string_value(json_object_get(machine, "cpu")), lf_pool_threads(c->pool));
    printf("reference: %s %s, 2 x %d spp, its own relMSE %.3g (subtracted), %.1f CPU seconds\n\n", a->reference.integrator,
           lf_estimator_name(a->reference.estimator), a->reference_spp, c->reference_error, c->reference_cpu);
    printf("                relMSE median  (low .. high)          CPU s   native spp  effective\n");
    print_contender(&a->baseline, c->baseline, a->n_seeds);
    print_contender(&a->ours, c->ours, a->n_seeds);
    printf("\nratio at equal time: %.2f (median over seeds; %.2f .. %.2f)\n", ratios.median, ratios.low, ratios.high);
    json_decref(machine);
}

static lf_status report(const comparison *c, lf_error *err)
{
    const arguments *a = c->arguments;
    double ratio[MAX_SEEDS];
    double median = ratios_of(c, ratio).median;
    lf_status status = LF_OK;

    if (!a->json || strcmp(a->json, "-") != 0)
        print_table(c);
    if (a->json) {
        json_t *object = comparison_json(c);
        status = object ? lf_bench_write_json(a->json, object, err) : lf_error_set(err, LF_E_NOMEM, a->json, "out of memory");
        json_decref(object);
    }
    if (status == LF_OK && a->min_ratio > 0 && !(median >= a->min_ratio))
        return lf_error_set(err, LF_E_STATE, a->scene, "the median ratio is %.2f, less than %g", median, a->min_ratio);
    return status;
}

static lf_status prepare(comparison *c, lf_error *err)
{
    const arguments *a = c->arguments;
    lf_calibration calibration;
    lf_status status = lf_scene_load(a->scene, NULL, NULL, &c->scene, err);

    if (status == LF_OK && a->options.calibration)
        status = lf_calibration_load(a->options.calibration, &calibration, err);
    if (status == LF_OK)
        status = lf_resolve_view(&a->options, lf_scene_camera(c->scene), a->options.calibration ? &calibration : NULL, &c->settings,
                                 &c->layout, err);
    if (status != LF_OK)
        return status;
    c->n = (size_t)c->settings.camera.n_views * (size_t)c->settings.width * (size_t)c->settings.height * 3;
    c->reference = lf_calloc(c->n, sizeof(float));
    c->picture = lf_calloc(c->n, sizeof(float));
    if (!c->reference || !c->picture || lf_pool_create(a->options.threads, &c->pool) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, a->scene, "out of memory");
    return LF_OK;
}

int lf_bench_compare(int argc, char **argv)
{
    arguments a = {
        .ours = {"mvpt", LF_ESTIMATOR_MWIS},
        .baseline = {"vpt", LF_ESTIMATOR_MIS},
        .reference = {"mvpt", LF_ESTIMATOR_CV},
        .seconds = 10,
        .n_seeds = 8,
        .reference_spp = 128,
        .epsilon = 1e-2,
    };
    comparison c = {.arguments = &a};
    lf_error err = {0};
    bool done = false;

    if (parse(&a, argc, argv, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_status status = prepare(&c, &err);
    if (status == LF_OK)
        status = run_all(&c, &err);
    if (status == LF_OK)
        status = report(&c, &err);
    lf_pool_destroy(c.pool);
    lf_scene_unref(c.scene);
    lf_free(c.reference);
    lf_free(c.picture);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
