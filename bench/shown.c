/* quiltbench shown SCENE: what the reconstruction is worth. The picture that people see against the
 * unfiltered one after the same CPU time or passes: errors, the worst tile, the change from view to
 * view, whether what it says of its own error is true (docs/developer/reconstruction.md), and what
 * an eye sees of both through a panel's lenses. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "bench/eyes.h"
#include "bench/trial.h"

enum { UNFILTERED, SHOWN, N_CONTENDERS };

/* What eyes see of one run. */
typedef struct seen {
    double rel_mse[N_CONTENDERS], flicker[N_CONTENDERS];
    double frame_change; /* of the reconstructed picture, when its rendering goes on */
} seen;

typedef struct arguments {
    lf_trial_options options;
    double budgets[LF_MAX_BUDGETS];
    int n_budgets;
    bool by_passes; /* budgets are passes, not CPU seconds */
    bool eye;       /* --eye */
    lf_trial trial;
    lf_measure *measures; /* [budget][seed][contender] */
    double *tiles;        /* one set of tiles a contender */
    double *tile_ratios;  /* [budget][seed][worst, mean] */
    lf_eyes *eyes;        /* NULL without --eye */
    seen *seen;           /* [budget][seed], with --eye */
    seen *seen_now;       /* the run's */
    int who;              /* of the picture that comes next */
} arguments;

/* --------------------------------------------------------------------------------- arguments -- */

enum { OPTION_BUDGETS = LF_TRIAL_OPTION_OWN, OPTION_PASSES, OPTION_EYE };
/* A pass of each half more: the next picture that a display would show. */
enum { LATER_PASSES = 2 };

static const struct option table[] = {
    LF_TRIAL_OPTIONS_LONG,
    {"budgets", required_argument, NULL, OPTION_BUDGETS},
    {"passes", required_argument, NULL, OPTION_PASSES},
    {"eye", no_argument, NULL, OPTION_EYE},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench shown SCENE [options]\n"
           "Compare the denoised image with the unfiltered image at equal CPU time (or passes), "
           "denoising included. Results are medians over the seeds (min .. max).\n\n"
           "  --budgets LIST            CPU seconds in ascending order (0.6,2,5,15)\n"
           "  --passes LIST             budgets in passes, in ascending order, instead of CPU "
           "seconds\n"
           "  --eye                     also measure what an eye sees through the lenses of a "
           "panel (--calibration)\n"
           "  --seeds N                 runs per budget (4)\n");
    lf_trial_print_help();
}

static lf_status take_budgets(arguments *a, const char *option, const char *text, lf_error *err)
{
    const double least = a->by_passes ? 1 : 1e-2;
    a->n_budgets = 0;
    for (const char *at = text; at;) {
        char number[32];
        const size_t n = strcspn(at, ",");
        double *out = &a->budgets[a->n_budgets];
        if (a->n_budgets == LF_MAX_BUDGETS)
            return lf_error_set(err, LF_E_ARG, option, "expects at most %d budgets",
                                LF_MAX_BUDGETS);
        snprintf(number, sizeof number, "%.*s", (int)(n < sizeof number ? n : sizeof number - 1),
                 at);
        lf_status status = lf_parse_double(option, number, least, 1e6, out, err);
        if (status != LF_OK)
            return status;
        if (a->by_passes && *out != floor(*out))
            return lf_error_set(err, LF_E_ARG, option, "expects whole numbers");
        if (a->n_budgets > 0 && *out <= out[-1])
            return lf_error_set(err, LF_E_ARG, option, "expects numbers in ascending order");
        a->n_budgets++;
        at = at[n] ? at + n + 1 : NULL;
    }
    return LF_OK;
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    arguments *a = context;
    if (code == OPTION_EYE) {
        a->eye = true;
        return LF_OK;
    }
    a->by_passes = code == OPTION_PASSES;
    return take_budgets(a, a->by_passes ? "--passes" : "--budgets", text, err);
}

/* --------------------------------------------------------------------------------- measuring -- */

static lf_measure *measure_of(const arguments *a, int budget, int seed, int who)
{
    return &a->measures[(budget * a->options.n_seeds + seed) * N_CONTENDERS + who];
}

static size_t n_tiles(const lf_trial *trial)
{
    return (size_t)trial->n_tiles_across * (size_t)trial->n_tiles_down *
           (size_t)trial->settings.camera.n_views;
}

/* Sum over the views of a place's tile. */
static double at_place(const arguments *a, const double *tiles, int place)
{
    const int places = a->trial.n_tiles_across * a->trial.n_tiles_down;
    double sum = 0;
    for (int view = 0; view < a->trial.settings.camera.n_views; view++)
        sum += tiles[view * places + place];
    return sum;
}

/* Where less than 1 % of the mean error lies there is nothing to judge. */
static void judge_tiles(const arguments *a, const lf_measure *m, double *out_worst,
                        double *out_mean)
{
    const int places = a->trial.n_tiles_across * a->trial.n_tiles_down;
    const double floor = 0.01 * m[UNFILTERED].rel_mse * a->trial.settings.camera.n_views;
    double sum = 0;
    int n = 0;
    *out_worst = 0;
    for (int place = 0; place < places; place++) {
        const double unfiltered = at_place(a, m[UNFILTERED].tiles, place);
        if (!(unfiltered > floor))
            continue;
        const double ratio = fmax(0, at_place(a, m[SHOWN].tiles, place)) / unfiltered;
        *out_worst = fmax(*out_worst, ratio);
        sum += ratio;
        n++;
    }
    *out_mean = n > 0 ? sum / n : (double)NAN;
}

/* The reconstructed picture comes first, then the later one, then the unfiltered one. */
static void look(void *context, const float *picture, bool is_later)
{
    arguments *a = context;
    if (is_later)
        a->seen_now->frame_change = lf_eyes_change(a->eyes, picture);
    else
        lf_eyes_look(a->eyes, picture, &a->seen_now->rel_mse[a->who],
                     &a->seen_now->flicker[a->who]);
}

/* By CPU time: the fit is made when the passes' time is over, so it is taken off beforehand as it
 * was before; the unfiltered picture gets what was then spent. *fit_seconds is renewed. */
static lf_status run_pair(arguments *a, int budget, int seed, double *fit_seconds, lf_error *err)
{
    const lf_contender who = {"mvpt", LF_ESTIMATOR_MWIS};
    const int run = budget * a->options.n_seeds + seed;
    const uint64_t number = a->options.common.seed + (uint64_t)run;
    lf_measure *m = measure_of(a, budget, seed, 0);
    lf_budget left = {.reconstructed = true};
    if (a->by_passes)
        left.passes = (int64_t)a->budgets[budget];
    else
        left.cpu_seconds = fmax(1e-2, a->budgets[budget] - *fit_seconds);
    m[UNFILTERED].tiles = a->tiles;
    m[SHOWN].tiles = a->tiles + n_tiles(&a->trial);
    a->seen_now = a->eyes ? &a->seen[run] : NULL;
    a->who = SHOWN;
    lf_status status = lf_trial_run(&a->trial, &who, number, &left, &m[SHOWN], err);
    if (status != LF_OK)
        return status;
    *fit_seconds = m[SHOWN].answer_cpu_seconds;
    left.reconstructed = false;
    if (!a->by_passes)
        left.cpu_seconds = m[SHOWN].cpu_seconds;
    a->who = UNFILTERED;
    status = lf_trial_run(&a->trial, &who, number, &left, &m[UNFILTERED], err);
    double *ratios = a->tile_ratios + run * 2;
    judge_tiles(a, m, &ratios[0], &ratios[1]);
    return status;
}

static lf_status run_all(arguments *a, lf_error *err)
{
    lf_status status = LF_OK;
    for (int b = 0; b < a->n_budgets && status == LF_OK; b++) {
        double fit_seconds = 0.3 * a->budgets[b];
        for (int s = 0; s < a->options.n_seeds && status == LF_OK; s++)
            status = run_pair(a, b, s, &fit_seconds, err);
    }
    return status;
}

/* --------------------------------------------------------------------------------- reporting -- */

typedef double (*number_fn)(const arguments *a, int budget, int seed);

static double cpu_of(const arguments *a, int budget, int seed)
{
    return measure_of(a, budget, seed, SHOWN)->cpu_seconds;
}
static double passes_of(const arguments *a, int budget, int seed)
{
    return measure_of(a, budget, seed, SHOWN)->passes;
}
static double unfiltered_of(const arguments *a, int budget, int seed)
{
    return measure_of(a, budget, seed, UNFILTERED)->rel_mse;
}
static double shown_of(const arguments *a, int budget, int seed)
{
    return measure_of(a, budget, seed, SHOWN)->rel_mse;
}
/* Over the true error; NaN where the reference is too rough to tell it. */
static double over_shown(const arguments *a, int budget, int seed, double x)
{
    const double shown = shown_of(a, budget, seed);
    return shown > 0 ? x / shown : (double)NAN;
}
static double gain_of(const arguments *a, int budget, int seed)
{
    return over_shown(a, budget, seed, unfiltered_of(a, budget, seed));
}
static double worst_of(const arguments *a, int budget, int seed)
{
    return a->tile_ratios[(budget * a->options.n_seeds + seed) * 2];
}
static double mean_of(const arguments *a, int budget, int seed)
{
    return a->tile_ratios[(budget * a->options.n_seeds + seed) * 2 + 1];
}
static double stated_of(const arguments *a, int budget, int seed)
{
    return over_shown(a, budget, seed, measure_of(a, budget, seed, SHOWN)->shown_error);
}
static double flicker_of(const arguments *a, int budget, int seed)
{
    const lf_measure *m = measure_of(a, budget, seed, 0);
    return m[UNFILTERED].flicker / m[SHOWN].flicker;
}
static double flicker_noise_of(const arguments *a, int budget, int seed)
{
    const lf_measure *m = measure_of(a, budget, seed, SHOWN);
    return m->flicker / m->reference_flicker;
}

static const seen *seen_of(const arguments *a, int budget, int seed)
{
    return &a->seen[budget * a->options.n_seeds + seed];
}
static double eye_unfiltered_of(const arguments *a, int budget, int seed)
{
    return seen_of(a, budget, seed)->rel_mse[UNFILTERED];
}
static double eye_shown_of(const arguments *a, int budget, int seed)
{
    return seen_of(a, budget, seed)->rel_mse[SHOWN];
}
static double eye_flicker_unfiltered_of(const arguments *a, int budget, int seed)
{
    return seen_of(a, budget, seed)->flicker[UNFILTERED];
}
static double eye_flicker_of(const arguments *a, int budget, int seed)
{
    return seen_of(a, budget, seed)->flicker[SHOWN];
}
static double eye_frame_of(const arguments *a, int budget, int seed)
{
    return seen_of(a, budget, seed)->frame_change;
}

/* What is told of a budget: one line here is one column and one key. The last ones are of --eye. */
static const struct column {
    const char *name, *key;
    number_fn number;
} columns[] = {
    {"CPU s", "cpu_seconds", cpu_of},
    {"passes", "passes", passes_of},
    {"unfiltered", "unfiltered", unfiltered_of},
    {"shown", "shown", shown_of},
    {"gain", "gain", gain_of},
    {"worst tile", "worst_tile", worst_of},
    {"mean tile", "mean_tile", mean_of},
    {"stated/true", "stated", stated_of},
    {"less flicker", "flicker_gain", flicker_of},
    {"flicker/reference", "flicker_noise", flicker_noise_of},
    {"eye unfiltered", "eye_unfiltered", eye_unfiltered_of},
    {"eye shown", "eye_shown", eye_shown_of},
    {"eye flicker unfiltered", "eye_flicker_unfiltered", eye_flicker_unfiltered_of},
    {"eye flicker shown", "eye_flicker", eye_flicker_of},
    {"eye frame change", "eye_frame_change", eye_frame_of},
};
enum { N_EYE_COLUMNS = 5, N_COLUMNS = sizeof columns / sizeof columns[0] };

static int n_columns(const arguments *a)
{
    return a->eye ? N_COLUMNS : N_COLUMNS - N_EYE_COLUMNS;
}

static lf_spread spread_of(const arguments *a, int column, int budget)
{
    double values[LF_MAX_SEEDS];
    for (int s = 0; s < a->options.n_seeds; s++)
        values[s] = columns[column].number(a, budget, s);
    return lf_spread_of(values, a->options.n_seeds);
}

/* Runs whose bound is not below the truth. */
static int count_bounds(const arguments *a, int budget)
{
    int n = 0;
    for (int s = 0; s < a->options.n_seeds; s++)
        n += measure_of(a, budget, s, SHOWN)->shown_bound >= shown_of(a, budget, s);
    return n;
}

static void print_table(const arguments *a)
{
    lf_trial_print(&a->trial, &a->options);
    putchar('|');
    for (int c = 0; c < n_columns(a); c++)
        printf(" %s |", columns[c].name);
    puts(" bound holds |");
    for (int c = 0; c <= n_columns(a); c++)
        printf("|---");
    puts("|");
    for (int b = 0; b < a->n_budgets; b++) {
        putchar('|');
        for (int c = 0; c < n_columns(a); c++) {
            const lf_spread spread = spread_of(a, c, b);
            const double numbers[] = {spread.median, spread.low, spread.high};
            static const char *const between[] = {" ", " (", " .. "};
            for (int i = 0; i < 3; i++) {
                fputs(between[i], stdout);
                lf_bench_put_short(stdout, 0, 3, numbers[i]);
            }
            printf(") |");
        }
        printf(" %d of %d |\n", count_bounds(a, b), a->options.n_seeds);
    }
}

static json_t *budget_json(const arguments *a, int budget)
{
    json_t *object = json_pack("{s:f, s:i}", "budget", a->budgets[budget], "bound_holds",
                               count_bounds(a, budget));
    for (int c = 0; c < n_columns(a); c++) {
        json_t *list = json_array();
        for (int s = 0; s < a->options.n_seeds; s++)
            json_array_append_new(list, lf_bench_number(columns[c].number(a, budget, s)));
        json_object_set_new(object, columns[c].key, list);
    }
    return object;
}

/* A line of CSV each. */
static json_t *all_runs(const arguments *a)
{
    json_t *list = json_array();
    for (int i = 0; i < a->n_budgets * a->options.n_seeds; i++) {
        const int budget = i / a->options.n_seeds, seed = i % a->options.n_seeds;
        json_t *run = json_pack("{s:f, s:i}", "budget", a->budgets[budget], "run", seed + 1);
        for (int c = 0; c < n_columns(a); c++)
            json_object_set_new(run, columns[c].key,
                                lf_bench_number(columns[c].number(a, budget, seed)));
        json_array_append_new(list, run);
    }
    return list;
}

static lf_status report(const arguments *a, lf_error *err)
{
    if (!lf_trial_is_quiet(&a->options))
        print_table(a);
    lf_status status =
        a->options.csv ? lf_bench_write_csv(a->options.csv, all_runs(a), err) : LF_OK;
    if (status != LF_OK || !a->options.json)
        return status;
    json_t *object = lf_trial_json(&a->trial, &a->options), *list = json_array();
    for (int b = 0; b < a->n_budgets; b++)
        json_array_append_new(list, budget_json(a, b));
    json_object_set_new(object, "budgets_of", json_string(a->by_passes ? "passes" : "cpu_seconds"));
    json_object_set_new(object, "budgets", list);
    return lf_bench_write_json(a->options.json, object, err);
}

static lf_status prepare(arguments *a, lf_error *err)
{
    const size_t n_runs = (size_t)a->n_budgets * (size_t)a->options.n_seeds;
    a->trial.steps = lf_calloc(a->trial.n / 3, sizeof *a->trial.steps);
    a->measures = lf_calloc(n_runs * N_CONTENDERS, sizeof *a->measures);
    a->tile_ratios = lf_calloc(n_runs * 2, sizeof *a->tile_ratios);
    a->tiles = lf_calloc(N_CONTENDERS * n_tiles(&a->trial), sizeof *a->tiles);
    return a->trial.steps && a->measures && a->tile_ratios && a->tiles
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, a->options.operand, "out of memory");
}

/* The two renderings of the reference are its mean and what that is off by. */
static lf_status open_eyes(arguments *a, lf_error *err)
{
    lf_trial *trial = &a->trial;
    const char *panel = a->options.common.calibration;
    const size_t n_runs = (size_t)a->n_budgets * (size_t)a->options.n_seeds;
    lf_calibration calibration;
    lf_status status = LF_OK;
    lf_calibration_portrait(&calibration);
    if (panel)
        status = lf_calibration_load(panel, &calibration, err);
    if (status == LF_OK)
        status =
            lf_eyes_create(&calibration, &trial->settings, lf_scene_film_settings(trial->scene),
                           trial->epsilon, trial->pool, &a->eyes, err);
    if (status != LF_OK)
        return status;
    float *halves[2] = {lf_calloc(trial->n, sizeof(float)), lf_calloc(trial->n, sizeof(float))};
    a->seen = lf_calloc(n_runs, sizeof *a->seen);
    if (!halves[0] || !halves[1] || !a->seen)
        status = lf_error_set(err, LF_E_NOMEM, a->options.operand, "out of memory");
    for (size_t i = 0; i < trial->n && status == LF_OK; i++) {
        const float r = trial->reference[i],
                    off = trial->noise[i] * sqrtf(r * r + (float)trial->epsilon);
        halves[0][i] = r + off;
        halves[1][i] = r - off;
    }
    if (status == LF_OK)
        lf_eyes_set_reference(a->eyes, halves[0], halves[1]);
    lf_free(halves[0]);
    lf_free(halves[1]);
    trial->look = look;
    trial->look_context = a;
    trial->later_passes = LATER_PASSES;
    return status;
}

static lf_status run(arguments *a, lf_pool *pool, lf_error *err)
{
    lf_status status = lf_trial_open(&a->trial, a->options.operand, &a->options, pool, err);
    if (status == LF_OK)
        status = prepare(a, err);
    if (status == LF_OK)
        status = lf_trial_reference(&a->trial, &a->options, err);
    a->trial.same_films = a->by_passes;
    if (status == LF_OK && a->eye)
        status = open_eyes(a, err);
    if (status == LF_OK)
        status = run_all(a, err);
    if (status == LF_OK)
        status = report(a, err);
    lf_free(a->measures);
    lf_free(a->tile_ratios);
    lf_free(a->tiles);
    lf_free(a->seen);
    lf_eyes_destroy(a->eyes);
    lf_trial_close(&a->trial);
    return status;
}

int lf_bench_shown(int argc, char **argv)
{
    arguments a = {.options = {.common = {.view_width = 210, .view_height = 280},
                               .n_seeds = 4,
                               .reference = {.integrator = "mvpt", .estimator = LF_ESTIMATOR_CV},
                               .reference_spp = 4,
                               .epsilon = 1e-2},
                   .budgets = {0.6, 2, 5, 15},
                   .n_budgets = 4};
    const lf_trial_command command = {"shown", "SCENE", table, print_help, take, &a};
    lf_pool *pool = NULL;
    lf_error err = {0};
    bool done = false;
    if (lf_trial_parse(&command, argc, argv, &a.options, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    lf_status status = lf_bench_pool(a.options.common.threads, &pool, &err);
    if (status == LF_OK)
        status = run(&a, pool, &err);
    lf_pool_destroy(pool);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
