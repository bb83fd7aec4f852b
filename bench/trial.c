#include "bench/trial.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "bench/bench.h"
#include "daemon/output/content.h"

#define REFERENCE_SEED UINT64_C(0x5eed0000)

lf_status lf_trial_open(lf_trial *trial, const char *path, const lf_trial_options *options,
                        lf_pool *pool, lf_error *err)
{
    lf_calibration calibration;
    lf_layout layout;
    const char *panel = options->common.calibration;
    *trial = (lf_trial){.name = path, .pool = pool, .epsilon = options->epsilon};
    lf_status status = lf_scene_load(path, NULL, NULL, &trial->scene, err);
    if (status == LF_OK)
        lf_log_warnings(trial->scene, NULL);
    if (status == LF_OK && panel)
        status = lf_calibration_load(panel, &calibration, err);
    if (status == LF_OK)
        status = lf_resolve_view(&options->common, lf_scene_camera(trial->scene),
                                 panel ? &calibration : NULL, &trial->settings, &layout, err);
    if (status != LF_OK)
        return status;
    const lf_render_settings *settings = &trial->settings;
    trial->n =
        (size_t)settings->camera.n_views * (size_t)settings->width * (size_t)settings->height * 3;
    trial->n_tiles_across = (settings->width + LF_TILE_SIDE - 1) / LF_TILE_SIDE;
    trial->n_tiles_down = (settings->height + LF_TILE_SIDE - 1) / LF_TILE_SIDE;
    trial->reference = lf_calloc(trial->n, sizeof(float));
    trial->noise = lf_calloc(trial->n, sizeof(float));
    trial->picture = lf_calloc(trial->n, sizeof(float));
    if (!trial->reference || !trial->noise || !trial->picture)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    return LF_OK;
}

void lf_trial_close(lf_trial *trial)
{
    lf_scene_unref(trial->scene);
    lf_free(trial->reference);
    lf_free(trial->noise);
    lf_free(trial->picture);
    lf_free(trial->steps);
    *trial = (lf_trial){0};
}

/* --------------------------------------------------------------------------------- measuring -- */

/* The picture becomes its e. */
static int64_t to_errors(lf_trial *trial)
{
    int64_t n_nonfinite = 0;
    for (size_t i = 0; i < trial->n; i++) {
        double r = (double)trial->reference[i];
        double e = ((double)trial->picture[i] - r) / sqrt(r * r + trial->epsilon);
        n_nonfinite += !isfinite(e);
        trial->picture[i] = isfinite(e) ? (float)e : 0;
    }
    return n_nonfinite;
}

/* Where the floats of one row of one view begin. */
static size_t row_at(const lf_trial *trial, int row, int view)
{
    return ((size_t)row * (size_t)trial->settings.camera.n_views + (size_t)view) *
           (size_t)trial->settings.width * 3;
}

/* Sum of e^2 over pixels of a row, without the reference's own. */
static double sum_squares(const lf_trial *trial, size_t first, size_t n_floats)
{
    double sum = 0;
    for (size_t i = first; i < first + n_floats; i++)
        sum += (double)trial->picture[i] * (double)trial->picture[i] -
               (double)trial->noise[i] * (double)trial->noise[i];
    return sum;
}

static int side_of(int tile, int size)
{
    return size - tile * LF_TILE_SIDE < LF_TILE_SIDE ? size - tile * LF_TILE_SIDE : LF_TILE_SIDE;
}

/* Sum of e^2 of one tile of one view; *out_n counts its samples. */
static double sum_tile(const lf_trial *trial, int view, int across, int down, double *out_n)
{
    int width = side_of(across, trial->settings.width);
    int height = side_of(down, trial->settings.height);
    double sum = 0;
    for (int y = 0; y < height; y++)
        sum += sum_squares(
            trial, row_at(trial, down * LF_TILE_SIDE + y, view) + (size_t)across * LF_TILE_SIDE * 3,
            (size_t)width * 3);
    *out_n = 3.0 * width * height;
    return sum;
}

static void measure_errors(const lf_trial *trial, lf_measure *out)
{
    double all = 0;
    size_t tile = 0;
    out->worst_view = -INFINITY;
    for (int view = 0; view < trial->settings.camera.n_views; view++) {
        double sum = 0;
        for (int down = 0; down < trial->n_tiles_down; down++) {
            for (int across = 0; across < trial->n_tiles_across; across++, tile++) {
                double n;
                double of_tile = sum_tile(trial, view, across, down, &n);
                sum += of_tile;
                if (out->tiles)
                    out->tiles[tile] = of_tile / n;
            }
        }
        all += sum;
        out->worst_view =
            fmax(out->worst_view, sum * trial->settings.camera.n_views / (double)trial->n);
    }
    out->rel_mse = all / (double)trial->n;
}

/* Mean correlation of the errors of views `apart`; NaN when there are none, or no error. */
static double correlation(const lf_trial *trial, int apart)
{
    size_t n = (size_t)trial->settings.width * 3;
    int n_pairs = trial->settings.camera.n_views - apart;
    double sum = 0;
    for (int view = 0; view < n_pairs; view++) {
        lf_correlation cross = {0};
        for (int row = 0; row < trial->settings.height; row++) {
            size_t a = row_at(trial, row, view);
            size_t b = row_at(trial, row, view + apart);
            lf_correlation_add(&cross, n, trial->picture + a, trial->picture + b, trial->noise + a,
                               trial->noise + b);
        }
        sum += lf_correlation_value(&cross);
    }
    return n_pairs > 0 ? sum / n_pairs : (double)NAN;
}

/* Mean square of e's change along epipolar lines, where both ends are in the picture. Nearest
 * pixels: between two of them noise would be averaged away. */
static double flicker(const lf_trial *trial, const float *errors)
{
    const int width = trial->settings.width;
    double sum = 0;
    int64_t n = 0;
    for (int row = 0; row < trial->settings.height; row++)
        for (int view = 0; view + 1 < trial->settings.camera.n_views; view++) {
            const size_t here = row_at(trial, row, view), next = row_at(trial, row, view + 1);
            for (int u = 0; u < width; u++) {
                const float to = roundf((float)u + trial->steps[here / 3 + (size_t)u]);
                if (!(to >= 0 && to < (float)width))
                    continue;
                const float *a = errors + here + (size_t)u * 3, *b = errors + next + (size_t)to * 3;
                for (int c = 0; c < 3; c++, n++)
                    sum += (double)(b[c] - a[c]) * (double)(b[c] - a[c]);
            }
        }
    return n > 0 ? sum / (double)n : (double)NAN;
}

static void measure(lf_trial *trial, lf_measure *out)
{
    out->n_nonfinite = to_errors(trial);
    measure_errors(trial, out);
    out->correlation[0] = correlation(trial, 1);
    out->correlation[1] = correlation(trial, 10);
    out->reference_flicker = trial->steps ? flicker(trial, trial->noise) : (double)NAN;
    out->flicker =
        trial->steps ? flicker(trial, trial->picture) - out->reference_flicker : (double)NAN;
}

/* ----------------------------------------------------------------------------------- running -- */

/* A thing at Z moves by a - b/Z (lf_depth), of which two are known. */
static lf_status find_steps(const lf_trial *trial, const lf_renderer *renderer,
                            lf_estimator estimator)
{
    lf_depth depth = {.nearest = 1, .farthest = 2};
    const bool known = lf_scene_depth(trial->scene, &trial->settings, &depth);
    const double b = (depth.farthest_step - depth.nearest_step) /
                     (1 / depth.nearest - 1 / depth.farthest),
                 a = depth.farthest_step + b / depth.farthest;
    lf_status status = lf_renderer_layers(renderer, estimator, LF_LAYER_DEPTH, trial->steps, NULL);
    for (size_t i = 0; i < trial->n / 3; i++) {
        const double z = (double)trial->steps[i];
        trial->steps[i] = known && z > 0 ? (float)(a - b / z) : NAN;
    }
    return status;
}

/* Tells whoever looks of the picture, and of the one after later_passes; the picture stays. */
static lf_status tell(lf_trial *trial, lf_renderer *renderer, bool reconstructed)
{
    if (!trial->look)
        return LF_OK;
    trial->look(trial->look_context, trial->picture, false);
    if (!reconstructed || trial->later_passes <= 0)
        return LF_OK;
    float *later = lf_calloc(trial->n, sizeof *later);
    if (!later)
        return LF_E_NOMEM;
    lf_status status =
        lf_renderer_passes(renderer, NULL, trial->later_passes, false, NULL, NULL, NULL);
    if (status == LF_OK)
        status = lf_renderer_show(renderer, later, NULL);
    if (status == LF_OK)
        trial->look(trial->look_context, later, true);
    lf_free(later);
    return status;
}

/* Renders into trial->picture; with_steps: into trial->steps as well. */
static lf_status render(lf_trial *trial, const lf_contender *who, uint64_t seed,
                        const lf_budget *budget, bool with_steps, lf_measure *out, lf_error *err)
{
    lf_render_settings settings = trial->settings;
    lf_renderer *renderer = NULL;
    lf_render_times times;
    double start = lf_time_cpu();
    settings.integrator = who->integrator;
    lf_choices_fit(&settings.choices, lf_integrator_named(who->integrator)); /* others' */
    settings.seed = seed;
    settings.features = budget->reconstructed || with_steps || trial->same_films;
    lf_status status = lf_renderer_create(trial->scene, &settings, trial->pool, &renderer, err);
    if (status != LF_OK)
        return status;
    lf_budget left = *budget;
    if (left.cpu_seconds > 0)
        left.cpu_seconds = fmax(1e-3, left.cpu_seconds - (lf_time_cpu() - start));
    status =
        lf_render_run(renderer, &left, who->estimator, trial->picture, NULL, NULL, NULL, &times);
    out->cpu_seconds = lf_time_cpu() - start;
    out->answer_cpu_seconds = times.answer_cpu_seconds;
    out->passes = (double)times.passes;
    if (status == LF_OK && with_steps)
        status = find_steps(trial, renderer, who->estimator);
    out->shown_bound = lf_renderer_shown_error(renderer, LF_ERROR_ALPHA, &out->shown_error, NULL);
    lf_renderer_stats(renderer, &out->stats);
    if (status == LF_OK)
        status = tell(trial, renderer, budget->reconstructed);
    lf_renderer_destroy(renderer);
    return status == LF_OK ? LF_OK : lf_error_set(err, status, trial->name, "rendering failed");
}

lf_status lf_trial_run(lf_trial *trial, const lf_contender *who, uint64_t seed,
                       const lf_budget *budget, lf_measure *out, lf_error *err)
{
    lf_budget asked = *budget;
    asked.reconstructed |= trial->settings.features;
    lf_status status = render(trial, who, seed, &asked, false, out, err);
    if (status == LF_OK)
        measure(trial, out);
    return status;
}

lf_status lf_trial_reference(lf_trial *trial, const lf_trial_options *options, lf_error *err)
{
    lf_budget budget = {.cpu_seconds = options->reference_seconds};
    lf_measure halves[2] = {0};
    lf_status status = LF_OK;
    if (!(budget.cpu_seconds > 0))
        budget.passes = (int64_t)options->reference_spp * trial->settings.camera.n_views;
    trial->reference_by = options->reference;
    for (int half = 0; half < 2 && status == LF_OK; half++) {
        status = render(trial, &options->reference, REFERENCE_SEED + (uint64_t)half, &budget,
                        trial->steps && half == 0, &halves[half], err);
        if (half == 0)
            memcpy(trial->reference, trial->picture, trial->n * sizeof(float));
    }
    if (status != LF_OK)
        return status;
    double sum = 0;
    for (size_t i = 0; i < trial->n; i++) {
        double mean = 0.5 * ((double)trial->reference[i] + (double)trial->picture[i]);
        double e = 0.5 * ((double)trial->reference[i] - (double)trial->picture[i]) /
                   sqrt(mean * mean + trial->epsilon);
        trial->noise[i] = (float)e;
        trial->reference[i] = (float)mean;
        sum += e * e;
    }
    trial->reference_error = sum / (double)trial->n;
    trial->reference_cpu = halves[0].cpu_seconds + halves[1].cpu_seconds;
    trial->reference_spp = halves[0].stats.native_spp_mean + halves[1].stats.native_spp_mean;
    return LF_OK;
}

lf_status lf_trial_all(lf_trial *trial, const lf_contender *contenders, int n_contenders,
                       const lf_trial_options *options, const lf_budget *budgets, int n_budgets,
                       lf_measure *out_measures, lf_error *err)
{
    bool terminal = isatty(STDERR_FILENO) == 1;
    uint64_t seed = options->common.seed;
    int n = options->n_seeds;
    lf_status status = LF_OK;
    for (int i = 0; i < n * n_budgets * n_contenders && status == LF_OK; i++) {
        int run = i / n_contenders; /* seed by seed, budget by budget */
        int who = (run + i) % n_contenders;
        if (terminal)
            fprintf(stderr, "\r" LF_BENCH_PROGRAM ": %s: run %d of %d\033[K", trial->name, run + 1,
                    n * n_budgets);
        status =
            lf_trial_run(trial, &contenders[who], seed + (uint64_t)run, &budgets[run % n_budgets],
                         &out_measures[who * n * n_budgets + run], err);
    }
    if (terminal)
        fputs("\r\033[K", stderr);
    return status;
}

double lf_without_ratio(const lf_trial *trial, const lf_contender *who, const lf_measure *measure)
{
    return who->estimator == LF_ESTIMATOR_MWIS
               ? (double)measure->stats.holes / ((double)trial->n / 3)
               : 0.0;
}

double lf_measure_ratio(const lf_measure *baseline, const lf_measure *ours)
{
    double ratio = baseline->rel_mse * baseline->cpu_seconds / (ours->rel_mse * ours->cpu_seconds);
    return baseline->rel_mse > 0 && ours->rel_mse > 0 ? ratio : (double)NAN;
}

/* --------------------------------------------------------------------------------- reporting -- */

json_t *lf_contender_json(const lf_contender *who)
{
    return json_pack("{s:s, s:s}", "integrator", who->integrator, "estimator",
                     lf_estimator_name((int)who->estimator));
}

json_t *lf_interval_json(lf_interval interval)
{
    return json_pack("{s:o, s:o, s:o}", "estimate", lf_bench_number(interval.estimate), "low",
                     lf_bench_number(interval.low), "high", lf_bench_number(interval.high));
}

json_t *lf_trial_json(const lf_trial *trial, const lf_trial_options *options)
{
    return json_pack("{s:s, s:o, s:i, s:i, s:i, s:i, s:i, s:f, s:{s:s, s:s, s:f, s:f, s:f}}",
                     "scene", trial->name, "machine", lf_bench_machine(), "threads",
                     lf_pool_threads(trial->pool), "views", trial->settings.camera.n_views, "width",
                     trial->settings.width, "height", trial->settings.height, "seeds",
                     options->n_seeds, "epsilon", trial->epsilon, "reference", "integrator",
                     trial->reference_by.integrator, "estimator",
                     lf_estimator_name(trial->reference_by.estimator), "spp", trial->reference_spp,
                     "rel_mse", trial->reference_error, "cpu_seconds", trial->reference_cpu);
}

void lf_trial_print(const lf_trial *trial, const lf_trial_options *options)
{
    json_t *machine = lf_bench_machine();
    printf("%s: %d views of %dx%d, %d seeds, relMSE with epsilon %g\n", trial->name,
           trial->settings.camera.n_views, trial->settings.width, trial->settings.height,
           options->n_seeds, trial->epsilon);
    printf("machine: %s, %d threads\n", json_string_value(json_object_get(machine, "cpu")),
           lf_pool_threads(trial->pool));
    printf("reference: %s %s, %.3g spp, relMSE %.3g (subtracted), %.1f CPU seconds\n",
           trial->reference_by.integrator, lf_estimator_name(trial->reference_by.estimator),
           trial->reference_spp, trial->reference_error, trial->reference_cpu);
    json_decref(machine);
}
