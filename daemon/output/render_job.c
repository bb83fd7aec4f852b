#include "daemon/output/render_job.h"

#include <assert.h>
#include <math.h>
#include <sys/resource.h>

#include "base/log.h"

typedef struct run {
    lf_renderer *renderer;
    const lf_budget *budget;
    lf_estimator estimator;
    float *film;
    int n_views, n_rows;     /* n_rows: of the part */
    bool goes_on;            /* the film was not empty */
    double before;           /* passes it held, which are not new progress */
    lf_asked at;             /* state for continued passes */
    int64_t passes;          /* complete passes so far */
    atomic_llong row_passes; /* summed over rows, including passes in progress */
    double start, cpu_start;
    double target_fraction;
    lf_render_progress_fn progress;
    void *context;
    const lf_cancel *cancel;
} run;

static double fraction_of(const run *r, double passes)
{
    const lf_budget *budget = r->budget;
    if (budget->passes > 0)
        return passes / (double)budget->passes;
    if (budget->seconds > 0)
        return (lf_time_now() - r->start) / budget->seconds;
    if (budget->cpu_seconds > 0)
        return (lf_time_cpu() - r->cpu_start) / budget->cpu_seconds;
    return r->target_fraction;
}

static void report(const run *r, bool whole)
{
    double passes = (double)atomic_load_explicit(&r->row_passes, memory_order_relaxed) / r->n_rows;
    lf_render_progress progress = {
        .fraction = fmin(1, fmax(0, fraction_of(r, passes))),
        .seconds = lf_time_now() - r->start,
        .passes = passes,
        .n_views = r->n_views,
        .whole = whole,
    };
    if (r->progress && passes >= r->before)
        r->progress(r->context, &progress);
}

static void row_done(void *context, int passes, int worker)
{
    run *r = context;
    atomic_fetch_add_explicit(&r->row_passes, passes, memory_order_relaxed);
    if (worker == 0) /* the thread that called lf_render_run */
        report(r, false);
}

/* lf_renderer_passes divides any number of passes into pairs of whole cycles, except for the rest.
 * Calling it per pair therefore gives the same film as a single call. With features, whose visits
 * grow with the passes so far, the film is defined by these calls. */
static lf_status add(run *r, int64_t n_passes, bool split)
{
    int64_t cycles = 2 * (int64_t)r->n_views;
    lf_status status = LF_OK;
    while (n_passes > 0 && status == LF_OK) {
        int64_t now = n_passes < cycles ? n_passes : cycles;
        status = r->goes_on && r->budget->passes > 0
                     ? lf_renderer_passes_after(r->renderer, r->budget->part, &r->at, now, split,
                                                row_done, r, r->cancel)
                     : lf_renderer_passes(r->renderer, r->budget->part, now, split, row_done, r,
                                          r->cancel);
        if (status == LF_OK)
            r->passes += now;
        n_passes -= now;
        report(r, status == LF_OK);
    }
    return status;
}

static lf_status run_passes(run *r)
{
    const int64_t n = r->budget->passes;
    lf_status status = add(r, n, n == 1 && r->estimator == LF_ESTIMATOR_CV);
    if (status == LF_OK && r->goes_on && !lf_renderer_is_at(r->renderer, r->budget->part, &r->at))
        return LF_E_STATE;
    return status;
}

/* Short visits cost more per pass than whole cycles, since each refreshes B and q. The rest is
 * therefore not divided further. */
static lf_status run_time(run *r, double seconds, double start, double (*clock_now)(void))
{
    double spent = r->passes > 0 ? clock_now() - start : 0;
    double fits = r->passes > 0 ? (seconds - spent) * (double)r->passes / fmax(spent, 1e-9) : 2;
    lf_status status = LF_OK;
    while (status == LF_OK && fits >= 2 && spent < 0.97 * seconds) {
        int64_t next = (int64_t)fmin(0.95 * fits + 1, 2.0 * r->n_views) & ~INT64_C(1);
        status = add(r, next > 2 ? next : 2, false);
        spent = clock_now() - start;
        fits = (seconds - spent) * (double)r->passes / fmax(spent, 1e-9);
    }
    return status;
}

/* The error is checked at predefined numbers of passes, each half as many again as the one before.
 * The chance that any of LOOKS checks stops too early is LF_ERROR_ALPHA; each check has an equal
 * share. */
enum { LOOKS = 40 };

/* Estimates the target's error and its bound; negative: unknown. */
static lf_status look(run *r, double *out_estimate, double *out_bound)
{
    const double alpha = LF_ERROR_ALPHA / LOOKS;
    double target = r->budget->target_error;
    lf_render_stats stats;
    *out_bound = -1;
    if (!(target > 0)) {
        lf_status status = lf_renderer_fit(r->renderer, r->cancel);
        *out_bound = lf_renderer_shown_error(r->renderer, alpha, out_estimate, NULL);
        return status;
    }
    /* the estimate is a by-product of the answer */
    lf_status status = lf_renderer_resolve(r->renderer, r->estimator, r->film, NULL);
    lf_renderer_stats(r->renderer, &stats);
    *out_estimate = stats.rel_mse_estimate;
    if (status == LF_OK && *out_estimate >= 0 && *out_estimate <= target)
        *out_bound = lf_renderer_error_bound(r->renderer, r->estimator, alpha, NULL);
    return status;
}

static lf_status run_target(run *r, double target)
{
    int64_t cycles = 2 * (int64_t)r->n_views;
    lf_status status = LF_OK;
    bool reached = false;
    while (!reached) {
        double estimate = -1, bound = -1;
        status = add(r, (r->passes / (2 * cycles) + 1) * cycles, false);
        if (status == LF_OK)
            status = look(r, &estimate, &bound);
        if (status != LF_OK)
            break;
        reached = bound >= 0 && bound <= target;
        /* the error falls as 1 / passes, so this is the finished share of the passes needed */
        r->target_fraction = estimate > 0 ? target / estimate : 0;
        report(r, true);
    }
    return status;
}

/* Counts the earlier cost as if it had been spent just now. */
static void take_up(run *r, const lf_render_times *before)
{
    r->goes_on = true;
    r->before = (double)before->passes;
    r->start -= before->seconds;
    r->cpu_start -= before->cpu_seconds;
    if (r->budget->passes > 0) /* passes that are not repeated are reported again */
        return;
    r->passes = before->passes;
    atomic_store_explicit(&r->row_passes, before->passes * r->n_rows, memory_order_relaxed);
}

/* The number of rows of a part. */
static int rows_of(const lf_part *part, int height)
{
    const int end = part && part->end_row > 0 ? part->end_row : height,
              step = part && part->row_step > 0 ? part->row_step : 1,
              first = part ? part->first_row : 0;
    return end > first ? (end - first - 1) / step + 1 : 1;
}

lf_status lf_render_gather(lf_renderer *renderer, const lf_budget *budget, lf_estimator estimator,
                           const lf_render_times *before, float *film,
                           lf_render_progress_fn progress, void *context, const lf_cancel *cancel,
                           lf_render_times *out_times)
{
    const lf_render_settings *settings = lf_renderer_settings(renderer);
    run r = {
        .renderer = renderer,
        .budget = budget,
        .estimator = estimator,
        .n_views = settings->camera.n_views,
        .n_rows = rows_of(budget->part, settings->height),
        .start = lf_time_now(),
        .cpu_start = lf_time_cpu(),
        .progress = progress,
        .context = context,
        .cancel = cancel,
    };
    lf_status status = LF_OK;
    r.film = film;
    if (before)
        take_up(&r, before);
    report(&r, true);
    if (budget->passes > 0) {
        status = run_passes(&r);
    } else if (budget->seconds > 0) {
        status = run_time(&r, budget->seconds, r.start, lf_time_now);
    } else if (budget->cpu_seconds > 0) {
        status = run_time(&r, budget->cpu_seconds, r.cpu_start, lf_time_cpu);
    } else {
        assert(budget->target_error > 0 || budget->target_denoised_error > 0);
        status = run_target(&r, fmax(budget->target_error, budget->target_denoised_error));
    }
    if (status == LF_E_CANCELLED && !lf_renderer_spreads(renderer))
        r.passes = atomic_load_explicit(&r.row_passes, memory_order_relaxed) / r.n_rows;
    *out_times =
        (lf_render_times){r.passes, lf_time_now() - r.start, lf_time_cpu() - r.cpu_start, 0};
    return status;
}

lf_status lf_render_fill(lf_renderer *renderer, const lf_budget *budget, lf_estimator estimator,
                         const lf_cancel *cancel, lf_render_times *times)
{
    const double start = lf_time_now(), cpu_start = lf_time_cpu();
    lf_status status = LF_OK;
    if (estimator == LF_ESTIMATOR_MWIS && !budget->reconstructed)
        status = lf_renderer_fill_holes(renderer, NULL, cancel);
    const double cpu = lf_time_cpu() - cpu_start;
    times->answer_cpu_seconds += cpu;
    times->cpu_seconds += cpu;
    times->seconds += lf_time_now() - start;
    return status;
}

lf_status lf_render_spend(lf_renderer *renderer, const lf_budget *budget, lf_estimator estimator,
                          float *film, lf_render_progress_fn progress, void *context,
                          const lf_cancel *cancel, lf_render_times *out_times)
{
    lf_status status = lf_render_gather(renderer, budget, estimator, NULL, film, progress, context,
                                        cancel, out_times);
    return status == LF_OK ? lf_render_fill(renderer, budget, estimator, cancel, out_times)
                           : status;
}

lf_status lf_render_answer(lf_renderer *renderer, const lf_budget *budget, lf_estimator estimator,
                           float *film, const lf_cancel *cancel, lf_render_times *times)
{
    const double start = lf_time_now(), cpu_start = lf_time_cpu();
    lf_status status = budget->reconstructed ? lf_renderer_show(renderer, film, cancel)
                                             : lf_renderer_resolve(renderer, estimator, film, NULL);
    const double cpu = lf_time_cpu() - cpu_start;
    times->answer_cpu_seconds += cpu;
    times->cpu_seconds += cpu;
    times->seconds += lf_time_now() - start;
    return status;
}

lf_status lf_render_run(lf_renderer *renderer, const lf_budget *budget, lf_estimator estimator,
                        float *film, lf_render_progress_fn progress, void *context,
                        const lf_cancel *cancel, lf_render_times *out_times)
{
    lf_status status =
        lf_render_spend(renderer, budget, estimator, film, progress, context, cancel, out_times);
    return status == LF_OK ? lf_render_answer(renderer, budget, estimator, film, cancel, out_times)
                           : status;
}

/* ------------------------------------------------------------------------------------- stats -- */

static json_t *count_or_null(int64_t value)
{
    return value >= 0 ? json_integer(value) : json_null();
}

static json_t *real_or_null(double value)
{
    return value >= 0 && isfinite(value) ? json_real(value) : json_null();
}

/* Errors of the estimator's answer, and of the reconstructed picture if there is one. */
static void set_errors(json_t *object, const lf_render_report *report, double resolved)
{
    double error, shown,
        shown_bound = lf_renderer_shown_error(report->renderer, LF_ERROR_ALPHA, &shown, NULL),
        bound =
            lf_renderer_error_bound(report->renderer, report->estimator, LF_ERROR_ALPHA, &error);
    json_object_set_new(object, "rel_mse_estimate", real_or_null(resolved));
    json_object_set_new(object, "rel_mse_bound", real_or_null(bound));
    json_object_set_new(object, "error", bound >= 0 ? real_or_null(error) : json_null());
    json_object_set_new(object, "error_bound", real_or_null(bound));
    json_object_set_new(object, "denoised_error", real_or_null(shown));
    json_object_set_new(object, "denoised_error_bound", real_or_null(shown_bound));
    json_object_set_new(object, "shown_error", real_or_null(shown));
    json_object_set_new(object, "shown_error_bound", real_or_null(shown_bound));
}

static void set_rendered(json_t *object, const lf_render_report *report)
{
    const lf_render_settings *settings = lf_renderer_settings(report->renderer);
    lf_render_stats stats;
    lf_renderer_stats(report->renderer, &stats);
    set_errors(object, report, stats.rel_mse_estimate);
    json_object_set_new(object, "integrator",
                        json_string(settings->integrator ? settings->integrator : "mvpt"));
    json_object_set_new(object, "estimator", json_string(lf_estimator_name(report->estimator)));
    json_object_set_new(object, "seed",
                        settings->seed <= INT64_MAX ? json_integer((json_int_t)settings->seed)
                                                    : json_real((double)settings->seed));
    json_object_set_new(object, "passes", json_integer(report->times.passes));
    json_object_set_new(object, "seconds", json_real(report->times.seconds));
    json_object_set_new(object, "cpu_seconds", json_real(report->times.cpu_seconds));
    json_object_set_new(object, "base_paths", count_or_null(stats.base_paths));
    json_object_set_new(object, "native_spp_mean", real_or_null(stats.native_spp_mean));
    json_object_set_new(object, "effective_spp_mean", real_or_null(stats.effective_spp_mean));
    json_object_set_new(object, "rays_traced", count_or_null(stats.rays_traced));
    json_object_set_new(object, "volume_lookups", count_or_null(stats.volume_lookups));
    json_object_set_new(object, "contributions", count_or_null(stats.contributions));
    json_object_set_new(object, "nonfinite_dropped", count_or_null(stats.nonfinite_dropped));
    json_object_set_new(object, "max_depth_loss", json_real(lf_render_cut(&stats)));
    json_object_set_new(object, "skipped", lf_renderer_skipped(report->renderer));
}

bool lf_render_warn_of_cut(const lf_render_stats *stats, const char *where)
{
    const double least = 0.001, cut = lf_render_cut(stats);
    if (!(cut > least))
        return false;
    lf_log(LF_LOG_WARNING,
           "%s: up to %.2g %% of the scattered light is missing, because paths end after max_depth "
           "= %d vertices; raise max_depth",
           where, 100.0 * cut, stats->max_depth);
    return true;
}

json_t *lf_render_report_json(const lf_render_report *report)
{
    static const char *const keys[] = {"scene",
                                       "integrator",
                                       "estimator",
                                       "views",
                                       "width",
                                       "height",
                                       "threads",
                                       "seed",
                                       "passes",
                                       "seconds",
                                       "cpu_seconds",
                                       "base_paths",
                                       "native_spp_mean",
                                       "effective_spp_mean",
                                       "rel_mse_estimate",
                                       "rel_mse_bound",
                                       "error",
                                       "error_bound",
                                       "denoised_error",
                                       "denoised_error_bound",
                                       "shown_error",
                                       "shown_error_bound",
                                       "rays_traced",
                                       "volume_lookups",
                                       "contributions",
                                       "nonfinite_dropped",
                                       "max_depth_loss",
                                       "peak_rss_bytes",
                                       "skipped"};
    json_t *object = json_object();
    struct rusage usage;
    if (!object)
        return NULL;
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
        json_object_set_new(object, keys[i], json_null());
    getrusage(RUSAGE_SELF, &usage);
    json_object_set_new(object, "scene", json_string(report->scene));
    json_object_set_new(object, "views", json_integer(report->n_views));
    json_object_set_new(object, "width", json_integer(report->width));
    json_object_set_new(object, "height", json_integer(report->height));
    json_object_set_new(object, "threads", json_integer(report->threads));
    json_object_set_new(object, "peak_rss_bytes", json_integer((json_int_t)usage.ru_maxrss * 1024));
    if (report->renderer)
        set_rendered(object, report);
    else
        json_object_set_new(object, "skipped",
                            json_pack("{s:s}", "rendering", "the input is a finished light field"));
    return object;
}
