/* quiltbench table FOLDER: equal-time ratios of mvpt to vpt for the kinds of scenes of Fraboni et
 * al. 2022, Table 1, as a light field and as a lenticular print, each compared with the promise in
 * docs/lab/performance.md. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "bench/bench.h"
#include "bench/trial.h"

enum { BASELINE, OURS, N_CONTENDERS };
enum { FIELD_VIEWS = 45, LENTICULAR_VIEWS = 10 };

#define TILE_CONFIDENCE 0.99

/* must and aim are for the light field; 0 = none. The tile's are for the worst tile's lower bound,
 * if there are enough seeds for one. */
static const struct scene {
    const char *name, *file;
    double must, aim, tile_must, tile_aim;
    lf_contender reference;
} scenes[] = {
    {"cloud", "cloud.json", 20, 36, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"cloud-dense", "bench/cloud-dense.json", 22, 40, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"cloud-g060", "bench/cloud-g060.json", 15, 32, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"cloud-g085", "bench/cloud-g085.json", 9, 22, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"cloud-thin", "bench/cloud-thin.json", 14, 30, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"meshes-diffuse", "bench/meshes-diffuse.json", 10, 28, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"meshes-glossy-ground",
     "bench/meshes-glossy-ground.json",
     4,
     10,
     0,
     0,
     {"mvpt", LF_ESTIMATOR_CV}},
    {"meshes-glossy-ground-sky",
     "bench/meshes-glossy-ground-sky.json",
     4,
     7,
     0,
     0,
     {"mvpt", LF_ESTIMATOR_CV}},
    {"meshes-glossy-sky", "bench/meshes-glossy-sky.json", 1.2, 2, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"cloud-mesh", "bench/cloud-mesh.json", 0, 0, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"mixed-cubes", "bench/mixed-cubes.json", 0, 0, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"cloud-g098", "bench/cloud-g098.json", 0.97, 2, 0.8, 1, {"mvpt", LF_ESTIMATOR_CV}},
    {"meshes-glossy", "bench/meshes-glossy.json", 6, 16, 0.8, 1, {"mvpt", LF_ESTIMATOR_CV}},
    /* nothing is shared behind a mirror, so the baseline is the better reference */
    {"meshes-mirror", "bench/meshes-mirror.json", 1.8, 3, 0.8, 1, {"vpt", LF_ESTIMATOR_MIS}},
    /* caustics of mirrors and glass have no must, because those that a camera sees in the mirror or
     * glass are in a few far too bright pixels */
    {"room-shade", "bench/room-shade.json", 15, 40, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"room-window", "bench/room-window.json", 15, 40, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"fog-post", "bench/fog-post.json", 10, 30, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"textured-sky", "bench/textured-sky.json", 5, 10, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"glass-sun", "bench/glass-sun.json", 0, 0, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"mirror-sun", "bench/mirror-sun.json", 0, 0, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"rough-mirror-sun", "bench/rough-mirror-sun.json", 10, 30, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
    {"fire", "fire.json", 12, 24, 0, 0, {"mvpt", LF_ESTIMATOR_CV}},
};

enum { N_SCENES = sizeof scenes / sizeof scenes[0] };

/* One scene with one number of views. */
typedef struct row {
    const struct scene *scene;
    int views;
    double ratios[LF_MAX_SEEDS];
    lf_spread ratio;
    /* 95 % interval of the ratio */
    lf_interval interval;
    /* CPU seconds per run */
    double seconds;
    double rel_mse[N_CONTENDERS], native[N_CONTENDERS], effective[N_CONTENDERS]; /* medians */
    /* tiles of a position, over all views */
    lf_tile_bound tiles;
    lf_tile_bound view_tiles; /* tiles of single views */
    double reference_error;
} row;

typedef struct arguments {
    lf_trial_options options;
    lf_contender contenders[N_CONTENDERS];
    const char *scenes; /* NULL = all */
    const char *markdown;
} arguments;

/* --------------------------------------------------------------------------------- arguments -- */

enum { OPTION_SCENES = LF_TRIAL_OPTION_OWN, OPTION_OURS, OPTION_BASELINE, OPTION_MARKDOWN };

static const struct option table[] = {
    LF_TRIAL_OPTIONS_LONG,
    {"scenes", required_argument, NULL, OPTION_SCENES},
    {"ours", required_argument, NULL, OPTION_OURS},
    {"baseline", required_argument, NULL, OPTION_BASELINE},
    {"markdown", required_argument, NULL, OPTION_MARKDOWN},
    {NULL, 0, NULL, 0},
};

static void print_help(void)
{
    printf("Usage: quiltbench table FOLDER [options]\n"
           "Measure equal-time ratios of relMSE on the scenes in FOLDER (build/scenes), with 45 "
           "views and with 10 views.\n\n"
           "  --scenes LIST             measure only these scenes:");
    for (int i = 0; i < N_SCENES; i++)
        printf("%s%s", i % 5 == 0 ? "\n                            " : " ", scenes[i].name);
    printf("\n"
           "  --time SECONDS            CPU time per run with 45 views; with 10 views in "
           "proportion (4)\n"
           "  --seeds N                 runs per integrator (8)\n"
           "  --ours NAME:ESTIMATOR     integrator to test (mvpt:mwis)\n"
           "  --baseline NAME:ESTIMATOR integrator to compare with (vpt:mwis)\n"
           "  --markdown FILE           also write the table to FILE\n"
           "With --views N, only N views are measured. Without --reference-spp and "
           "--reference-time, the reference takes as long as 12 runs.\n\n");
    lf_trial_print_help();
}

static const char *scene_at(int i)
{
    return i < N_SCENES ? scenes[i].name : NULL;
}

static lf_status take(void *context, int code, const char *text, lf_error *err)
{
    arguments *a = context;
    switch (code) {
    case OPTION_OURS:
        return lf_contender_parse("--ours", text, &a->contenders[OURS], err);
    case OPTION_BASELINE:
        return lf_contender_parse("--baseline", text, &a->contenders[BASELINE], err);
    case OPTION_SCENES:
        a->scenes = text;
        return lf_trial_check_names("--scenes", text, scene_at, err);
    default:
        a->markdown = text;
        return lf_trial_check_markdown(text, err);
    }
}

/* -------------------------------------------------------------------------------------- rows -- */

static double median_of(const lf_measure *measures, int n, size_t offset)
{
    double values[LF_MAX_SEEDS];
    for (int i = 0; i < n; i++)
        memcpy(&values[i], (const char *)&measures[i] + offset, sizeof values[i]);
    return lf_spread_of(values, n).median;
}

/* Ratios of tiles: of every view, and of the mean over the views at each position. */
static lf_status judge_tiles(const lf_trial *trial, const lf_measure *measures, int n_seeds,
                             row *out, lf_error *err)
{
    int places = trial->n_tiles_across * trial->n_tiles_down;
    int all = places * out->views;
    double *of_views = lf_calloc((size_t)n_seeds * (size_t)all, sizeof(double));
    double *of_places = lf_calloc((size_t)n_seeds * (size_t)places, sizeof(double));
    lf_status status =
        of_views && of_places ? LF_OK : lf_error_set(err, LF_E_NOMEM, trial->name, "out of memory");
    for (int s = 0; s < n_seeds && status == LF_OK; s++) {
        const lf_measure *base = &measures[s];
        const lf_measure *ours = &measures[n_seeds + s];
        double time = base->cpu_seconds / ours->cpu_seconds;
        for (int place = 0; place < places; place++) {
            double sum[N_CONTENDERS] = {0};
            for (int tile = place; tile < all; tile += places) {
                sum[BASELINE] += base->tiles[tile];
                sum[OURS] += ours->tiles[tile];
                of_views[s * all + tile] = base->tiles[tile] / ours->tiles[tile] * time;
            }
            of_places[s * places + place] = sum[BASELINE] / sum[OURS] * time;
        }
    }
    if (status == LF_OK) {
        out->tiles =
            lf_worst_tile(of_places, n_seeds, places, TILE_CONFIDENCE, out->scene->tile_must);
        out->view_tiles =
            lf_worst_tile(of_views, n_seeds, all, TILE_CONFIDENCE, out->scene->tile_must);
    }
    lf_free(of_views);
    lf_free(of_places);
    return status;
}

static lf_status summarise(const lf_trial *trial, const lf_measure *measures, int n_seeds, row *out,
                           lf_error *err)
{
    for (int i = 0; i < n_seeds; i++)
        out->ratios[i] = lf_measure_ratio(&measures[i], &measures[n_seeds + i]);
    out->ratio = lf_spread_of(out->ratios, n_seeds);
    out->interval = lf_log_interval(out->ratios, n_seeds, 0.95);
    out->reference_error = trial->reference_error;
    for (int c = 0; c < N_CONTENDERS; c++) {
        const lf_measure *of = measures + (size_t)c * (size_t)n_seeds;
        out->rel_mse[c] = median_of(of, n_seeds, offsetof(lf_measure, rel_mse));
        out->native[c] = median_of(of, n_seeds, offsetof(lf_measure, stats.native_spp_mean));
        out->effective[c] = median_of(of, n_seeds, offsetof(lf_measure, stats.effective_spp_mean));
    }
    return judge_tiles(trial, measures, n_seeds, out, err);
}

static lf_status run_trial(const arguments *a, lf_trial *trial, const lf_trial_options *options,
                           row *out, lf_error *err)
{
    const lf_budget budget = {.cpu_seconds = options->seconds};
    size_t n_runs = (size_t)N_CONTENDERS * (size_t)options->n_seeds;
    size_t n_tiles =
        (size_t)out->views * (size_t)trial->n_tiles_across * (size_t)trial->n_tiles_down;
    lf_measure *measures = lf_calloc(n_runs, sizeof *measures);
    double *tiles = lf_calloc(n_runs * n_tiles, sizeof *tiles);
    lf_status status =
        measures && tiles ? LF_OK : lf_error_set(err, LF_E_NOMEM, trial->name, "out of memory");
    for (size_t i = 0; i < n_runs && status == LF_OK; i++)
        measures[i].tiles = tiles + i * n_tiles;
    if (status == LF_OK)
        status = lf_trial_reference(trial, options, err);
    if (status == LF_OK)
        status =
            lf_trial_all(trial, a->contenders, N_CONTENDERS, options, &budget, 1, measures, err);
    if (status == LF_OK)
        status = summarise(trial, measures, options->n_seeds, out, err);
    lf_free(measures);
    lf_free(tiles);
    return status;
}

static lf_status run_row(const arguments *a, lf_pool *pool, row *out, lf_error *err)
{
    lf_trial_options options = a->options;
    lf_trial trial = {0};
    char *path = lf_path_join(options.operand, out->scene->file);
    options.common.views = out->views;
    options.seconds *= (double)out->views / FIELD_VIEWS;
    out->seconds = options.seconds;
    if (options.reference_spp == 0)
        options.reference_seconds =
            options.reference_seconds > 0 ? options.reference_seconds : 6 * options.seconds;
    if (!options.reference.integrator)
        options.reference = out->scene->reference;
    lf_status status = path ? lf_trial_open(&trial, path, &options, pool, err)
                            : lf_error_set(err, LF_E_NOMEM, "table", "out of memory");
    if (status == LF_OK)
        status = run_trial(a, &trial, &options, out, err);
    lf_trial_close(&trial);
    lf_free(path);
    return status;
}

/* ------------------------------------------------------------------------------------ answer -- */

static bool has_must(const row *r)
{
    return r->views == FIELD_VIEWS && r->scene->must > 0;
}

/* True if the worst tile counts: the scene has a must for it and there are enough seeds. */
static bool has_tiles(const row *r)
{
    return r->scene->tile_must > 0 && r->tiles.worst >= 0;
}

static bool reaches(const row *r, double whole, double tile)
{
    return r->ratio.median >= whole && (!has_tiles(r) || r->tiles.low >= tile);
}

static const char *verdict(const row *r)
{
    if (!has_must(r))
        return "";
    if (reaches(r, r->scene->aim, r->scene->tile_aim))
        return "met, also the aim";
    return reaches(r, r->scene->must, r->scene->tile_must) ? "met" : "not met";
}

static void write_head(FILE *out, const arguments *a)
{
    fprintf(out,
            "| scene | views | equal time: median (low .. high) | 95 %% of the mean | %s relMSE | "
            "effective / native | "
            "worst tile: lower bound (estimate), from %d seeds on | must / aim | "
            "|\n|---|---|---|---|---|---|---|---|---|\n",
            a->contenders[OURS].integrator, LF_TILE_SEEDS);
}

static void write_row(FILE *out, const row *r)
{
    const struct scene *scene = r->scene;
    fprintf(out, "| %s | %d |", scene->name, r->views);
    if (isfinite(r->ratio.low) && isfinite(r->ratio.high))
        fprintf(out, " %.2f (%.2f .. %.2f) |", r->ratio.median, r->ratio.low, r->ratio.high);
    else
        fputs(" - |", out);
    if (isfinite(r->interval.low))
        fprintf(out, " %.2f .. %.2f |", r->interval.low, r->interval.high);
    else
        fputs(" - |", out);
    fprintf(out, " %.3g | %.1f |", r->rel_mse[OURS], r->effective[OURS] / r->native[OURS]);
    if (has_tiles(r))
        fprintf(out, " %.2f (%.2f) |", r->tiles.low, r->tiles.estimate);
    else
        fputs(" |", out);
    if (has_must(r) && has_tiles(r))
        fprintf(out, " %g, tile %g / %g, tile %g |", scene->must, scene->tile_must, scene->aim,
                scene->tile_aim);
    else if (has_must(r))
        fprintf(out, " %g / %g |", scene->must, scene->aim);
    else
        fputs(" |", out);
    fprintf(out, " %s |\n", verdict(r));
}

/* Explains missing numbers. */
static void write_notes(FILE *out, const row *rows, int n_rows)
{
    bool missing = false;
    for (int i = 0; i < n_rows; i++)
        missing |= !isfinite(rows[i].interval.low);
    if (missing)
        fputs("\n"
              "* -: a ratio needs errors above the error of the reference (--reference-time), "
              "and its interval at least two seeds (--seeds).\n",
              out);
}

static json_t *tiles_json(const lf_tile_bound *b)
{
    return json_pack("{s:i, s:o, s:o, s:o, s:i}", "judged", b->n_judged, "worst_low",
                     lf_bench_number(b->low), "worst_estimate", lf_bench_number(b->estimate),
                     "least_estimate", lf_bench_number(b->least), "surely_below_must",
                     b->n_surely_less);
}

static json_t *row_json(const arguments *a, const row *r)
{
    json_t *ratios = json_array();
    for (int i = 0; i < a->options.n_seeds; i++)
        json_array_append_new(ratios, lf_bench_number(r->ratios[i]));
    json_t *object = json_pack(
        "{s:s, s:i, s:f, s:o, s:o, s:o, s:o, s:o, s:f, s:o, s:o, s:s}", "scene", r->scene->name,
        "views", r->views, "cpu_seconds", r->seconds, "ratio_median",
        lf_bench_number(r->ratio.median), "ratio_low", lf_bench_number(r->ratio.low), "ratio_high",
        lf_bench_number(r->ratio.high), "ratio", lf_interval_json(r->interval), "ratios", ratios,
        "reference_rel_mse", r->reference_error, "tiles", tiles_json(&r->tiles), "view_tiles",
        tiles_json(&r->view_tiles), "verdict", verdict(r));
    if (has_must(r))
        json_object_set_new(object, "must",
                            json_pack("{s:f, s:f, s:f, s:f}", "ratio", r->scene->must, "aim",
                                      r->scene->aim, "tile", r->scene->tile_must, "tile_aim",
                                      r->scene->tile_aim));
    for (int c = 0; c < N_CONTENDERS; c++)
        json_object_set_new(
            object, c == OURS ? "ours" : "baseline",
            json_pack("{s:s, s:s, s:f, s:f, s:f}", "integrator", a->contenders[c].integrator,
                      "estimator", lf_estimator_name(a->contenders[c].estimator), "rel_mse_median",
                      r->rel_mse[c], "native_spp", r->native[c], "effective_spp", r->effective[c]));
    return object;
}

static lf_status write_files(const arguments *a, const row *rows, int n_rows, lf_pool *pool,
                             lf_error *err)
{
    char *text = NULL;
    size_t size = 0;
    lf_status status = LF_OK;
    FILE *out = open_memstream(&text, &size);
    json_t *list = json_array();
    for (int i = 0; i < n_rows; i++)
        json_array_append_new(list, row_json(a, &rows[i]));
    json_t *object =
        json_pack("{s:o, s:i, s:i, s:i, s:i, s:f, s:f, s:o}", "machine", lf_bench_machine(),
                  "threads", lf_pool_threads(pool), "width", a->options.common.view_width, "height",
                  a->options.common.view_height, "seeds", a->options.n_seeds, "epsilon",
                  a->options.epsilon, "tile_confidence", TILE_CONFIDENCE, "rows", list);
    if (out) {
        write_head(out, a);
        for (int i = 0; i < n_rows; i++)
            write_row(out, &rows[i]);
        write_notes(out, rows, n_rows);
        fclose(out);
    }
    if (a->markdown)
        status = lf_bench_write_text(a->markdown, text, err);
    if (status == LF_OK && a->options.json)
        status = lf_bench_write_json(a->options.json, json_incref(object), err);
    if (status == LF_OK && a->options.csv)
        status = lf_bench_write_csv(a->options.csv, json_incref(list), err);
    json_decref(object);
    free(text);
    return status;
}

static lf_status run(const arguments *a, row *rows, lf_pool *pool, lf_error *err)
{
    bool quiet = lf_trial_is_quiet(&a->options);
    int kinds[2] = {a->options.common.views ? a->options.common.views : FIELD_VIEWS,
                    LENTICULAR_VIEWS};
    int n_kinds = a->options.common.views ? 1 : 2;
    int n_rows = 0;
    lf_status status = LF_OK;
    if (!quiet) {
        printf("%dx%d pixels per view, %d seeds, %g CPU seconds per run of %d views, %d "
               "threads; ratios of relMSE x CPU seconds, %s %s to %s %s\n\n",
               a->options.common.view_width, a->options.common.view_height, a->options.n_seeds,
               a->options.seconds, FIELD_VIEWS, lf_pool_threads(pool),
               a->contenders[BASELINE].integrator,
               lf_estimator_name(a->contenders[BASELINE].estimator), a->contenders[OURS].integrator,
               lf_estimator_name(a->contenders[OURS].estimator));
        write_head(stdout, a);
        fflush(stdout);
    }
    for (int i = 0; i < N_SCENES * n_kinds && status == LF_OK; i++) {
        const struct scene *scene = &scenes[i / n_kinds];
        if (!lf_trial_names(a->scenes, scene->name))
            continue;
        rows[n_rows] = (row){.scene = scene, .views = kinds[i % n_kinds]};
        status = run_row(a, pool, &rows[n_rows], err);
        if (status == LF_OK && !quiet) {
            write_row(stdout, &rows[n_rows]);
            fflush(stdout);
        }
        n_rows++;
    }
    if (status == LF_OK && !quiet)
        write_notes(stdout, rows, n_rows);
    return status == LF_OK ? write_files(a, rows, n_rows, pool, err) : status;
}

int lf_bench_table(int argc, char **argv)
{
    arguments a = {
        .options = {.common = {.view_width = 60, .view_height = 80},
                    .seconds = 4,
                    .n_seeds = 8,
                    .epsilon = 1e-2},
        .contenders =
            {[BASELINE] = {"vpt", LF_ESTIMATOR_MWIS}, [OURS] = {"mvpt", LF_ESTIMATOR_MWIS}},
    };
    const lf_trial_command command = {"table", "FOLDER", table, print_help, take, &a};
    lf_pool *pool = NULL;
    lf_error err = {0};
    bool done = false;
    if (lf_trial_parse(&command, argc, argv, &a.options, &done, &err) != LF_OK)
        return lf_usage_error(LF_BENCH_PROGRAM, &err);
    if (done)
        return LF_EXIT_OK;
    row *rows = lf_calloc(2 * (size_t)N_SCENES, sizeof *rows);
    lf_status status = rows ? lf_bench_pool(a.options.common.threads, &pool, &err)
                            : lf_error_set(&err, LF_E_NOMEM, "table", "out of memory");
    if (status == LF_OK)
        status = run(&a, rows, pool, &err);
    lf_pool_destroy(pool);
    lf_free(rows);
    return status == LF_OK ? LF_EXIT_OK : lf_bench_fail(&err);
}
