/* quiltbench papers FOLDER: the estimators of the papers beside ours (docs/developer/papers.md), on
 * the kinds of scenes of their figures, all in turns in one run. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "bench/bench.h"
#include "bench/trial.h"
#include "render/papers/papers.h"

/* Pixels beside a place where what is seen jumps by more than this from a view to the next, in
 * pixels, are a silhouette. */
#define SILHOUETTE_STEP 0.25f

/* Of fewer a standard error says nothing. */
#define FEW_SEEDS 4

/* kind: which figures of the papers it stands for. */
static const struct scene {
    const char *name, *file, *kind;
    int max_depth; /* 0: the scene's own */
} scenes[] = {
    {"cloud-1", "cloud.json", "2021, bunny cloud, 1 bounce", 1},
    {"cloud-7", "cloud.json", "2021, bunny cloud, 7 bounces", 7},
    {"cloud", "cloud.json", "2022, Figures 4, 8 to 11", 0},
    {"cloud-g085", "bench/cloud-g085.json", "2022, Table 1, forward scattering", 0},
    {"cloud-mesh", "bench/cloud-mesh.json", "2022, Figure 5 and the dragon", 0},
    {"mixed-cubes", "bench/mixed-cubes.json", "2022, overlapping media", 0},
    {"meshes-diffuse", "bench/meshes-diffuse.json", "2019, Figures 5 and 8", 0},
    {"meshes-glossy", "bench/meshes-glossy.json", "2019, Figure 10", 0},
};

/* The first is what others are held against. */
static const struct member {
    lf_contender who;
    const char *selection; /* NULL: it takes none */
    const char *colour;    /* of its bars: families are shades */
} members[] = {
    {{"vpt", LF_ESTIMATOR_MWIS}, NULL, NULL},
    {{"mvpt2022", LF_ESTIMATOR_MWIS}, "tv", "#08519c"},
    {{"mvpt2022", LF_ESTIMATOR_MWIS}, "partition", "#3182bd"},
    {{"mvpt2022", LF_ESTIMATOR_MWIS}, "none", "#6baed6"},
    {{"mismvpt", LF_ESTIMATOR_MIS}, NULL, "#9ecae1"},
    {{"amvpt2022", LF_ESTIMATOR_MWIS}, "none", "#756bb1"},
    {{"amv2019", LF_ESTIMATOR_MWIS}, NULL, "#bcbddc"},
    {{"restir", LF_ESTIMATOR_MIS}, NULL, "#31a354"},
    {{"mvrestir", LF_ESTIMATOR_MIS}, NULL, "#a1d99b"},
    {{"mvpt", LF_ESTIMATOR_MWIS}, NULL, "#e6550d"},
    {{"mvpt", LF_ESTIMATOR_CV}, NULL, "#fdae6b"},
};

enum {
    N_SCENES = sizeof scenes / sizeof scenes[0],
    N_MEMBERS = sizeof members / sizeof members[0]
};

/* What a member came to on a scene, seed by seed. */
typedef struct result {
    bool refused; /* error says why */
    lf_error error;
    double rel_mse[LF_MAX_SEEDS], paths[LF_MAX_SEEDS], cpu[LF_MAX_SEEDS];
    double off[LF_MAX_SEEDS]; /* mean of e */
    double silhouettes[LF_MAX_SEEDS], flicker[LF_MAX_SEEDS];
    double native[LF_MAX_SEEDS];                   /* samples a view pixel */
    double without[LF_MAX_SEEDS];                  /* share of view pixels that have no N/W */
    double path_us, path_contributions, effective; /* of the last seed */
} result;

typedef struct study {
    lf_trial_options options;
    const char *scenes, *markdown, *plot;
    lf_pool *pool;
    result results[N_SCENES][N_MEMBERS];
    bool chosen[N_SCENES];
    double reference_off[N_SCENES]; /* mean of the reference's own e */
} study;

/* --------------------------------------------------------------------------------- arguments -- */

enum { OPTION_SCENES = LF_TRIAL_OPTION_OWN, OPTION_MARKDOWN, OPTION_PLOT };

static const struct option table[] = {
    LF_TRIAL_OPTIONS_LONG,
    {"scenes", required_argument, NULL, OPTION_SCENES},
    {"markdown", required_argument, NULL, OPTION_MARKDOWN},
    {"plot", required_argument, NULL, OPTION_PLOT},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench papers FOLDER [options]\n"
           "Compare the estimators of the papers with ours on the scenes in FOLDER "
           "(build/scenes). Runs alternate.\n\n"
           "  --scenes LIST             measure only these scenes:");
    for (int i = 0; i < N_SCENES; i++)
        printf("%s%s", i % 5 == 0 ? "\n                            " : " ", scenes[i].name);
    printf("\n"
           "  --time SECONDS            CPU time per run (8)\n"
           "  --seeds N                 runs per estimator (4)\n"
           "  --markdown FILE           also write the table to FILE\n"
           "  --plot PREFIX             plot the error at equal time to PREFIX.svg and "
           "PREFIX.png with gnuplot\n"
           "Without --reference-spp and --reference-time, the reference takes as long as 12 "
           "runs.\n\n");
    lf_trial_print_help();
}

static const char *scene_at(int i)
{
    return i < N_SCENES ? scenes[i].name : NULL;
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    study *s = context;
    if (code == OPTION_SCENES) {
        s->scenes = text;
        return lf_trial_check_names("--scenes", text, scene_at, err);
    }
    *(code == OPTION_MARKDOWN ? &s->markdown : &s->plot) = text;
    return code == OPTION_MARKDOWN ? lf_trial_check_markdown(text, err) : LF_OK;
}

/* -------------------------------------------------------------------------------------- runs -- */

static int selection_of(const struct member *member)
{
    int i = 0;
    while (member->selection && strcmp(lf_selection_name(i), member->selection) != 0)
        i++;
    return i;
}

static double mean_of(const float *values, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++)
        sum += (double)values[i];
    return sum / (double)n;
}

static bool jumps(float a, float b)
{
    return isnan(a) != isnan(b) || fabsf(a - b) > SILHOUETTE_STEP;
}

/* relMSE, the reference's own subtracted, of the pixels at silhouettes; NaN: there are none. */
static double error_at_silhouettes(const lf_trial *trial)
{
    const int width = trial->settings.width;
    double sum = 0.0;
    size_t n = 0;
    for (size_t at = 0; at + 1 < trial->n / 3; at++) {
        if ((int)(at % (size_t)width) == width - 1 ||
            !jumps(trial->steps[at], trial->steps[at + 1]))
            continue;
        for (size_t k = 3 * at; k < 3 * at + 6; k++)
            sum += (double)trial->picture[k] * (double)trial->picture[k] -
                   (double)trial->noise[k] * (double)trial->noise[k];
        n += 6;
    }
    return n > 0 ? sum / (double)n : (double)NAN;
}

static void note(const lf_trial *trial, const lf_contender *who, const lf_measure *measure,
                 int seed, result *out)
{
    const double paths = (double)measure->stats.base_paths;
    out->rel_mse[seed] = measure->rel_mse;
    out->paths[seed] = paths;
    out->cpu[seed] = measure->cpu_seconds;
    out->off[seed] = mean_of(trial->picture, trial->n);
    out->silhouettes[seed] = error_at_silhouettes(trial);
    out->flicker[seed] = measure->flicker - measure->reference_flicker;
    out->native[seed] = measure->stats.native_spp_mean;
    out->without[seed] = lf_without_ratio(trial, who, measure);
    out->path_us = 1e6 * measure->cpu_seconds / paths;
    out->path_contributions = (double)measure->stats.contributions / paths;
    out->effective = measure->stats.effective_spp_mean / measure->stats.native_spp_mean;
}

/* A member that does not take the scene is told so in its row. */
static lf_status run_member(study *s, lf_trial *trial, int scene, int member, int seed,
                            lf_error *err)
{
    result *out = &s->results[scene][member];
    const lf_budget budget = {.cpu_seconds = s->options.seconds};
    lf_measure measure = {0};
    if (out->refused)
        return LF_OK;
    trial->settings.choices.of[LF_PAPERS_SELECTION] = selection_of(&members[member]);
    lf_status status =
        lf_trial_run(trial, &members[member].who, s->options.common.seed + (uint64_t)seed, &budget,
                     &measure, err);
    if (status == LF_E_ARG) {
        out->refused = true;
        out->error = *err;
        return LF_OK;
    }
    if (status == LF_OK)
        note(trial, &members[member].who, &measure, seed, out);
    return status;
}

static lf_status run_all(study *s, lf_trial *trial, int scene, lf_error *err)
{
    lf_status status = lf_trial_reference(trial, &s->options, err);
    s->reference_off[scene] = status == LF_OK ? mean_of(trial->noise, trial->n) : 0.0;
    for (int i = 0; i < s->options.n_seeds * N_MEMBERS && status == LF_OK; i++) {
        const int seed = i / N_MEMBERS;
        status = run_member(s, trial, scene, (i + seed) % N_MEMBERS, seed, err);
    }
    return status;
}

static lf_status run_scene(study *s, int scene, lf_error *err)
{
    lf_trial trial = {0};
    char *path = lf_path_join(s->options.operand, scenes[scene].file);
    lf_status status = path ? lf_trial_open(&trial, path, &s->options, s->pool, err)
                            : lf_error_set(err, LF_E_NOMEM, "papers", "out of memory");
    if (status == LF_OK) {
        trial.steps = lf_calloc(trial.n / 3, sizeof *trial.steps);
        if (scenes[scene].max_depth > 0 && s->options.common.max_depth == 0)
            trial.settings.max_depth = scenes[scene].max_depth;
        status = trial.steps ? run_all(s, &trial, scene, err)
                             : lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    lf_trial_close(&trial);
    lf_free(path);
    return status;
}

/* ------------------------------------------------------------------------------------ answer -- */

/* What is read of the seeds of a member: medians of ratios to the first member. */
typedef struct summary {
    lf_spread equal_time, equal_paths, silhouettes, flicker;
    double off, z;          /* the whole picture's mean, in units of e, and in standard errors */
    double cost;            /* of a path, in those of the first member */
    double native, without; /* medians: samples a view pixel, share of them without N/W */
} summary;

static lf_spread ratios(const double *base, const double *base_by, const double *ours,
                        const double *ours_by, int n)
{
    double all[LF_MAX_SEEDS] = {0};
    for (int i = 0; i < n; i++)
        all[i] = base[i] * base_by[i] / (ours[i] * ours_by[i]);
    return lf_spread_of(all, n);
}

static summary summary_of(const study *s, int scene, int member)
{
    const result *base = &s->results[scene][0], *own = &s->results[scene][member];
    const int n = s->options.n_seeds;
    double mean = 0.0, variance = s->reference_off[scene] * s->reference_off[scene];
    for (int i = 0; i < n; i++)
        mean += own->off[i] / n;
    for (int i = 0; i < n && n > 1; i++)
        variance += (own->off[i] - mean) * (own->off[i] - mean) / (n * (n - 1.0));
    return (summary){
        .equal_time = ratios(base->rel_mse, base->cpu, own->rel_mse, own->cpu, n),
        .equal_paths = ratios(base->rel_mse, base->paths, own->rel_mse, own->paths, n),
        .silhouettes = ratios(base->silhouettes, base->cpu, own->silhouettes, own->cpu, n),
        .flicker = ratios(base->flicker, base->cpu, own->flicker, own->cpu, n),
        .off = mean,
        .z = n >= FEW_SEEDS ? mean / sqrt(variance) : (double)NAN,
        .cost = own->path_us / base->path_us,
        .native = lf_spread_of(own->native, n).median,
        .without = lf_spread_of(own->without, n).median,
    };
}

static void write_head(FILE *out)
{
    fputs("| scene | estimator | equal time: median (low .. high) | equal paths | silhouettes, "
          "equal time | flicker, equal time | bias of the mean (z) | cost per path | "
          "contributions per path | effective / native | native spp | pixels without N/W |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|---|\n",
          out);
}

static void write_name(FILE *out, const struct member *member)
{
    fprintf(out, "%s, %s", member->who.integrator, lf_estimator_name((int)member->who.estimator));
    if (member->selection)
        fprintf(out, ", %s", member->selection);
}

/* Else the reference is too rough. */
static bool tells(double ratio)
{
    return isfinite(ratio) && ratio > 0.0;
}

static void write_ratio(FILE *out, double value)
{
    if (tells(value))
        fprintf(out, " %.2f |", value);
    else
        fputs(" - |", out);
}

static void write_row(FILE *out, const study *s, int scene, int member)
{
    const result *r = &s->results[scene][member];
    fprintf(out, "| %s | ", scenes[scene].name);
    write_name(out, &members[member]);
    if (r->refused) {
        fprintf(out, " | refused: %s | | | | | | | | | |\n", r->error.what);
        return;
    }
    const summary m = summary_of(s, scene, member);
    if (tells(m.equal_time.low))
        fprintf(out, " | %.2f (%.2f .. %.2f) |", m.equal_time.median, m.equal_time.low,
                m.equal_time.high);
    else
        fputs(" | - |", out);
    write_ratio(out, m.equal_paths.median);
    write_ratio(out, m.silhouettes.median);
    write_ratio(out, m.flicker.median);
    fprintf(out, " %+.2f %%", 100.0 * m.off);
    if (isfinite(m.z))
        fprintf(out, " (%.1f)", m.z);
    else
        fputs(" (-)", out);
    fprintf(out, " | %.2f | %.2f | %.1f | %.2f |", m.cost, r->path_contributions, r->effective,
            m.native);
    if (m.without > 0.0)
        fprintf(out, " %.2g %% |\n", 100.0 * m.without);
    else
        fputs(" |\n", out);
}

/* What is to be known of the rows, below them. */
static void write_notes(FILE *out, const study *s)
{
    bool without = false, missing = false;
    for (int i = 0; i < N_SCENES * N_MEMBERS; i++) {
        const int scene = i / N_MEMBERS, member = i % N_MEMBERS;
        if (!s->chosen[scene] || s->results[scene][member].refused)
            continue;
        const summary m = summary_of(s, scene, member);
        without |= m.without > LF_NOTABLE_SHARE;
        missing |= !tells(m.equal_time.low) || !tells(m.equal_paths.median) ||
                   !tells(m.silhouettes.median) || !tells(m.flicker.median);
    }
    fputc('\n', out);
    if (without)
        fputs("* Pixels without N/W: no sample with a positive weight has reached them. They show "
              "only unscattered light. A row with many of them says nothing about the estimator: "
              "use a longer --time.\n",
              out);
    if (s->options.n_seeds < FEW_SEEDS)
        fprintf(out, "* (-): z needs at least %d seeds (--seeds).\n", FEW_SEEDS);
    if (missing)
        fputs("* -: no ratio. An error is not above the error of the reference (--reference-time), "
              "or the scene has no silhouettes or no visible parallax.\n",
              out);
}

static json_t *row_json(const study *s, int scene, int member)
{
    const result *r = &s->results[scene][member];
    json_t *object =
        json_pack("{s:s, s:s, s:s, s:s, s:s}", "scene", scenes[scene].name, "kind",
                  scenes[scene].kind, "integrator", members[member].who.integrator, "estimator",
                  lf_estimator_name((int)members[member].who.estimator), "selection",
                  members[member].selection ? members[member].selection : "");
    if (r->refused) {
        json_object_set_new(object, "refused", json_string(r->error.what));
        return object;
    }
    const summary m = summary_of(s, scene, member);
    const struct {
        const char *name;
        double value;
    } numbers[] = {
        {"equal_time", m.equal_time.median},
        {"equal_time_low", m.equal_time.low},
        {"equal_time_high", m.equal_time.high},
        {"equal_paths", m.equal_paths.median},
        {"silhouettes", m.silhouettes.median},
        {"flicker", m.flicker.median},
        {"mean_off", m.off},
        {"z", m.z},
        {"rel_mse", lf_spread_of(r->rel_mse, s->options.n_seeds).median},
        {"path_us", r->path_us},
        {"path_contributions", r->path_contributions},
        {"effective_over_native", r->effective},
        {"native_spp", m.native},
        {"pixels_without_ratio", m.without},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        json_object_set_new(object, numbers[i].name, lf_bench_number(numbers[i].value));
    return object;
}

/* What there is to draw of a member on a scene; else 0. */
static double drawn(const study *s, int scene, int member)
{
    if (!s->chosen[scene] || s->results[scene][member].refused)
        return 0.0;
    const double ratio = summary_of(s, scene, member).equal_time.median;
    return tells(ratio) ? ratio : 0.0;
}

/* Bars are as wide as one of a scene's present members, so that those that are refused leave no
 * gap; scenes are GAP apart. places: where the bars of a scene begin; returns where all end. */
#define GAP 2
static int place_scenes(const study *s, int places[N_SCENES + 1])
{
    int at = 0;
    for (int scene = 0; scene < N_SCENES; scene++) {
        places[scene] = at;
        int n = 0;
        for (int i = 1; i < N_MEMBERS; i++)
            n += drawn(s, scene, i) > 0.0;
        at += n > 0 ? n + GAP : 0;
    }
    return places[N_SCENES] = at;
}

/* A block a member that has bars, a line a bar: its left and right end, the ratio, the scene. */
static char *plot_data(const study *s, const int *places)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    for (int i = 1; out && i < N_MEMBERS; i++) {
        bool any = false;
        for (int scene = 0; scene < N_SCENES; scene++) {
            int at = places[scene];
            for (int k = 1; k < i; k++)
                at += drawn(s, scene, k) > 0.0;
            const double ratio = drawn(s, scene, i);
            if (ratio > 0.0)
                fprintf(out, "%d %d %g %s\n", at, at + 1, ratio, scenes[scene].name);
            any = any || ratio > 0.0;
        }
        fputs(any ? "\n\n" : "", out);
    }
    if (out)
        fclose(out);
    return text;
}

static bool has_bars(const study *s, int member)
{
    bool any = false;
    for (int scene = 0; scene < N_SCENES; scene++)
        any = any || drawn(s, scene, member) > 0.0;
    return any;
}

/* A string of gnuplot; a long name in two lines. */
static void write_label(FILE *out, const char *name)
{
    const char *dash = strlen(name) > 8 ? strchr(name, '-') : NULL;
    const int n = dash ? (int)(dash + 1 - name) : 0;
    fprintf(out, "\"%.*s%s%s\"", n, name, dash ? "\\n" : "", name + n);
}

/* Names under the middle of their bars. */
static void write_tics(FILE *out, const int *places)
{
    const char *comma = "";
    fputs("set xtics scale 0 (", out);
    for (int scene = 0; scene < N_SCENES; scene++) {
        const int width = places[scene + 1] - places[scene] - GAP;
        if (width <= 0)
            continue;
        fputs(comma, out);
        write_label(out, scenes[scene].name);
        fprintf(out, " %g", places[scene] + 0.5 * width);
        comma = ", ";
    }
    fputs(")\n", out);
}

/* Bars from 1, where an estimator is as good as the first. */
static void write_plot(FILE *out, const study *s, const int *places)
{
    fputs("set style fill solid 0.8\nset logscale y\nset key outside top center horizontal\n"
          "set ylabel 'relMSE x time: vpt over the estimator'\nset grid noxtics\nset bmargin 3\n",
          out);
    fprintf(out, "set xrange [%d:%d]\n", -GAP / 2 - 1, places[N_SCENES] - GAP / 2 + 1);
    write_tics(out, places);
    fputs("plot 1 with lines linecolor rgb 'black' linewidth 2 notitle", out);
    for (int i = 1, block = 0; i < N_MEMBERS; i++) {
        if (!has_bars(s, i))
            continue;
        fprintf(out,
                ", data index %d using 1:3:1:2:($3<1?$3:1):($3<1?1:$3) with boxxyerror title '",
                block++);
        write_name(out, &members[i]);
        fprintf(out, "' linecolor rgb '%s'", members[i].colour);
    }
}

static lf_status plot(const study *s, lf_error *err)
{
    int places[N_SCENES + 1];
    (void)place_scenes(s, places);
    char *data = plot_data(s, places), *commands = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&commands, &size);
    if (out) {
        write_plot(out, s, places);
        fclose(out);
    }
    lf_status status = data && commands ? lf_bench_plot(s->plot, data, commands, err)
                                        : lf_error_set(err, LF_E_NOMEM, s->plot, "out of memory");
    free(data);
    free(commands);
    return status;
}

static lf_status write_files(const study *s, lf_error *err)
{
    char *text = NULL;
    size_t size = 0;
    json_t *list = json_array();
    FILE *out = open_memstream(&text, &size);
    if (out)
        write_head(out);
    for (int i = 0; i < N_SCENES * N_MEMBERS && out; i++)
        if (s->chosen[i / N_MEMBERS]) {
            write_row(out, s, i / N_MEMBERS, i % N_MEMBERS);
            json_array_append_new(list, row_json(s, i / N_MEMBERS, i % N_MEMBERS));
        }
    if (out) {
        write_notes(out, s);
        fclose(out);
    }
    json_t *object =
        json_pack("{s:o, s:i, s:i, s:i, s:i, s:f, s:o}", "machine", lf_bench_machine(), "threads",
                  lf_pool_threads(s->pool), "width", s->options.common.view_width, "height",
                  s->options.common.view_height, "seeds", s->options.n_seeds, "cpu_seconds",
                  s->options.seconds, "rows", list);
    lf_status status = s->markdown ? lf_bench_write_text(s->markdown, text, err) : LF_OK;
    if (status == LF_OK && s->options.json)
        status = lf_bench_write_json(s->options.json, json_incref(object), err);
    if (status == LF_OK && s->options.csv)
        status = lf_bench_write_csv(s->options.csv, json_incref(list), err);
    json_decref(object);
    free(text);
    return status == LF_OK && s->plot ? plot(s, err) : status;
}

static lf_status run(study *s, lf_error *err)
{
    const bool quiet = lf_trial_is_quiet(&s->options);
    lf_status status = LF_OK;
    if (!quiet) {
        printf("%dx%d pixels per view, %d seeds, %g CPU seconds per run, %d threads; ratios: "
               "relMSE x time of %s over that of the estimator\n\n",
               s->options.common.view_width, s->options.common.view_height, s->options.n_seeds,
               s->options.seconds, lf_pool_threads(s->pool), members[0].who.integrator);
        write_head(stdout);
    }
    for (int i = 0; i < N_SCENES && status == LF_OK; i++) {
        s->chosen[i] = lf_trial_names(s->scenes, scenes[i].name);
        if (!s->chosen[i])
            continue;
        status = run_scene(s, i, err);
        for (int k = 0; k < N_MEMBERS && status == LF_OK && !quiet; k++)
            write_row(stdout, s, i, k);
        fflush(stdout);
    }
    if (status == LF_OK && !quiet)
        write_notes(stdout, s);
    return status == LF_OK ? write_files(s, err) : status;
}

int lf_bench_papers(int argc, char **argv)
{
    lf_error err = {0};
    bool done = false;
    study *s = lf_calloc(1, sizeof *s);
    if (!s) {
        lf_error_set(&err, LF_E_NOMEM, "papers", "out of memory");
        return lf_bench_fail(&err);
    }
    s->options = (lf_trial_options){.common = {.view_width = 24, .view_height = 32},
                                    .reference = {"mvpt", LF_ESTIMATOR_CV},
                                    .seconds = 8,
                                    .n_seeds = 4,
                                    .epsilon = 1e-2};
    const lf_trial_command command = {"papers", "FOLDER", table, print_help, take, s};
    lf_status status = lf_trial_parse(&command, argc, argv, &s->options, &done, &err);
    if (status == LF_OK && s->options.common.choices.given[LF_PAPERS_SELECTION])
        status =
            lf_error_set(&err, LF_E_ARG, "--selection",
                         "cannot be used here; each estimator of this table has its own selection");
    int code = status == LF_OK ? LF_EXIT_OK : lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (status == LF_OK && !done) {
        if (s->options.reference_spp == 0 && !(s->options.reference_seconds > 0))
            s->options.reference_seconds = 6 * s->options.seconds;
        lf_bench_plot_begin(s->plot);
        status = lf_bench_pool(s->options.common.threads, &s->pool, &err);
        if (status == LF_OK)
            status = run(s, &err);
        code = status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
    }
    lf_pool_destroy(s->pool);
    lf_free(s);
    return code;
}
