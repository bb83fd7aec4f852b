/* Integrators that know no rows: their table, visits and memory. */
#include "render/papers/general.h"

#include "render/papers/alike.h"

#include <stdlib.h>

#include "base/alloc.h"
#include "render/papers/amv2019.h"
#include "render/papers/count.h"
#include "render/papers/share.h"

static const lf_general_kind *const table[] = {&lf_general_mvpt2022, &lf_general_mismvpt,
                                               &lf_general_amvpt2022, &lf_general_amv2019,
                                               &lf_general_amv2019k};
#define N_KINDS (int)(sizeof table / sizeof table[0])

/* ------------------------------------------------------------------------------ base samples -- */

/* Which pixel, and what its sample is worth to it. */
typedef struct lf_general_pixel {
    int row, view, column;
    float alone;
} lf_general_pixel;

static void base_sample(const lf_general *g, lf_general_worker *w, const lf_general_pixel *of,
                        uint64_t key, uint32_t index)
{
    lf_sampler sampler;
    uint64_t pixel =
        lf_hash64(key, (uint64_t)of->view * (uint64_t)g->rig.width + (uint64_t)of->column + 16);
    lf_prefix p = {.row = of->row,
                   .view = of->view,
                   .column = of->column,
                   .alone = of->alone,
                   .sampler = &sampler};
    w->base_paths++;
    lf_sampler_init(&sampler, g->sampler, pixel, index);
    w->tracer.rng = lf_hash64(pixel, ~(uint64_t)index);
    lf_prefix_draw(g, w, &p);
    if (p.event.kind == LF_EVENT_ESCAPE) {
        lf_share_alone(g, w, &p, lf_rig_sky(&g->rig, &g->seen, p.event.w, p.my));
        return;
    }
    if (p.event.kind == LF_EVENT_SURFACE && w->sums.native)
        lf_share_deltas(g, w, &p);
    if (!lf_share_possible(g, &p))
        lf_share_alone(g, w, &p, lf_v3(0.0f, 0.0f, 0.0f));
    else if (g->kind->weigh(g, w, &p))
        lf_share_spread(g, w, &p);
    else
        w->tracer.nonfinite++;
}

/* ------------------------------------------------------------------------------------ visits -- */

/* The current visit. */
typedef struct lf_general_visit {
    const lf_visit_order *order;
    const lf_cancel *cancel;
    int row;
    uint64_t key;   /* of the half's stream */
    uint32_t index; /* of the visit in it */
    double n;       /* native samples per view pixel before it */
} lf_general_visit;

static bool cancelled(const lf_general_visit *v)
{
    return v->cancel && atomic_load_explicit(v->cancel, memory_order_relaxed);
}

static bool sample_lattice(const lf_general *g, lf_general_worker *w, const lf_general_visit *v)
{
    const lf_visit_lattice lattice =
        lf_visit_lattice_of(v->order, v->key, v->n, v->index, g->rig.n_views);
    for (int column = lattice.first; column < g->rig.width; column += v->order->column_step)
        for (int j = 0; j < v->order->subsets; j++) {
            const lf_general_pixel of = {v->row, lf_visit_lattice_view(&lattice, column, j), column,
                                         1.0f};
            if (cancelled(v))
                return false;
            base_sample(g, w, &of, v->key, v->index);
        }
    return true;
}

/* As many samples as the map expects; each map has separate random numbers. */
static bool sample_counts(const lf_general *g, lf_general_worker *w, const lf_general_visit *v)
{
    const uint64_t key = lf_hash64(v->key, 64 + (uint64_t)g->n_maps);
    const double given = (double)v->order->subsets / g->rig.n_views;
    for (int view = 0; view < g->rig.n_views; view++)
        for (int column = 0; column < g->rig.width; column++) {
            uint64_t pixel = (uint64_t)view * (uint64_t)g->rig.width + (uint64_t)column;
            double phase = (double)(lf_hash64(key, pixel) >> 11) * 0x1p-53;
            lf_count_share share =
                lf_count_share_of(lf_expected_count(g, w, view, column), phase, v->n, given);
            const lf_general_pixel of = {v->row, view, column, share.alone};
            for (uint32_t i = share.begin; i < share.end; i++) {
                if (cancelled(v))
                    return false;
                base_sample(g, w, &of, key, i);
            }
        }
    return true;
}

/* Values that are constant in a visit: q is 1, B is 0, and W if estimates are divided by n. */
static void begin_sums(const lf_general *g, lf_general_worker *w, double given)
{
    lf_film_sums_begin(&w->sums);
    for (size_t i = 0; i < (size_t)g->rig.n_views * (size_t)g->rig.width; i++) {
        lf_film_pivots(&w->sums, i, 1.0f);
        if (w->sums.known)
            lf_film_known_light(&w->sums, i, 0.0f, 0.0f, 0.0f);
        if (g->kind->mis)
            lf_film_weigh(&w->sums, i, (float)(given / g->rig.n_views));
    }
}

static bool visit(void *the_state, const lf_visit_order *order, int row, int half, int worker_index,
                  const lf_cancel *cancel)
{
    const lf_general *g = the_state;
    lf_general_worker *w = &g->workers[worker_index];
    const lf_film_counts *before = &g->film->streams[order->stream].rows[row];
    const lf_general_visit v = {.order = order,
                                .cancel = cancel,
                                .row = row,
                                .key = lf_visit_key(order->random, row, half),
                                .index = before->visits[half],
                                .n = before->n[half]};
    if (order->subsets == 0)
        return true; /* every pixel has a sample of its own after n_views passes */
    const double given = (double)order->subsets / order->column_step;
    lf_film_meet(g->film, row, true);
    begin_sums(g, w, given);
    w->mapped = g->n_maps > 0 && order->column_step == 1;
    if (w->mapped)
        lf_counts_row(&g->counts, row, w->expected);
    if (w->mapped ? !sample_counts(g, w, &v) : !sample_lattice(g, w, &v))
        return false;
    lf_film_merge(g->film, order->stream, row, half, &w->sums, given,
                  lf_hash64(lf_hash64(v.key, 9), v.index));
    return true;
}

/* Whether all rows have n native samples per view pixel in both halves. */
static bool has_samples(const lf_film *film, double n)
{
    for (int row = 0; row < film->height; row++)
        if (film->rows[row].n[0] < n || film->rows[row].n[1] < n)
            return false;
    return true;
}

/* Makes the map after the pilot; kinds with repeated maps make one whenever samples have doubled.
 * If this fails, only the gain is lost. */
static lf_status begin(void *the_state, const lf_pass *pass, const lf_cancel *cancel)
{
    lf_general *g = the_state;
    (void)pass, (void)cancel;
    if (!g->kind->adaptive || !lf_adaptive_ready(g->film) || !has_samples(g->film, g->next_map))
        return LF_OK;
    lf_status status = g->kind->map ? g->kind->map(g->film, &g->counts)
                                    : lf_adaptive_map(g->film, g->pool, &g->counts);
    g->n_maps += status == LF_OK;
    while (g->kind->map && has_samples(g->film, g->next_map))
        g->next_map *= 2.0;
    if (!g->kind->map)
        g->next_map = (double)INFINITY;
    return LF_OK;
}

/* -------------------------------------------------------------------------------- make, free -- */

static const lf_integrator_entry *entry(int index)
{
    return index >= 0 && index < N_KINDS ? &table[index]->entry : NULL;
}

static void destroy(void *the_state)
{
    lf_general *g = the_state;
    for (int i = 0; g && g->workers && i < g->n_workers; i++) {
        lf_film_sums_finish(&g->workers[i].sums);
        lf_free(g->workers[i].expected);
    }
    if (g) {
        lf_counts_finish(&g->counts);
        lf_free(g->share_seen);
        lf_free(g->workers);
    }
    lf_free(g);
}

static lf_status make_counts(lf_general *g, lf_general_worker *w)
{
    if (!g->kind->adaptive)
        return LF_OK;
    w->expected = lf_calloc((size_t)g->rig.n_views * (size_t)g->rig.width, sizeof *w->expected);
    return w->expected ? LF_OK : LF_E_NOMEM;
}

static lf_status make_workers(lf_general *g, const lf_film_layout *layout)
{
    g->workers = lf_calloc((size_t)g->n_workers, sizeof *g->workers);
    for (int i = 0; g->workers && i < g->n_workers; i++) {
        lf_general_worker *w = &g->workers[i];
        w->tracer.scene = &g->seen;
        if (lf_film_sums_init(&w->sums, layout) != LF_OK || make_counts(g, w) != LF_OK)
            return LF_E_NOMEM;
    }
    if (!g->workers)
        return LF_E_NOMEM;
    return g->kind->adaptive
               ? lf_counts_init(&g->counts, layout->n_views, layout->width, layout->height)
               : LF_OK;
}

static lf_status create(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err)
{
    const lf_choices *choices = &input->settings->choices;
    if (lf_media_path_depth_bound(input->scene) > LF_MAX_NULL_DEPTH)
        return lf_error_set(
            err, LF_E_ARG, "integrator",
            "%s supports media of at most 2900 mean free paths at their largest extinction",
            table[index]->entry.name);
    lf_general *g = lf_calloc(1, sizeof *g);
    if (!g)
        return LF_E_NOMEM;
    g->seen = *input->seen;
    g->film = input->film;
    g->pool = input->pool;
    g->next_map = LF_PILOT_SPP;
    g->shift = lf_shift_at(choices->of[LF_PAPERS_SHIFT]);
    g->kind = table[index];
    g->selection = g->kind->entry.takes & LF_PAPERS_TAKES(SELECTION)
                       ? lf_selection_at(choices->of[LF_PAPERS_SELECTION])
                       : &lf_selection_none;
    g->sampler = input->settings->sampler;
    g->max_depth = lf_max_depth(input->scene, input->settings->max_depth);
    g->n_workers = lf_pool_threads(input->pool);
    lf_status status =
        g->shift && g->selection
            ? lf_rig_init(&g->rig, input->settings, input->scene->origin, err)
            : lf_error_set(err, LF_E_ARG, "integrator", "unknown shift or selection");
    const bool delta = lf_has(&g->seen, LF_TRAIT_MIRRORS);
    const lf_integrator_needs needs = {.layout = {.n_views = g->rig.n_views,
                                                  .width = g->rig.width,
                                                  .height = g->rig.height,
                                                  .has_native = delta,
                                                  .has_known = delta,
                                                  .has_delta = delta},
                                       .visit_passes = g->rig.n_views};
    if (status == LF_OK)
        status = make_workers(g, &needs.layout);
    if (status == LF_OK && g->kind->normalises)
        status = lf_normalise(g);
    if (status != LF_OK) {
        destroy(g);
        return status;
    }
    *out_state = g;
    *out_needs = needs;
    return LF_OK;
}

static void count(const void *the_state, lf_render_stats *out)
{
    const lf_general *g = the_state;
    for (int i = 0; i < g->n_workers; i++) {
        const lf_general_worker *w = &g->workers[i];
        lf_integrator_count(out, &w->tracer, w->base_paths, w->contributions);
    }
    out->base_hidden = -1;
    if (!g->seen.embree)
        out->rays_traced = -1;
    if (g->seen.n_volumes == 0)
        out->volume_lookups = -1;
}

const lf_integrator lf_integrator_general = {.skips = LF_SKIP_SURFACES | LF_SKIP_DELTA_LOBES |
                                                      LF_SKIP_EMISSION,
                                             .entry = entry,
                                             .create = create,
                                             .begin = begin,
                                             .visit = visit,
                                             .count = count,
                                             .destroy = destroy};
