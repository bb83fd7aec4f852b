/* The renderer: passes over rows on a pool, the offline schedule, counters. */
#include "render/renderer.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "render/geometry.h"
#include "render/skip.h"

/* ----------------------------------------------------------------------------------------------------------- names -- */

lf_status lf_estimator_from_name(const char *name, lf_estimator *out, lf_error *err)
{
    for (int i = LF_ESTIMATOR_MWIS; i <= LF_ESTIMATOR_CV; i++) {
        if (strcmp(name, lf_estimator_name((lf_estimator)i)) == 0) {
            *out = (lf_estimator)i;
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, "estimator", "\"%s\" is none of mwis, mis, cv", name);
}

const char *lf_estimator_name(lf_estimator estimator)
{
    static const char *const names[] = {"mwis", "mis", "cv"};
    return names[estimator];
}

lf_status lf_sampler_from_name(const char *name, lf_sampler_kind *out, lf_error *err)
{
    for (int i = LF_SAMPLER_OWEN; i <= LF_SAMPLER_INDEPENDENT; i++) {
        if (strcmp(name, lf_sampler_name((lf_sampler_kind)i)) == 0) {
            *out = (lf_sampler_kind)i;
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, "sampler", "\"%s\" is none of owen, independent", name);
}

const char *lf_sampler_name(lf_sampler_kind kind)
{
    return kind == LF_SAMPLER_OWEN ? "owen" : "independent";
}

const char *lf_integrator_name(int index)
{
    const lf_integrator *integrator = lf_integrator_at(index);
    return integrator ? integrator->name : NULL;
}

static lf_status find_integrator(const char *name, const lf_integrator **out, lf_error *err)
{
    for (int i = 0; lf_integrator_at(i); i++) {
        if (!name || strcmp(name, lf_integrator_at(i)->name) == 0) {
            *out = lf_integrator_at(i);
            return LF_OK;
        }
    }
    return lf_error_set(err, LF_E_ARG, "integrator", "\"%s\" is none of mvpt, vpt, amvpt", name);
}

/* -------------------------------------------------------------------------------------------------- set-up, restart -- */

static void free_workers(lf_scratch **workers, int n)
{
    for (int i = 0; i < n && workers; i++) {
        if (workers[i]) {
            lf_media_finish(&workers[i]->media);
            lf_film_sums_finish(&workers[i]->sums);
            lf_section_finish(&workers[i]->section);
            lf_free(workers[i]->expected);
            lf_free(workers[i]->mirrors);
        }
        lf_free(workers[i]);
    }
    lf_free(workers);
}

static lf_scratch **make_workers(int n, const lf_media_frame *frame, const lf_film_layout *layout,
                                 const lf_row_triangles *triangles, bool mirrors)
{
    lf_scratch **workers = lf_calloc((size_t)n, sizeof *workers);
    for (int i = 0; workers && i < n; i++) {
        workers[i] = lf_calloc(1, sizeof **workers);
        if (workers[i])
            workers[i]->expected = lf_calloc((size_t)layout->n_views * (size_t)layout->width, sizeof *workers[i]->expected);
        if (workers[i] && mirrors)
            workers[i]->mirrors = lf_calloc((size_t)layout->n_views * (size_t)layout->width, sizeof *workers[i]->mirrors);
        if (!workers[i] || !workers[i]->expected || (mirrors && !workers[i]->mirrors) ||
            lf_media_init(&workers[i]->media, frame) != LF_OK || lf_film_sums_init(&workers[i]->sums, layout) != LF_OK ||
            lf_section_init(&workers[i]->section, triangles->longest) != LF_OK) {
            free_workers(workers, n);
            return NULL;
        }
    }
    return workers;
}

/* What the scene needs of the film; sky where B is not stored. */
static lf_film_layout film_layout(const lf_scene *scene, unsigned kept, const lf_rig *rig, float sky[3])
{
    bool native = scene->has_delta || scene->n_glows > 0;
    bool uniform = !native && !(kept & LF_SKIP_KNOWN_LIGHT) && lf_exits_uniform(scene, sky), grids = false;
    for (int i = 0; i < scene->n_volumes; i++)
        grids = grids || (scene->volumes[i].kind == LF_VOLUME_GRID && !scene->volumes[i].nearest);
    return (lf_film_layout){.n_views = rig->n_views,
                            .width = rig->width,
                            .height = rig->height,
                            .has_w2 = scene->has_view_lobes,
                            .has_native = native,
                            .has_known = !uniform,
                            .has_delta = scene->has_delta,
                            .has_signed = grids};
}

/* Passes in a visit of the offline schedule. Where surfaces have edges a picture needs many row offsets and film points of B and q,
 * which all views of a visit share: a third of a cycle, by a divisor of n. Media alone are smooth, and their slices want whole
 * cycles; so does what shares nothing. */
static int passes_of_a_visit(const lf_scene *scene, const lf_integrator *integrator, int n)
{
    const int parts = 3;
    int best = n;
    if (!scene->embree || !integrator->shares)
        return n;
    for (int g = (n + 6) / 7; 2 * g <= n; g++) {
        if (n % g == 0 && abs(parts * g - n) < abs(parts * best - n))
            best = g;
    }
    return best;
}

/* What a start or restart makes, before anything of the old is given up. */
typedef struct parts {
    const lf_integrator *integrator;
    lf_scene seen;
    lf_geometry *empty;
    lf_rig rig;
    lf_media_frame frame;
    lf_row_triangles triangles;
    lf_film film; /* nothing where the old one fits */
    float sky[3];
    bool keep_film;
    lf_counts counts;
    lf_scratch **workers;
    int n_workers;
} parts;

static void drop_parts(parts *fresh)
{
    free_workers(fresh->workers, fresh->n_workers);
    lf_counts_finish(&fresh->counts);
    lf_film_finish(&fresh->film);
    lf_row_triangles_finish(&fresh->triangles);
    lf_geometry_unref(fresh->empty);
}

/* The memory: everything that can fail for want of it. */
static lf_status make_memory(lf_renderer *r, unsigned kept, parts *fresh)
{
    const lf_film_layout layout = film_layout(&fresh->seen, kept, &fresh->rig, fresh->sky);
    lf_status status = LF_OK;
    fresh->keep_film = lf_film_has_layout(&r->film, &layout);
    if (fresh->seen.n_meshes > 0)
        status = lf_row_triangles_init(&fresh->triangles, &fresh->seen, &fresh->rig, r->pool);
    if (status == LF_OK && fresh->integrator->adaptive)
        status = lf_counts_init(&fresh->counts, fresh->rig.n_views, fresh->rig.width, fresh->rig.height);
    if (status == LF_OK && !fresh->keep_film)
        status = lf_film_init(&fresh->film, &layout);
    if (status != LF_OK)
        return status;
    fresh->n_workers = lf_pool_threads(r->pool);
    fresh->workers = make_workers(fresh->n_workers, &fresh->frame, &layout, &fresh->triangles, fresh->seen.has_delta);
    return fresh->workers ? LF_OK : LF_E_NOMEM;
}

static lf_status make_parts(lf_renderer *r, lf_scene *scene, const lf_render_settings *settings, parts *fresh, lf_error *err)
{
    lf_status status = find_integrator(settings->integrator, &fresh->integrator, err);
    if (status == LF_OK)
        status = lf_rig_init(&fresh->rig, settings, scene->origin, err);
    if (status == LF_OK)
        status = lf_skip_scene(scene, settings->kept, &fresh->seen, &fresh->empty, err);
    if (status != LF_OK)
        return status;
    lf_media_frame_init(&fresh->frame, scene, &fresh->rig);
    status = make_memory(r, settings->kept, fresh);
    if (status != LF_OK)
        lf_error_set(err, status, "renderer", "not enough memory for %d views of %dx%d and %d workers", fresh->rig.n_views,
                     fresh->rig.width, fresh->rig.height, lf_pool_threads(r->pool));
    return status;
}

/* Gives up the old for the new; what remains in *fresh is the old, to be dropped. */
static void take_parts(lf_renderer *r, parts *fresh)
{
    parts old = {
        .empty = r->empty, .triangles = r->triangles, .counts = r->counts, .workers = r->workers, .n_workers = r->n_workers};
    r->seen = fresh->seen;
    r->empty = fresh->empty;
    r->rig = fresh->rig;
    r->frame = fresh->frame;
    r->triangles = fresh->triangles;
    r->counts = fresh->counts;
    r->workers = fresh->workers;
    r->n_workers = fresh->n_workers;
    if (fresh->keep_film) {
        lf_film_clear(&r->film);
    } else {
        old.film = r->film;
        r->film = fresh->film;
    }
    memcpy(r->film.sky, fresh->sky, sizeof fresh->sky);
    *fresh = old;
}

static lf_status set_up(lf_renderer *r, lf_scene *scene, const lf_render_settings *settings, lf_error *err)
{
    parts fresh = {0};
    lf_status status = make_parts(r, scene, settings, &fresh, err);
    if (status != LF_OK) {
        drop_parts(&fresh);
        return status;
    }
    const lf_integrator *integrator = fresh.integrator;
    take_parts(r, &fresh);
    lf_scene *old = r->scene;
    r->scene = lf_scene_ref(scene);
    drop_parts(&fresh);
    lf_scene_unref(old);
    r->settings = *settings;
    r->settings.integrator = integrator->name;
    r->mapped = false;
    r->visit_passes = passes_of_a_visit(scene, integrator, r->rig.n_views);
    r->plan = (lf_visit_plan){.scene = &r->seen,
                              .rig = &r->rig,
                              .frame = &r->frame,
                              .kernels = lf_kernels_get(),
                              .integrator = integrator,
                              .triangles = r->triangles.first ? &r->triangles : NULL,
                              .film = &r->film,
                              .seed = settings->seed,
                              .sampler = settings->sampler,
                              .max_depth = settings->max_depth > 0 ? settings->max_depth
                                           : scene->max_depth > 0  ? scene->max_depth
                                                                   : LF_DEFAULT_MAX_DEPTH,
                              .subsets = 1,
                              .column_step = 1,
                              .hole_reach = -1,
                              .kept = settings->kept,
                              .pilot = integrator->adaptive ? &r->counts : NULL,
                              .faults = r->plan.faults};
    return LF_OK;
}

lf_status lf_renderer_create(lf_scene *scene, const lf_render_settings *settings, lf_pool *pool, lf_renderer **out_renderer,
                             lf_error *err)
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

void lf_renderer_destroy(lf_renderer *renderer)
{
    if (!renderer)
        return;
    free_workers(renderer->workers, renderer->n_workers);
    lf_counts_finish(&renderer->counts);
    lf_film_finish(&renderer->film);
    lf_row_triangles_finish(&renderer->triangles);
    lf_geometry_unref(renderer->empty);
    lf_scene_unref(renderer->scene);
    lf_free(renderer);
}

lf_status lf_renderer_restart(lf_renderer *renderer, lf_scene *scene, const lf_render_settings *settings, lf_error *err)
{
    return set_up(renderer, scene, settings, err);
}

/* ---------------------------------------------------------------------------------------------------------- passes -- */

typedef struct lf_pass_job {
    lf_renderer *renderer;
    lf_visit_plan *plan;
    int first_row, row_step;
    int half; /* -1 = the one with fewer visits, A first */
    lf_row_fn row_done;
    void *context;
    const lf_cancel *cancel;
} lf_pass_job;

static void run_row(void *context, int item, int worker)
{
    lf_pass_job *job = context;
    int row = job->first_row + item * job->row_step;
    const lf_film_row *state = &job->renderer->film.rows[row];
    int half = job->half >= 0 ? job->half : state->visits[0] > state->visits[1];
    if (lf_visit_row(job->plan, row, half, job->renderer->workers[worker], job->cancel) && job->row_done)
        job->row_done(job->context, row, worker);
}

/* Behind the pilot of an adaptive integrator: its map, once. Failing to make it costs nothing but its gain. */
static void adapt(lf_renderer *renderer)
{
    if (renderer->plan.integrator->adaptive && !renderer->mapped && lf_adaptive_ready(&renderer->film)) {
        renderer->mapped = true;
        if (lf_adaptive_map(&renderer->film, renderer->pool, &renderer->counts) == LF_OK)
            renderer->plan.counts = &renderer->counts;
        renderer->plan.pilot = NULL;
    }
}

static lf_status run(lf_pass_job *job)
{
    int height = job->renderer->film.height;
    adapt(job->renderer);
    job->plan->counts = job->plan->column_step == 1 ? job->renderer->plan.counts : NULL;
    job->plan->pilot = job->renderer->plan.pilot;
    if (job->first_row < 0 || job->row_step < 1 || job->first_row >= height)
        return job->first_row >= height && job->row_step >= 1 ? LF_OK : LF_E_ARG;
    int items = (height - job->first_row + job->row_step - 1) / job->row_step;
    lf_status status = lf_pool_run(job->renderer->pool, items, run_row, job, job->cancel);
    if (job->cancel && atomic_load_explicit(job->cancel, memory_order_relaxed))
        return LF_E_CANCELLED;
    return status;
}

lf_status lf_renderer_pass(lf_renderer *renderer, int first_row, int row_step, int subsets, lf_row_fn row_done, void *context,
                           const lf_cancel *cancel)
{
    return lf_renderer_pass_filling(renderer, first_row, row_step, subsets, -1, row_done, context, cancel);
}

lf_status lf_renderer_pass_filling(lf_renderer *renderer, int first_row, int row_step, int subsets, int hole_reach,
                                   lf_row_fn row_done, void *context, const lf_cancel *cancel)
{
    if (subsets < 1 || subsets > renderer->rig.n_views)
        return LF_E_ARG;
    lf_visit_plan plan = renderer->plan;
    plan.subsets = subsets;
    plan.force = subsets < renderer->rig.n_views;
    plan.hole_reach = hole_reach;
    lf_pass_job job = {.renderer = renderer,
                       .plan = &plan,
                       .first_row = first_row,
                       .row_step = row_step,
                       .half = -1,
                       .row_done = row_done,
                       .context = context,
                       .cancel = cancel};
    return run(&job);
}

lf_status lf_renderer_fill_holes(lf_renderer *renderer, const lf_cancel *cancel)
{
    lf_visit_plan plan = renderer->plan;
    plan.subsets = 0;
    plan.force = true;
    plan.hole_reach = 0;
    lf_pass_job job = {.renderer = renderer, .plan = &plan, .row_step = 1, .half = -1, .cancel = cancel};
    return run(&job);
}

typedef struct lf_passes_report {
    lf_passes_fn row_done; /* NULL: nobody asks */
    void *context;
    int passes;
} lf_passes_report;

static void report_row(void *context, int row, int worker)
{
    const lf_passes_report *report = context;
    (void)row;
    report->row_done(report->context, report->passes, worker);
}

/* One visit of every row. */
static lf_status visit_all(lf_renderer *renderer, int half, int subsets, int column_step, lf_passes_report *report,
                           const lf_cancel *cancel)
{
    lf_visit_plan plan = renderer->plan;
    plan.subsets = subsets;
    plan.column_step = column_step;
    lf_pass_job job = {.renderer = renderer, .plan = &plan, .row_step = 1, .half = half, .cancel = cancel};
    if (report->row_done) {
        report->passes = column_step > 1 ? half : subsets; /* a pass split between the halves is one */
        job.row_done = report_row;
        job.context = report;
    }
    return run(&job);
}

lf_status lf_renderer_passes(lf_renderer *renderer, int64_t n_passes, bool split, lf_passes_fn row_done, void *context,
                             const lf_cancel *cancel)
{
    lf_passes_report report = {.row_done = row_done, .context = context};
    int64_t left[2] = {n_passes - n_passes / 2, n_passes / 2};
    lf_status status = LF_OK;
    if (n_passes < 1)
        return LF_E_ARG;
    if (n_passes == 1 && split && renderer->rig.width > 1) {
        for (int half = 0; half < 2 && status == LF_OK; half++)
            status = visit_all(renderer, half, 1, 2, &report, cancel);
        return status;
    }
    while (status == LF_OK && left[0] + left[1] > 0) {
        int half = left[1] > left[0];
        int subsets = left[half] < renderer->visit_passes ? (int)left[half] : renderer->visit_passes;
        status = visit_all(renderer, half, subsets, 1, &report, cancel);
        left[half] -= subsets;
    }
    return status;
}

/* --------------------------------------------------------------------------------------------------------- answers -- */

lf_status lf_renderer_resolve_row(const lf_renderer *renderer, lf_estimator estimator, int row, float *out, uint8_t *flags)
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
    (void)lf_film_resolve_row(job->film, job->estimator, row, job->out + 3 * pixels, job->flags ? job->flags + pixels : NULL);
}

lf_status lf_renderer_resolve(const lf_renderer *renderer, lf_estimator estimator, float *out, uint8_t *flags)
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
    for (int i = 0; i < renderer->n_workers; i++) {
        const lf_scratch *w = renderer->workers[i];
        out->base_paths += w->base_paths;
        out->contributions += w->contributions;
        out->rays_traced += w->tracer.rays;
        out->volume_lookups += w->tracer.lookups;
        out->nonfinite_dropped += w->tracer.nonfinite;
        out->base_hidden += w->base_hidden;
    }
    for (int row = 0; row < film->height; row++) {
        const lf_film_row *state = &film->rows[row];
        out->passes += state->passes;
        out->native_spp_mean += state->n[0] + state->n[1];
        out->holes += state->holes;
        known = known && state->relative_error >= 0.0;
        error += state->relative_error;
    }
    out->passes /= film->height;
    out->native_spp_mean /= film->height;
    out->effective_spp_mean = (double)out->contributions / (pixels * film->height);
    out->rel_mse_estimate = known ? error / (pixels * film->height) : -1.0;
    if (!renderer->seen.embree)
        out->rays_traced = out->base_hidden = -1;
    if (renderer->scene->n_volumes == 0)
        out->volume_lookups = -1;
}

json_t *lf_renderer_skipped(const lf_renderer *renderer)
{
    unsigned skipped = lf_skip_found(renderer->scene) & ~renderer->settings.kept;
    json_t *object = json_object();
    if (renderer->scene->n_volumes == 0)
        json_object_set_new(object, "volumes", json_string("none in the scene: no slices, no tracking, no OpenVDB"));
    else if (renderer->frame.n == 0)
        json_object_set_new(object, "volumes", json_string("none in front of the cameras: no slices"));
    if (renderer->rig.lens_radius == 0.0f)
        json_object_set_new(object, "lens", json_string("pinhole cameras: no points on it are drawn"));
    for (int i = 0; lf_skip_at(i); i++) {
        if (skipped & lf_skip_at(i)->bit)
            json_object_set_new(object, lf_skip_at(i)->name, json_string(lf_skip_at(i)->what));
    }
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
