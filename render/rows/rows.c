/* Data that all rows of one scene and rig share: made once, and driven by the renderer. */
#include "render/rows/rows.h"

#include <stdlib.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "render/rows/light_paths.h"
#include "render/rows/outlines.h"
#include "render/rows/queue.h"
#include "render/scene/geometry.h"

static const lf_sharing *const table[] = {&lf_sharing_mvpt, &lf_sharing_vpt, &lf_sharing_amvpt};
#define N_SHARINGS (int)(sizeof table / sizeof table[0])

static const lf_integrator_entry *entry(int index)
{
    return index >= 0 && index < N_SHARINGS ? &table[index]->entry : NULL;
}

/* The sharing that keeps every pivot in its own pixel, for samples of single pixels. */
static const lf_sharing *find_native(void)
{
    int i = 0;
    while (i + 1 < N_SHARINGS && table[i]->entry.shares)
        i++;
    return table[i];
}

/* -------------------------------------------------------------------------------- make, free -- */

static void free_workers(lf_scratch *workers, int n)
{
    for (int i = 0; i < n && workers; i++) {
        lf_scratch *w = &workers[i];
        lf_media_finish(&w->media);
        lf_media_finish(&w->emission.emissive);
        lf_film_sums_finish(&w->sums);
        lf_section_finish(&w->section);
        lf_outlines_finish(&w->met.outlines);
        lf_section_finish(&w->alpha.section);
        lf_free(w->expected);
        lf_free(w->mirrors);
    }
    lf_free(workers);
}

static lf_status make_worker(const lf_rows *rows, const lf_film_layout *layout, lf_scratch *w)
{
    const size_t pixels = (size_t)layout->n_views * (size_t)layout->width;
    const bool mirrors = lf_has(&rows->seen, LF_TRAIT_MIRRORS),
               has_alphas = lf_has(&rows->seen, LF_TRAITS_SEEN_THROUGH),
               outlines = layout->has_features && rows->triangles.first;
    const lf_row_triangles *triangles = &rows->triangles;
    w->expected = lf_calloc(pixels, sizeof *w->expected);
    w->mirrors = mirrors ? lf_calloc(pixels, sizeof *w->mirrors) : NULL;
    w->section.rays.tracer = w->alpha.section.rays.tracer = w->met.outlines.edge.rays.tracer =
        w->met.outlines.alphas.rays.tracer = &w->tracer;
    if (!w->expected || (mirrors && !w->mirrors) ||
        lf_media_init(&w->media, &rows->frame) != LF_OK ||
        lf_media_init(&w->emission.emissive, &rows->emissive) != LF_OK ||
        lf_film_sums_init(&w->sums, layout) != LF_OK ||
        lf_section_init(&w->section, triangles->longest, triangles->n_instances) != LF_OK ||
        (outlines && lf_outlines_init(&w->met.outlines, triangles, has_alphas, layout) != LF_OK) ||
        lf_section_init(&w->alpha.section, has_alphas ? triangles->longest : 0,
                        triangles->n_instances) != LF_OK)
        return LF_E_NOMEM;
    return LF_OK;
}

static lf_status make_workers(lf_rows *rows, const lf_film_layout *layout)
{
    rows->workers = lf_calloc((size_t)rows->n_workers, sizeof *rows->workers);
    lf_status status = rows->workers ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < rows->n_workers && status == LF_OK; i++)
        status = make_worker(rows, layout, &rows->workers[i]);
    return status;
}

static void free_moments(lf_rows *rows)
{
    for (int i = 0; rows->moments && i < rows->n_workers; i++)
        lf_shutter_time_finish(&rows->moments[i]);
    lf_free(rows->moments);
}

static lf_status make_moments(lf_rows *rows)
{
    if (!lf_moving_moves(&rows->moving))
        return LF_OK;
    rows->moments = lf_calloc((size_t)rows->n_workers, sizeof *rows->moments);
    lf_status status = rows->moments ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < rows->n_workers && status == LF_OK; i++)
        status = lf_shutter_time_init(&rows->moments[i], &rows->moving);
    return status;
}

static lf_status make_queues(lf_rows *rows, const lf_sharing *sharing)
{
    if (!rows->lanes)
        return LF_OK;
    rows->queues = lf_calloc((size_t)rows->n_workers, sizeof *rows->queues);
    for (int i = 0; rows->queues && i < rows->n_workers; i++)
        lf_suffix_batch_init(&rows->queues[i].batch, rows->lanes, rows->suffixes,
                             sharing->suffixes);
    return rows->queues ? LF_OK : LF_E_NOMEM;
}

/* The scene's requirements for the film; sky if B is not stored. */
static lf_film_layout film_layout(const lf_scene *scene, const lf_render_settings *settings,
                                  const lf_rig *rig, bool light_paths, float sky[3])
{
    bool native = light_paths || lf_has(scene, LF_TRAIT_MIRRORS) || scene->equiangular.n > 0 ||
                  (lf_has(scene, LF_TRAITS_SEEN_THROUGH) && lf_has(scene, LF_TRAIT_EMISSION));
    bool uniform =
             !native && settings->skip & LF_SKIP_KNOWN_LIGHT && lf_unscattered_uniform(scene, sky),
         grids = false;
    for (int i = 0; i < scene->n_volumes; i++)
        grids = grids || (scene->volumes[i].kind == LF_VOLUME_GRID && !scene->volumes[i].nearest);
    return (lf_film_layout){.n_views = rig->n_views,
                            .width = rig->width,
                            .height = rig->height,
                            .has_w2 = lf_has(scene, LF_TRAIT_VIEW_LOBES),
                            .has_native = native,
                            .has_known = !uniform,
                            .has_delta = lf_has(scene, LF_TRAIT_MIRRORS),
                            .has_signed = grids,
                            .has_features = settings->features,
                            .has_albedo =
                                settings->features && lf_has(scene, LF_TRAIT_VARYING_ALBEDO)};
}

/* Passes per visit. Edges of surfaces need many row offsets and film points of B and q, which all
 * views of a visit share: a third of a cycle, rounded to a divisor of n. Media alone are smooth,
 * and their slices pay off over whole cycles; so does an integrator that shares nothing. A visit
 * has one shutter time, so with motion it is a fifth as long. (Equal-time relMSE of
 * scenes/motion.json: vpt 1.3 times less, mvpt 2 times.) */
static int passes_of_a_visit(const lf_scene *scene, bool moves, const lf_sharing *sharing, int n)
{
    const bool shares = scene->embree && sharing->entry.shares;
    const int parts = (shares ? 3 : 1) * (moves ? 5 : 1);
    int best = n;
    for (int g = moves ? 1 : (n + 6) / 7; 2 * g <= n && parts > 1; g++)
        if (n % g == 0 && abs(parts * g - n) < abs(parts * best - n))
            best = g;
    return best;
}

static void destroy(void *state)
{
    lf_rows *rows = state;
    if (!rows)
        return;
    free_workers(rows->workers, rows->n_workers);
    free_moments(rows);
    lf_free(rows->queues);
    lf_counts_finish(&rows->counts);
    lf_row_triangles_finish(&rows->triangles);
    lf_outline_map_finish(&rows->outlines);
    lf_light_paths_finish(&rows->light);
    lf_free(rows);
}

/* The rig at several shutter times; one if it does not move. */
typedef struct rig_track {
    int n;
    lf_rig at[LF_RIG_MOMENTS];
} rig_track;

static void find_track(const lf_rows *rows, rig_track *out)
{
    out->n = rows->moving.settings.camera.moves ? LF_RIG_MOMENTS : 1;
    for (int i = 0; i < out->n; i++)
        if (out->n == 1 || lf_rig_init_at(&out->at[i], &rows->moving.settings, rows->seen.origin,
                                          (double)i / (LF_RIG_MOMENTS - 1), NULL) != LF_OK)
            out->at[i] = rows->rig;
}

/* Allocates everything, so that later steps cannot run out of memory. */
static lf_status make_memory(lf_rows *rows, const lf_sharing *sharing, const lf_film_layout *layout,
                             const rig_track *track)
{
    lf_status status = LF_OK;
    if (rows->seen.n_meshes > 0)
        status =
            lf_row_triangles_init(&rows->triangles, &rows->seen, track->at, track->n, rows->pool);
    if (status == LF_OK && rows->triangles.first && layout->has_features &&
        !lf_moving_moves(&rows->moving))
        status = lf_outline_map_init(&rows->outlines, layout);
    if (status == LF_OK && sharing->adaptive)
        status = lf_counts_init(&rows->counts, layout->n_views, layout->width, layout->height);
    if (status != LF_OK)
        return status;
    rows->n_workers = lf_pool_threads(rows->pool);
    status = make_workers(rows, layout);
    if (status == LF_OK)
        status = make_moments(rows);
    return status == LF_OK ? make_queues(rows, sharing) : status;
}

static void make_plan(lf_rows *rows, const lf_integrator_input *input, const lf_sharing *sharing)
{
    const lf_render_settings *settings = input->settings;
    rows->plan = (lf_visit_plan){.scene = &rows->seen,
                                 .rig = &rows->rig,
                                 .frame = &rows->frame,
                                 .emissive = &rows->emissive,
                                 .kernels = lf_kernels_get(),
                                 .sharing = sharing,
                                 .native = find_native(),
                                 .triangles = rows->triangles.first ? &rows->triangles : NULL,
                                 .outlines = rows->outlines,
                                 .film = input->film,
                                 .sampler = settings->sampler,
                                 .max_depth = lf_max_depth(input->scene, settings->max_depth),
                                 .splitting = rows->splitting,
                                 .skip = settings->skip,
                                 .light = rows->light.plan.per_pass > 0 ? &rows->light : NULL,
                                 .pilot = sharing->adaptive ? &rows->counts : NULL};
}

static lf_status create(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err)
{
    const lf_sharing *sharing = table[index];
    lf_rows *rows = lf_calloc(1, sizeof *rows);
    if (!rows)
        return LF_E_NOMEM;
    lf_integrator_needs needs = {.sky = {0}};
    rows->seen = *input->seen;
    rows->pool = input->pool;
    rows->lanes = input->lanes;
    rows->suffixes = input->suffixes;
    lf_status status = lf_rig_init(&rows->rig, input->settings, input->scene->origin, err);
    rig_track track;
    if (status == LF_OK) {
        rows->moving = (lf_moving){&rows->seen, rows->rig, *input->settings};
        find_track(rows, &track);
        lf_media_frame_init(&rows->frame, input->scene->volumes, input->scene->n_volumes, track.at,
                            track.n);
        lf_media_frame_init(&rows->emissive, input->scene->emissive.field, input->scene->emissive.n,
                            track.at, track.n);
        if (sharing->entry.takes_light_paths)
            status = lf_light_paths_init(&rows->light, input, &rows->seen, &rows->rig,
                                         !sharing->entry.shares);
        rows->splitting = LF_SPLITTING_NONE;
    }
    if (status == LF_OK && sharing->entry.splits)
        status = lf_splitting_choose(input, &rows->seen, &rows->rig, rows->light.plan.per_pass > 0,
                                     !sharing->entry.shares, &rows->splitting);
    if (status == LF_OK) {
        needs.layout =
            film_layout(&rows->seen, input->settings, &rows->rig,
                        rows->light.plan.per_pass > 0 && !input->settings->features, needs.sky);
        needs.visit_passes = passes_of_a_visit(input->scene, lf_moving_moves(&rows->moving),
                                               sharing, rows->rig.n_views);
        status = make_memory(rows, sharing, &needs.layout, &track);
    }
    if (status != LF_OK) {
        destroy(rows);
        return status;
    }
    rows->light.workers = rows->workers;
    rows->light.plan.splitting = rows->splitting;
    make_plan(rows, input, sharing);
    *out_state = rows;
    *out_needs = needs;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ visits -- */

/* Makes the map of an adaptive integrator once, after its pilot. If this fails, only the gain is
 * lost. */
static void make_map(lf_rows *rows)
{
    if (rows->mapped || !rows->plan.sharing->adaptive || !lf_adaptive_ready(rows->plan.film))
        return;
    rows->mapped = true;
    if (lf_adaptive_map(rows->plan.film, rows->pool, &rows->counts) == LF_OK)
        rows->plan.counts = &rows->counts;
    rows->plan.pilot = NULL;
}

static lf_status begin(void *state, const lf_pass *pass, const lf_cancel *cancel)
{
    lf_rows *rows = state;
    make_map(rows);
    if (!rows->plan.light)
        return LF_OK;
    const double start = lf_time_cpu();
    const lf_status status = lf_light_paths_begin(&rows->light, pass, rows->plan.film, cancel);
    rows->light.cpu += lf_time_cpu() - start;
    return status;
}

static bool visit(void *state, const lf_visit_order *order, int row, int half, int worker,
                  const lf_cancel *cancel)
{
    const lf_rows *rows = state;
    lf_visit_plan plan = rows->plan;
    plan.order = *order;
    plan.counts = order->column_step == 1 ? plan.counts : NULL;
    plan.queue = rows->queues ? &rows->queues[worker] : NULL;
    if (rows->moments) {
        plan.shutter = &rows->moments[worker];
        plan.moving = &rows->moving;
        plan.scene = &plan.shutter->scene;
        plan.rig = &plan.shutter->rig;
    }
    return lf_visit_row(&plan, row, half, &rows->workers[worker], cancel);
}

/* ----------------------------------------------------------------------------------- reports -- */

static void count(const void *state, lf_render_stats *out)
{
    const lf_rows *rows = state;
    for (int i = 0; i < rows->n_workers; i++) {
        const lf_scratch *w = &rows->workers[i];
        lf_integrator_count(out, &w->tracer, w->base_paths, w->contributions);
        out->base_hidden += w->base_hidden;
    }
    out->light_path_cpu += rows->light.cpu;
    if (!rows->seen.embree)
        out->rays_traced = out->base_hidden = -1;
    if (rows->seen.n_volumes == 0)
        out->volume_lookups = -1;
}

static void skipped(const void *state, json_t *out)
{
    const lf_rows *rows = state;
    if (rows->seen.n_volumes == 0)
        json_object_set_new(out, "volumes",
                            json_string("none in the scene: no slices, no tracking, no OpenVDB"));
    else if (rows->frame.n == 0)
        json_object_set_new(out, "volumes", json_string("none in front of the cameras: no slices"));
    if (rows->rig.lens_radius == 0.0f && rows->rig.blur == 0.0f && rows->rig.blur_up == 0.0f)
        json_object_set_new(out, "lens",
                            json_string("pinhole cameras: no lens points are sampled"));
}

const lf_integrator lf_integrator_rows = {.skips = LF_SKIP_ALL,
                                          .entry = entry,
                                          .create = create,
                                          .begin = begin,
                                          .visit = visit,
                                          .count = count,
                                          .skipped = skipped,
                                          .destroy = destroy};
