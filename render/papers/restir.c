#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/papers/restir.h"

#include "render/papers/alike.h"
#include "render/papers/papers.h"
#include "render/papers/restir_state.h"

enum { RESTIR, MVRESTIR, N_ENTRIES };

static const lf_integrator_entry entries[N_ENTRIES] = {
    [RESTIR] = {.name = "restir",
                .what = "reservoirs of paths, each view alone, as in 2021",
                .takes = LF_PAPERS_TAKES(REUSE) | LF_PAPERS_TAKES(WEIGHTS),
                .remembers = true,
                .supports = LF_REFERENCE_SUPPORT},
    [MVRESTIR] = {.name = "mvrestir",
                  .what = "the same with neighbours in other views",
                  .shares = true,
                  .takes = LF_PAPERS_TAKES(REUSE) | LF_PAPERS_TAKES(WEIGHTS),
                  .remembers = true,
                  .supports = LF_REFERENCE_SUPPORT}};

/* The first is the default, the paper's own. */
static const lf_restir_reuse reuses[] = {
    {"both", LF_RESTIR_DRAWN, true, LF_RESTIR_WALKS},
    {"spatial", LF_RESTIR_DRAWN, false, LF_RESTIR_WALKS},
    {"temporal", LF_RESTIR_ALONE, true, LF_RESTIR_WALKS},
    {"none", LF_RESTIR_ALONE, false, LF_RESTIR_WALKS},
    {"vertices", LF_RESTIR_BLOCKS, false, LF_RESTIR_BLOCK_WALKS}};

/* Memory of reservoirs, of all view pixels and both halves. */
#define MAX_BYTES ((size_t)2 << 30)

/* Pixels that are shaded together. */
enum { SHADED = 16 };

/* The reservoirs of earlier visits of this half, if they were this visit's predecessors. */
static lf_restir_left *left_of(const lf_restir *s, int row, int half, uint64_t random,
                               uint32_t visits)
{
    lf_restir_left *left = s->rows ? &s->rows[2 * row + half] : NULL;
    if (left && !(left->used && left->random == random && left->visits == visits)) {
        for (int i = 0; i < s->rig.n_views * s->rig.width; i++)
            left->pixels[i].sample.m = 0.0;
        left->used = 0;
    }
    return left;
}

/* ------------------------------------------------------------------------------------ visits -- */

/* As of mvpt2022: each pixel with probability subsets / n_views, each once in any n_views passes.
 */
static void choose(const lf_restir *s, lf_restir_worker *w, const lf_visit_order *order,
                   uint64_t key, const lf_film_counts *before, int half)
{
    const int views = s->rig.n_views;
    const lf_visit_lattice lattice =
        lf_visit_lattice_of(order, key, before->n[half], before->visits[half], views);
    w->n_visited = 0;
    for (int i = 0; i < views * s->rig.width; i++)
        w->pixels[i].sample.m = 0.0;
    for (int column = lattice.first; column < s->rig.width; column += order->column_step)
        for (int j = 0; j < order->subsets; j++)
            w->visited[w->n_visited++] =
                lf_visit_lattice_view(&lattice, column, j) * s->rig.width + column;
}

/* Exact depths of some pixels' paths, and of the whole rays of paths that find a sky, all in lanes.
 */
static void find_depths(const lf_restir *s, lf_restir_worker *w, int n, const int *at,
                        double *paths, double *whole)
{
    lf_depth_ray rays[SHADED * (LF_MAX_PATH_VERTICES + 2)];
    double depths[SHADED * (LF_MAX_PATH_VERTICES + 2)], *next = depths;
    int n_rays = 0;
    for (int i = 0; i < n; i++) {
        const lf_restir_pixel *p = &w->pixels[at[i]];
        if (p->sample.kept) {
            lf_light_path_segments(&s->space, &p->ray, &p->sample.path, rays + n_rays);
            n_rays += p->sample.path.n + 1;
        }
        if (lf_max3(p->ray.sky) > 0.0f)
            rays[n_rays++] = (lf_depth_ray){p->ray.o, p->ray.w, (double)INFINITY};
    }
    lf_depths_along(&w->tracer, n_rays, rays, depths);
    for (int i = 0; i < n; i++) {
        const lf_restir_pixel *p = &w->pixels[at[i]];
        paths[i] = 0.0;
        for (int k = 0; p->sample.kept && k <= p->sample.path.n; k++)
            paths[i] += *next++;
        whole[i] = lf_max3(p->ray.sky) > 0.0f ? *next++ : 0.0;
    }
}

static void shade(const lf_restir *s, lf_restir_worker *w, int n, const int *at)
{
    double paths[SHADED] = {0}, whole[SHADED] = {0};
    find_depths(s, w, n, at, paths, whole);
    for (int i = 0; i < n; i++) {
        const lf_restir_pixel *p = &w->pixels[at[i]];
        lf_vec3 y = lf_path_sample_radiance(&p->sample, paths[i]);
        if (!isfinite(y.x + y.y + y.z)) {
            w->tracer.nonfinite++;
            y = lf_v3(0.0f, 0.0f, 0.0f);
        }
        y = lf_madd(y, expf(-(float)whole[i]), p->ray.sky);
        lf_film_scatter(&w->sums, (size_t)at[i], y.x, y.y, y.z);
        w->contributions++;
    }
}

/* Algorithm 1: false: cancelled. */
static bool run_visit(const lf_restir *s, lf_restir_worker *w, const lf_restir_left *left, int row,
                      uint64_t key, uint32_t index, const lf_cancel *cancel)
{
    const int at_once = LF_MAX_WALKS / s->reuse->walks;
    for (int i = 0; i < w->n_visited; i += at_once) {
        const int n = i + at_once < w->n_visited ? at_once : w->n_visited - i;
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return false;
        lf_restir_begin(s, w, row, n, w->visited + i, key, index);
        for (int k = i; left && left->used && k < i + n; k++)
            lf_restir_look_back(s, w, left, w->visited[k]);
    }
    if (!lf_restir_look_beside(s, w, lf_hash64(lf_hash64(key, 10), index), cancel))
        return false;
    for (int i = 0; i < w->n_visited; i += SHADED)
        shade(s, w, i + SHADED < w->n_visited ? SHADED : w->n_visited - i, w->visited + i);
    return true;
}

static bool visit(void *the_state, const lf_visit_order *order, int row, int half, int worker_index,
                  const lf_cancel *cancel)
{
    const lf_restir *s = the_state;
    lf_restir_worker *w = &s->workers[worker_index];
    const lf_film_counts *before = &s->film->streams[order->stream].rows[row];
    const uint32_t index = before->visits[half];
    const uint64_t key = lf_visit_key(order->random, row, half);
    const double given = (double)order->subsets / order->column_step;
    if (order->subsets == 0)
        return true; /* every pixel has a sample of its own after n_views passes */
    lf_restir_left *left = left_of(s, row, half, order->random, index);
    lf_film_meet(s->film, row, true);
    lf_film_sums_begin(&w->sums);
    for (size_t i = 0; i < (size_t)s->rig.n_views * (size_t)s->rig.width; i++) {
        lf_film_pivots(&w->sums, i, 1.0f);
        lf_film_weigh(&w->sums, i, (float)(given / s->rig.n_views));
    }
    choose(s, w, order, key, before, half);
    if (!run_visit(s, w, left, row, key, index, cancel))
        return false;
    for (int i = 0; left && i < w->n_visited; i++)
        left->pixels[w->visited[i]] = w->pixels[w->visited[i]];
    if (left) {
        left->random = order->random;
        left->visits = index + 1;
        left->used = 1;
    }
    lf_film_merge(s->film, order->stream, row, half, &w->sums, given,
                  lf_hash64(lf_hash64(key, 9), index));
    return true;
}

/* -------------------------------------------------------------------------------- make, free -- */

const char *lf_reuse_name(int reuse)
{
    return reuse >= 0 && reuse < (int)(sizeof reuses / sizeof reuses[0]) ? reuses[reuse].name
                                                                         : NULL;
}

const char *lf_reuse_weights_name(int weights)
{
    static const char *const names[] = {"unbiased", "biased"};
    return weights >= LF_REUSE_UNBIASED && weights <= LF_REUSE_BIASED ? names[weights] : NULL;
}

static const lf_integrator_entry *entry(int index)
{
    return index >= 0 && index < N_ENTRIES ? &entries[index] : NULL;
}

static void destroy(void *the_state)
{
    lf_restir *s = the_state;
    for (int i = 0; s && s->workers && i < s->n_workers; i++) {
        lf_restir_worker *w = &s->workers[i];
        lf_film_sums_finish(&w->sums);
        lf_free(w->walks);
        lf_free(w->pixels);
        lf_free(w->spread);
        lf_free(w->visited);
        lf_free(w->order);
    }
    if (!s)
        return;
    lf_coarse_grid_finish(&s->coarse);
    lf_free(s->workers);
    lf_free(s->rows);
    lf_free(s->all_pixels);
    lf_free(s);
}

static lf_status make_workers(lf_restir *s, const lf_film_layout *layout)
{
    size_t pixels = (size_t)layout->n_views * (size_t)layout->width;
    s->workers = lf_calloc((size_t)s->n_workers, sizeof *s->workers);
    for (int i = 0; s->workers && i < s->n_workers; i++) {
        lf_restir_worker *w = &s->workers[i];
        w->tracer.scene = &s->seen;
        w->walks = lf_calloc(LF_MAX_WALKS, sizeof *w->walks);
        w->pixels = lf_calloc(pixels, sizeof *w->pixels);
        w->spread = lf_calloc(pixels, sizeof *w->spread);
        w->visited = lf_calloc(pixels, sizeof *w->visited);
        w->order = lf_calloc(pixels, sizeof *w->order);
        if (lf_film_sums_init(&w->sums, layout) != LF_OK || !w->walks || !w->pixels || !w->spread ||
            !w->visited || !w->order)
            return LF_E_NOMEM;
    }
    return s->workers ? LF_OK : LF_E_NOMEM;
}

static lf_status make_history(lf_restir *s, const lf_film_layout *layout, lf_error *err)
{
    size_t row = (size_t)layout->n_views * (size_t)layout->width, rows = 2 * (size_t)layout->height;
    if (!s->reuse->temporal)
        return LF_OK;
    if (row * sizeof(lf_restir_pixel) > MAX_BYTES / rows)
        return lf_error_set(err, LF_E_ARG, "integrator",
                            "reservoirs of %d views of %dx%d pixels need more than 2 GiB; use "
                            "--reuse spatial, which keeps none",
                            layout->n_views, layout->width, layout->height);
    s->rows = lf_calloc(rows, sizeof *s->rows);
    s->all_pixels = lf_calloc(rows * row, sizeof *s->all_pixels);
    for (size_t i = 0; s->rows && s->all_pixels && i < rows; i++)
        s->rows[i].pixels = &s->all_pixels[i * row];
    return s->rows && s->all_pixels ? LF_OK : LF_E_NOMEM;
}

static lf_status create(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err)
{
    const lf_render_settings *settings = input->settings;
    if (lf_max_depth(input->scene, settings->max_depth) > LF_MAX_PATH_VERTICES)
        return lf_error_set(err, LF_E_ARG, "integrator",
                            "%s supports paths of at most 16 vertices; use --max-depth 16 or less",
                            entries[index].name);
    const int reuse = settings->choices.of[LF_PAPERS_REUSE],
              weights = settings->choices.of[LF_PAPERS_WEIGHTS];
    if (!lf_reuse_name(reuse) || !lf_reuse_weights_name(weights))
        return lf_error_set(err, LF_E_ARG, "integrator", "unknown reuse or weights");
    if (reuses[reuse].beside == LF_RESTIR_BLOCKS && weights != LF_REUSE_UNBIASED)
        return lf_error_set(err, LF_E_ARG, "integrator",
                            "--reuse %s supports only --weights unbiased", reuses[reuse].name);
    lf_restir *s = lf_calloc(1, sizeof *s);
    if (!s)
        return LF_E_NOMEM;
    s->seen = *input->seen;
    s->film = input->film;
    s->across = index == MVRESTIR;
    s->reuse = &reuses[reuse];
    s->weights = (lf_reuse_weights)weights;
    s->sampler = settings->sampler;
    s->n_workers = lf_pool_threads(input->pool);
    s->space =
        (lf_path_space){&s->seen, &s->coarse, lf_max_depth(input->scene, settings->max_depth)};
    lf_status status = lf_rig_init(&s->rig, settings, input->scene->origin, err);
    const lf_integrator_needs needs = {
        .layout = {.n_views = s->rig.n_views, .width = s->rig.width, .height = s->rig.height},
        .visit_passes = s->rig.n_views};
    if (status == LF_OK)
        status = lf_coarse_grid_init(&s->coarse, &s->seen, input->pool);
    if (status == LF_OK)
        status = make_workers(s, &needs.layout);
    if (status == LF_OK)
        status = make_history(s, &needs.layout, err);
    if (status != LF_OK) {
        destroy(s);
        return status;
    }
    *out_state = s;
    *out_needs = needs;
    return LF_OK;
}

static lf_status begin(void *the_state, const lf_pass *pass, const lf_cancel *cancel)
{
    (void)the_state, (void)pass, (void)cancel;
    return LF_OK;
}

static void count(const void *the_state, lf_render_stats *out)
{
    const lf_restir *s = the_state;
    for (int i = 0; i < s->n_workers; i++) {
        const lf_restir_worker *w = &s->workers[i];
        lf_integrator_count(out, &w->tracer, w->base_paths, w->contributions);
    }
    out->rays_traced = out->base_hidden = -1;
}

const lf_integrator lf_integrator_restir = {.entry = entry,
                                            .create = create,
                                            .begin = begin,
                                            .visit = visit,
                                            .count = count,
                                            .destroy = destroy};
