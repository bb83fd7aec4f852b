/* The renderer: passes over rows on a pool, the offline schedule, counters. */
#include "render/renderer.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/plane/kernel.h"
#include "render/scene/geometry.h"
#include "render/skip.h"
#include "render/transport/path/sunlight.h"
#include "render/transport/sampler.h"

/* ------------------------------------------------------------------------------------- names -- */

const char *lf_estimator_name(int estimator)
{
    static const char *const names[] = {"mwis", "mis", "cv"};
    return estimator <= LF_ESTIMATOR_CV ? names[estimator] : NULL;
}

const char *lf_sampler_name(int kind)
{
    static const char *const names[] = {"owen", "independent"};
    return kind <= LF_SAMPLER_INDEPENDENT ? names[kind] : NULL;
}

/* --------------------------------------------------------------------------- set-up, restart -- */

/* Parts made by a start or restart, before the old ones are released. */
typedef struct parts {
    const lf_integrator *integrator;
    void *state;
    lf_integrator_needs needs;
    lf_geometry *empty;
    lf_lane_scene *lanes; /* allocated separately, because the integrator borrows it */
    lf_film film;         /* empty if the old one fits */
    bool keep_film;
    const char *name;
    uint8_t picture[LF_PICTURE_BYTES];
} parts;

static void drop_parts(parts *fresh)
{
    if (fresh->integrator)
        fresh->integrator->destroy(fresh->state);
    lf_film_finish(&fresh->film);
    lf_geometry_unref(fresh->empty);
    if (fresh->lanes)
        lf_lane_scene_finish(fresh->lanes);
    lf_free(fresh->lanes);
}

static lf_status make_lanes(const lf_renderer *r, lf_scene *scene, unsigned skip,
                            lf_lane_scene **out)
{
    if (!(skip & LF_SKIP_PATHS) || !lf_lane_scene_serves(scene))
        return LF_OK;
    *out = lf_calloc(1, sizeof **out);
    return *out ? lf_lane_scene_init(*out, scene, r->lanes, r->pool) : LF_E_NOMEM;
}

static lf_status make_parts(lf_renderer *r, lf_scene *scene, const lf_render_settings *settings,
                            parts *fresh, lf_error *err)
{
    lf_scene seen = {0};
    int index;
    lf_status status = lf_integrator_find(settings, &fresh->integrator, &index, err);
    if (status == LF_OK)
        status = lf_skip_scene(scene, settings->skip, &seen, &fresh->empty, err);
    if (status != LF_OK)
        return status;
    fresh->name = fresh->integrator->entry(index)->name;
    const lf_integrator_entry *entry = fresh->integrator->entry(index);
    const lf_param *unfit = lf_choices_unfit(&settings->choices, entry);
    if (unfit)
        return lf_error_set(err, LF_E_ARG, "integrator",
                            "%s does not support --%s; remove the option", fresh->name,
                            unfit->option);
    status = lf_integrator_check(entry, scene, settings, err);
    if (status == LF_OK)
        status = make_lanes(r, scene, settings->skip & fresh->integrator->skips, &fresh->lanes);
    const lf_integrator_input input = {
        scene, &seen, settings, r->pool, fresh->lanes, lf_kernels_get()->suffixes, &r->film};
    if (status == LF_OK)
        status = fresh->integrator->create(&input, index, &fresh->state, &fresh->needs, err);
    if (status == LF_OK) {
        fresh->keep_film = lf_film_has_layout(&r->film, &fresh->needs.layout);
        status = fresh->keep_film ? LF_OK
                                  : lf_film_init_packed(&fresh->film, &fresh->needs.layout,
                                                        lf_pool_threads(r->pool));
    }
    if (status == LF_OK)
        status = lf_renderer_identify(scene, settings, fresh->name, fresh->picture);
    if (status == LF_E_NOMEM)
        lf_error_set(
            err, status, "renderer", "not enough memory for %d views of %dx%d and %d workers",
            settings->camera.n_views, settings->width, settings->height, lf_pool_threads(r->pool));
    return status;
}

/* Gives up the old for the new; what remains in *fresh is the old, to be dropped. */
static void take_parts(lf_renderer *r, parts *fresh)
{
    parts old = {
        .integrator = r->integrator, .state = r->state, .empty = r->empty, .lanes = r->lanes};
    r->integrator = fresh->integrator;
    r->state = fresh->state;
    r->empty = fresh->empty;
    r->lanes = fresh->lanes;
    r->visit_passes = fresh->needs.visit_passes;
    if (fresh->keep_film) {
        lf_film_clear(&r->film);
    } else {
        old.film = r->film;
        r->film = fresh->film;
    }
    memcpy(r->film.sky, fresh->needs.sky, sizeof fresh->needs.sky);
    memcpy(r->film.picture, fresh->picture, sizeof fresh->picture);
    *fresh = old;
}

static lf_status set_up(lf_renderer *r, lf_scene *scene, const lf_render_settings *settings,
                        lf_error *err)
{
    parts fresh = {0};
    lf_status status = make_parts(r, scene, settings, &fresh, err);
    if (status == LF_OK) {
        const char *name = fresh.name;
        take_parts(r, &fresh);
        lf_renderer_retire_fit(r, scene, settings);
        lf_scene *old = r->scene;
        r->scene = lf_scene_ref(scene);
        r->settings = *settings;
        r->settings.integrator = name;
        if (r->sunlight && !lf_sunlight_adopt(r->sunlight, scene)) {
            lf_sunlight_destroy(r->sunlight);
            r->sunlight = NULL;
        }
        drop_parts(&fresh);
        lf_scene_unref(old);
    } else {
        drop_parts(&fresh);
    }
    return status;
}

lf_status lf_renderer_create(lf_scene *scene, const lf_render_settings *settings, lf_pool *pool,
                             lf_renderer **out_renderer, lf_error *err)
{
    lf_renderer *r = lf_calloc(1, sizeof *r);
    if (!r)
        return lf_error_set(err, LF_E_NOMEM, "renderer", "out of memory");
    r->pool = pool;
    lf_status status = set_up(r, scene, settings, err);
    if (status != LF_OK) {
        lf_renderer_destroy(r);
        return status;
    }
    *out_renderer = r;
    return LF_OK;
}

void lf_renderer_release(lf_renderer *renderer)
{
    lf_film_release(&renderer->film);
}

void lf_renderer_destroy(lf_renderer *renderer)
{
    if (!renderer)
        return;
    if (renderer->integrator)
        renderer->integrator->destroy(renderer->state);
    lf_film_finish(&renderer->film);
    lf_renderer_drop_fits(renderer);
    lf_geometry_unref(renderer->empty);
    lf_sunlight_destroy(renderer->sunlight);
    if (renderer->lanes)
        lf_lane_scene_finish(renderer->lanes);
    lf_free(renderer->lanes);
    lf_scene_unref(renderer->scene);
    lf_free(renderer);
}

lf_status lf_renderer_restart(lf_renderer *renderer, lf_scene *scene,
                              const lf_render_settings *settings, lf_error *err)
{
    return set_up(renderer, scene, settings, err);
}

/* ------------------------------------------------------------------------------------ passes -- */

typedef struct lf_pass_job {
    lf_renderer *renderer;
    lf_visit_order order;
    lf_part part; /* with explicit values instead of zeros */
    lf_pass pass;
    int half;           /* as in lf_pass */
    const lf_asked *at; /* as in lf_pass */
    lf_row_fn row_done;
    void *context;
    const lf_cancel *cancel;
} lf_pass_job;

static void run_row(void *context, int item, int worker)
{
    lf_pass_job *job = context;
    lf_renderer *r = job->renderer;
    int row = job->part.first_row + item * job->part.row_step;
    if (job->order.fans && lf_film_is_known(&r->film.rows[row]))
        return;
    const lf_film_counts *given = &r->film.streams[job->order.stream].rows[row];
    const int half = lf_pass_half(&job->pass, given);
    if ((lf_pass_has_had(&job->pass, given) ||
         r->integrator->visit(r->state, &job->order, row, half, worker, job->cancel)) &&
        job->row_done)
        job->row_done(job->context, row, worker);
}

/* Replaces zeros by the values that they mean; NULL: all rows. */
static lf_part whole_part(const lf_renderer *r, const lf_part *part)
{
    lf_part whole = part ? *part : (lf_part){0};
    whole.end_row = whole.end_row != 0 ? whole.end_row : r->film.height;
    whole.row_step = whole.row_step != 0 ? whole.row_step : 1;
    return whole;
}

/* part: from whole_part. */
static bool is_within(const lf_renderer *r, const lf_part *part)
{
    return part->first_row >= 0 && part->row_step >= 1 && part->end_row >= 0 &&
           part->end_row <= r->film.height;
}

/* Prepares the scene's lights for the film's features, once. */
static lf_status light_up(lf_renderer *r, const lf_cancel *cancel)
{
    if (r->sunlight || !r->film.layout.has_features || !lf_sunlight_needed(r->scene))
        return LF_OK;
    return lf_sunlight_create(r->scene, 0, r->pool, cancel, &r->sunlight);
}

static lf_status run(lf_pass_job *job)
{
    lf_renderer *r = job->renderer;
    const lf_part part = job->part;
    const uint64_t seed = r->settings.seed;
    if (!is_within(r, &part))
        return LF_E_ARG;
    if (part.first_row >= part.end_row)
        return LF_OK;
    lf_status status = lf_film_stream_at(&r->film, seed, part.stream, &job->order.stream);
    if (status == LF_OK)
        status = light_up(r, job->cancel);
    if (status != LF_OK)
        return status;
    job->order.sunlight = r->sunlight;
    job->order.random = lf_film_stream_random(&r->film.streams[job->order.stream]);
    job->order.faults = r->faults;
    job->pass = (lf_pass){.order = &job->order,
                          .first_row = part.first_row,
                          .row_step = part.row_step,
                          .n_rows = (part.end_row - part.first_row - 1) / part.row_step + 1,
                          .half = job->half,
                          .at = job->at};
    status = r->integrator->begin(r->state, &job->pass, job->cancel);
    if (status != LF_OK)
        return status;
    status = lf_pool_run(r->pool, job->pass.n_rows, run_row, job, job->cancel);
    if (status == LF_OK && r->integrator->end &&
        !(job->cancel && atomic_load_explicit(job->cancel, memory_order_relaxed)))
        status = r->integrator->end(r->state, &job->pass, job->cancel);
    if (job->cancel && atomic_load_explicit(job->cancel, memory_order_relaxed))
        return LF_E_CANCELLED;
    return status;
}

lf_status lf_renderer_pass(lf_renderer *renderer, const lf_part *part, int subsets,
                           lf_row_fn row_done, void *context, const lf_cancel *cancel)
{
    return lf_renderer_pass_filling(renderer, part, subsets, -1, row_done, context, cancel);
}

lf_status lf_renderer_pass_filling(lf_renderer *renderer, const lf_part *part, int subsets,
                                   int hole_reach, lf_row_fn row_done, void *context,
                                   const lf_cancel *cancel)
{
    if (subsets < 1 || subsets > renderer->film.n_views)
        return LF_E_ARG;
    lf_pass_job job = {.renderer = renderer,
                       .order = {.subsets = subsets,
                                 .column_step = 1,
                                 .cover = subsets < renderer->film.n_views,
                                 .hole_reach = hole_reach},
                       .part = whole_part(renderer, part),
                       .half = -1,
                       .row_done = row_done,
                       .context = context,
                       .cancel = cancel};
    return run(&job);
}

lf_status lf_renderer_pass_coarse(lf_renderer *renderer, const lf_part *part, int hole_reach,
                                  lf_row_fn row_done, void *context, const lf_cancel *cancel)
{
    lf_pass_job job = {.renderer = renderer,
                       .order = {.subsets = 1,
                                 .column_step = 1,
                                 .cover = renderer->film.n_views > 1,
                                 .coarse = true,
                                 .hole_reach = hole_reach},
                       .part = whole_part(renderer, part),
                       .half = -1,
                       .row_done = row_done,
                       .context = context,
                       .cancel = cancel};
    return run(&job);
}

lf_status lf_renderer_pass_fans(lf_renderer *renderer, const lf_cancel *cancel)
{
    const lf_film_layout *layout = &renderer->film.layout;
    lf_pass_job job = {.renderer = renderer,
                       .order = {.subsets = 1,
                                 .column_step = 1,
                                 .cover = renderer->film.n_views > 1,
                                 .coarse = true,
                                 .fans = true,
                                 .hole_reach = -1},
                       .part = whole_part(renderer, NULL),
                       .half = 0,
                       .cancel = cancel};
    if (!layout->has_features)
        return LF_E_STATE;
    /* fans cannot find the native light of equiangular lights and alpha surfaces */
    const lf_scene *scene = renderer->scene;
    if (scene->equiangular.n > 0 ||
        (lf_has(scene, LF_TRAITS_SEEN_THROUGH) && lf_has(scene, LF_TRAIT_EMISSION)))
        return LF_OK;
    return run(&job);
}

bool lf_renderer_visited(const lf_renderer *renderer, int row)
{
    return lf_film_visited(renderer->film.rows[row].visits);
}

lf_status lf_renderer_fill_holes(lf_renderer *renderer, const lf_part *part,
                                 const lf_cancel *cancel)
{
    lf_pass_job job = {.renderer = renderer,
                       .order = {.column_step = 1, .cover = true},
                       .part = whole_part(renderer, part),
                       .half = -1,
                       .cancel = cancel};
    return run(&job);
}

typedef struct lf_passes_report {
    lf_passes_fn row_done; /* NULL: no callback */
    void *context;
    int passes;
} lf_passes_report;

static void report_row(void *context, int row, int worker)
{
    const lf_passes_report *report = context;
    (void)row;
    if (report->row_done)
        report->row_done(report->context, report->passes, worker);
}

static const lf_integrator_entry *entry_of(const lf_renderer *r)
{
    int i = 0;
    while (strcmp(r->integrator->entry(i)->name, r->settings.integrator) != 0)
        i++;
    return r->integrator->entry(i);
}

bool lf_renderer_is_its_film(const lf_renderer *renderer)
{
    return !entry_of(renderer)->remembers;
}

bool lf_renderer_spreads(const lf_renderer *renderer)
{
    return entry_of(renderer)->spreads;
}

/* One visit of every row of the part; at: only rows that have not had it. */
static lf_status visit_all(lf_renderer *renderer, const lf_part *part, int half, int subsets,
                           int column_step, lf_passes_report *report, const lf_asked *at,
                           const lf_cancel *cancel)
{
    lf_pass_job job = {.renderer = renderer,
                       .order = {.subsets = subsets,
                                 .column_step = column_step,
                                 .hole_reach = -1,
                                 .at = entry_of(renderer)->spreads ? at : NULL},
                       .part = whole_part(renderer, part),
                       .half = half,
                       .at = at,
                       .cancel = cancel};
    if (report->row_done) {
        /* a pass split between the halves counts once */
        report->passes = column_step > 1 ? half : subsets;
        job.row_done = report_row;
        job.context = report;
    }
    return run(&job);
}

/* Pairs of whole cycles after which visits have their full size. */
#define MOST_GROWTH 16

/* A reconstruction needs many film points early: short visits, each at most a quarter of the passes
 * of the half so far. */
static int passes_of_visit(const lf_renderer *r, double given)
{
    if (!r->film.layout.has_features)
        return r->visit_passes;
    int most = (int)fmin(given / 4.0, (double)r->visit_passes);
    return most > 1 ? most : 1;
}

/* In whole halves of a pass, as passes are given: n is their share of a view, rounded. */
static double given_to(const lf_renderer *r, const lf_part *part, int half)
{
    const lf_part whole = whole_part(r, part);
    const lf_film_stream *stream = lf_film_find_stream(&r->film, r->settings.seed, whole.stream);
    return stream && whole.first_row >= 0 && whole.first_row < r->film.height
               ? 0.5 * round(2.0 * stream->rows[whole.first_row].n[half] * r->film.n_views)
               : 0.0;
}

static bool same_passes(double a, double b)
{
    return fabs(a - b) < 0.25;
}

/* Number of the part's rows that lack the next visit of a half, with `passes` passes; -1: a row has
 * other visits. */
static int count_lacking(const lf_renderer *r, const lf_part *part, const lf_asked *at, int half,
                         double passes)
{
    const lf_film_stream *stream = lf_film_find_stream(&r->film, r->settings.seed, part->stream);
    int lacking = 0;
    for (int row = part->first_row; row < part->end_row; row += part->row_step) {
        const lf_film_counts none = {0}, *had = stream ? &stream->rows[row] : &none;
        const double given = had->n[half] * r->film.n_views;
        const uint32_t visits = had->visits[half];
        if (visits < at->visits[half] ||
            (visits == at->visits[half] && !same_passes(given, at->given[half])) ||
            (visits == at->visits[half] + 1 && !same_passes(given, at->given[half] + passes)))
            return -1;
        lacking += visits == at->visits[half];
    }
    return lacking;
}

/* The next visit of a half, for the rows that lack it. */
static lf_status visit_lacking(lf_renderer *r, const lf_part *part, lf_asked *at, int half,
                               int subsets, int column_step, lf_passes_report *report,
                               const lf_cancel *cancel)
{
    const lf_part whole = whole_part(r, part);
    const double passes = (double)subsets / column_step;
    if (!is_within(r, &whole))
        return LF_E_ARG;
    const int lacking = count_lacking(r, &whole, at, half, passes);
    lf_status status = lacking < 0 ? LF_E_STATE : LF_OK;
    report->passes = column_step > 1 ? half : subsets;
    if (lacking > 0)
        status = visit_all(r, part, half, subsets, column_step, report, at, cancel);
    for (int row = whole.first_row; row < whole.end_row && lacking == 0; row += whole.row_step)
        report_row(report, row, 0);
    if (status == LF_OK) {
        at->given[half] += passes;
        at->visits[half]++;
    }
    return status;
}

static lf_status visit(lf_renderer *r, const lf_part *part, lf_asked *at, int half, int subsets,
                       int column_step, lf_passes_report *report, const lf_cancel *cancel)
{
    return at ? visit_lacking(r, part, at, half, subsets, column_step, report, cancel)
              : visit_all(r, part, half, subsets, column_step, report, NULL, cancel);
}

static lf_status give_passes(lf_renderer *r, const lf_part *part, lf_asked *at, int64_t n_passes,
                             bool split, lf_passes_report *report, const lf_cancel *cancel)
{
    int64_t left[2] = {n_passes - n_passes / 2, n_passes / 2};
    lf_status status = LF_OK;
    if (n_passes < 1)
        return LF_E_ARG;
    if (n_passes == 1 && split && r->film.width > 1) {
        for (int half = 0; half < 2 && status == LF_OK; half++)
            status = visit(r, part, at, half, 1, 2, report, cancel);
        return status;
    }
    while (status == LF_OK && left[0] + left[1] > 0) {
        int half = left[1] > left[0];
        int most = passes_of_visit(r, at ? at->given[half] : given_to(r, part, half));
        int subsets = left[half] < most ? (int)left[half] : most;
        status = visit(r, part, at, half, subsets, 1, report, cancel);
        left[half] -= subsets;
    }
    return status;
}

lf_status lf_renderer_passes(lf_renderer *renderer, const lf_part *part, int64_t n_passes,
                             bool split, lf_passes_fn row_done, void *context,
                             const lf_cancel *cancel)
{
    lf_passes_report report = {.row_done = row_done, .context = context};
    return give_passes(renderer, part, NULL, n_passes, split, &report, cancel);
}

int64_t lf_renderer_visits(const lf_renderer *renderer, int64_t n_passes)
{
    const int64_t cycles = 2 * (int64_t)renderer->film.n_views;
    double given[2] = {0.0, 0.0};
    int64_t n = 0, of_cycles = 0;
    for (int i = 0; i < MOST_GROWTH && n_passes > 0; i++) {
        int64_t now = n_passes < cycles ? n_passes : cycles, left[2] = {now - now / 2, now / 2};
        n_passes -= now;
        of_cycles = 0;
        while (left[0] + left[1] > 0) {
            const int half = left[1] > left[0], most = passes_of_visit(renderer, given[half]),
                      subsets = left[half] < most ? (int)left[half] : most;
            left[half] -= subsets;
            given[half] += subsets;
            of_cycles++;
        }
        n += of_cycles;
    }
    return n + (n_passes + cycles - 1) / cycles * of_cycles; /* visits do not grow any more */
}

lf_status lf_renderer_passes_after(lf_renderer *renderer, const lf_part *part, lf_asked *at,
                                   int64_t n_passes, bool split, lf_passes_fn row_done,
                                   void *context, const lf_cancel *cancel)
{
    lf_passes_report report = {.row_done = row_done, .context = context};
    return lf_renderer_is_its_film(renderer)
               ? give_passes(renderer, part, at, n_passes, split, &report, cancel)
               : LF_E_STATE;
}

static bool is_in(const lf_part *part, int row)
{
    return row >= part->first_row && row < part->end_row &&
           (row - part->first_row) % part->row_step == 0;
}

bool lf_renderer_is_at(const lf_renderer *renderer, const lf_part *part, const lf_asked *at)
{
    const lf_film *film = &renderer->film;
    const lf_part whole = whole_part(renderer, part);
    const lf_film_stream *stream = lf_film_find_stream(film, renderer->settings.seed, whole.stream);
    for (int row = 0; row < film->height; row++)
        for (int half = 0; half < 2; half++) {
            const uint32_t own = stream ? stream->rows[row].visits[half] : 0;
            if (film->rows[row].visits[half] != own ||
                own != (is_in(&whole, row) ? at->visits[half] : 0))
                return false;
        }
    return true;
}

/* ----------------------------------------------------------------------------------- answers -- */

lf_status lf_renderer_resolve_row(const lf_renderer *renderer, lf_estimator estimator, int row,
                                  float *out, uint8_t *flags)
{
    return lf_film_resolve_row(&renderer->film, estimator, row, out, flags);
}

typedef struct lf_resolve_job {
    const lf_film *film;
    lf_estimator estimator;
    float *out;
    uint8_t *flags;
} lf_resolve_job;

static void resolve_item(void *context, int row, int worker)
{
    const lf_resolve_job *job = context;
    size_t pixels = (size_t)job->film->n_views * (size_t)job->film->width * (size_t)row;
    (void)worker;
    (void)lf_film_resolve_row(job->film, job->estimator, row, job->out + 3 * pixels,
                              job->flags ? job->flags + pixels : NULL);
}

lf_status lf_renderer_resolve(const lf_renderer *renderer, lf_estimator estimator, float *out,
                              uint8_t *flags)
{
    lf_resolve_job job = {.film = &renderer->film, .estimator = estimator};
    job.out = out;
    job.flags = flags;
    return lf_pool_run(renderer->pool, renderer->film.height, resolve_item, &job, NULL);
}

void lf_renderer_stats(const lf_renderer *renderer, lf_render_stats *out)
{
    const lf_film *film = &renderer->film;
    double pixels = (double)film->n_views * film->width, error = 0.0;
    bool known = true;
    *out = (lf_render_stats){0};
    renderer->integrator->count(renderer->state, out);
    out->max_depth = lf_max_depth(renderer->scene, renderer->settings.max_depth);
    for (int row = 0; row < film->height; row++) {
        const lf_film_row *state = &film->rows[row];
        out->passes += state->passes;
        out->native_spp_mean += state->n[0] + state->n[1];
        out->holes += state->holes;
        known = known && state->relative_error >= 0.0;
        error += state->relative_error;
    }
    out->film_bytes += (int64_t)film->data_bytes;
    out->passes /= film->height;
    out->native_spp_mean /= film->height;
    out->effective_spp_mean = (double)out->contributions / (pixels * film->height);
    out->rel_mse_estimate = known ? error / (pixels * film->height) : -1.0;
}

json_t *lf_renderer_skipped(const lf_renderer *renderer)
{
    unsigned skipped =
        lf_skip_found(renderer->scene) & renderer->settings.skip & renderer->integrator->skips;
    json_t *object = json_object();
    if (renderer->integrator->skipped)
        renderer->integrator->skipped(renderer->state, object);
    for (int i = 0; lf_skip_at(i); i++)
        if (skipped & lf_skip_at(i)->bit)
            json_object_set_new(object, lf_skip_at(i)->name, json_string(lf_skip_at(i)->what));
    return object;
}

const lf_render_settings *lf_renderer_settings(const lf_renderer *renderer)
{
    return &renderer->settings;
}

lf_scene *lf_renderer_scene(const lf_renderer *renderer)
{
    return renderer->scene;
}
