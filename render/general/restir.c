#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/general/restir.h"

#include "render/general/alike.h"
#include "render/general/reuse.h"
#include "render/rows/rig.h"
#include "render/transport/sampler.h"

enum { RESTIR, MVRESTIR, N_ENTRIES };

static const lf_integrator_entry entries[N_ENTRIES] = {
    [RESTIR] = {.name = "restir",
                .what = "reservoirs of paths, each view alone, as in 2021",
                .reuses = true},
    [MVRESTIR] = {.name = "mvrestir",
                  .what = "the same with neighbours in other views",
                  .shares = true,
                  .reuses = true}};

/* What reservoirs are put together with. The first is the default, the paper's own. */
static const struct {
    const char *name;
    bool spatial, temporal;
} reuses[] = {{"both", true, true},
              {"spatial", true, false},
              {"temporal", false, true},
              {"none", false, false}};

/* Memory of reservoirs, of all view pixels and both halves. */
#define MAX_BYTES ((size_t)2 << 30)

/* A view pixel of a row. */
typedef struct pixel {
    lf_camera_ray ray;
    lf_path_sample sample;
} pixel;

/* What one half of a row was left with. */
typedef struct left_over {
    uint64_t random;
    uint32_t visits, used; /* by how many; 0: nothing is there */
    pixel *pixels;         /* [view][column] */
} left_over;

typedef struct worker {
    lf_tracer tracer;
    lf_film_sums sums;
    int64_t base_paths, contributions;
    pixel *pixels;          /* [view][column] of this visit */
    lf_path_sample *spread; /* the same, put together with their neighbours */
    int *visited;           /* [view * width] those that this visit takes */
    int n_visited;
} worker;

typedef struct state {
    lf_scene seen;
    lf_rig rig;
    lf_film *film;
    lf_coarse_grid coarse;
    lf_path_space space;
    bool across; /* neighbours are of other views, and distances count from the window */
    int reuse;
    lf_reuse_weights weights;
    lf_sampler_kind sampler;
    int n_workers;
    worker **workers;  /* [n_workers] each its own */
    left_over *rows;   /* [height][2]; NULL unless there is temporal reuse */
    pixel *all_pixels; /* [height][2][view][column], theirs */
} state;

/* ------------------------------------------------------------------------------------- pixels --
 */

/* A ray of a view pixel, through a film point and a lens point of its own. */
static void aim(const state *s, int row, int view, int column, lf_sampler *sampler,
                lf_camera_ray *out)
{
    const lf_rig *rig = &s->rig;
    float film[2], lens[2], chord;
    lf_row_plane plane;
    lf_sampler_2d(sampler, film);
    lf_sampler_2d(sampler, lens);
    lf_rig_row_plane(rig, (float)row + film[1], lens, &plane);
    chord = (2.0f * lf_sampler_1d(sampler) - 1.0f) * plane.lens_chord;
    float slope = lf_rig_slope(rig, view, (float)column + film[0]) - chord / rig->focus;
    out->o = lf_rig_point(rig, rig->b[view] + chord, plane.ly, 0.0f);
    out->w = lf_normalize(lf_rig_direction(rig, slope, plane.my, 1.0f));
    out->sky = lf_rig_sky(&s->rig, &s->seen, out->w, plane.my);
    out->from = s->across ? rig->distance / lf_dot(out->w, rig->forward) : 0.0f;
    out->depth = lf_coarse_grid_depth(&s->coarse, out->o, out->w, (double)INFINITY);
}

/* A ray and the reservoir of its walks. */
static void begin_pixel(const state *s, worker *w, int row, int at, uint64_t key, uint32_t index)
{
    uint64_t own = lf_hash64(key, (uint64_t)at + 16);
    lf_sampler sampler;
    lf_sampler_init(&sampler, s->sampler, own, index);
    w->tracer.rng = lf_hash64(own, ~(uint64_t)index);
    aim(s, row, at / s->rig.width, at % s->rig.width, &sampler, &w->pixels[at].ray);
    lf_path_sample_draw(&s->space, &w->pixels[at].ray, LF_RESTIR_WALKS, &w->tracer,
                        &w->pixels[at].sample);
    w->base_paths += LF_RESTIR_WALKS;
}

/* -------------------------------------------------------------------------------------- reuse --
 */

static lf_reuse_input input_of(const lf_path_sample *sample, const lf_camera_ray *ray)
{
    return (lf_reuse_input){sample, ray, sample->m};
}

/* With what an earlier visit has left in the pixel. */
static void look_back(const state *s, worker *w, const left_over *before, int at)
{
    const pixel *old = &before->pixels[at];
    pixel *own = &w->pixels[at];
    lf_path_sample out;
    if (!(old->sample.m > 0.0))
        return;
    lf_reuse_input inputs[2] = {input_of(&own->sample, &own->ray),
                                input_of(&old->sample, &old->ray)};
    inputs[1].m = fmin(inputs[1].m, LF_RESTIR_HISTORY * own->sample.m);
    lf_path_sample_combine(&s->space, 2, inputs, s->weights, &w->tracer, &out);
    own->sample = out;
}

/* A number within reach of 0, either way alike; never 0. */
static int draw_step(worker *w, int reach)
{
    int step = (int)(lf_rng(&w->tracer) * 2.0f * (float)reach);
    return step - reach + (step >= reach);
}

/* A pixel beside this one, -1: there is none. In another view: near where that has the same place
 * in the window. */
static int draw_neighbour(const state *s, worker *w, int at)
{
    int view = at / s->rig.width, column = at % s->rig.width;
    if (s->across) {
        view += draw_step(w, LF_MVRESTIR_VIEWS);
        column += (int)(lf_rng(&w->tracer) * (2 * LF_MVRESTIR_REACH + 1)) - LF_MVRESTIR_REACH;
    } else {
        column += draw_step(w, LF_RESTIR_REACH);
    }
    return view >= 0 && view < s->rig.n_views && column >= 0 && column < s->rig.width
               ? view * s->rig.width + column
               : -1;
}

/* With neighbours in the same visit. */
static void look_beside(const state *s, worker *w, int at)
{
    lf_reuse_input inputs[1 + LF_RESTIR_NEIGHBOURS] = {
        input_of(&w->pixels[at].sample, &w->pixels[at].ray)};
    int n = 1;
    for (int i = 0; i < LF_RESTIR_NEIGHBOURS; i++) {
        int beside = draw_neighbour(s, w, at);
        if (beside >= 0 && w->pixels[beside].sample.m > 0.0)
            inputs[n++] = input_of(&w->pixels[beside].sample, &w->pixels[beside].ray);
    }
    lf_path_sample_combine(&s->space, n, inputs, s->weights, &w->tracer, &w->spread[at]);
}

/* What earlier visits of this half left, as far as they were this one's predecessors. */
static left_over *left_of(const state *s, int row, int half, uint64_t random, uint32_t visits)
{
    left_over *left = s->rows ? &s->rows[2 * row + half] : NULL;
    if (left && !(left->used && left->random == random && left->visits == visits)) {
        for (int i = 0; i < s->rig.n_views * s->rig.width; i++)
            left->pixels[i].sample.m = 0.0;
        left->used = 0;
    }
    return left;
}

/* ------------------------------------------------------------------------------------- visits --
 */

/* As of mvpt2022: each pixel with probability subsets / n_views, each once in any n_views passes.
 */
static void choose(const state *s, worker *w, const lf_visit_order *order, uint64_t key,
                   const lf_film_counts *before, int half)
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

static void shade(const state *s, worker *w, int at)
{
    const lf_path_sample *sample = &w->pixels[at].sample;
    const lf_camera_ray *ray = &w->pixels[at].ray;
    lf_vec3 y = {0.0f, 0.0f, 0.0f};
    if (sample->kept)
        y = lf_scale(lf_light_path_radiance(&s->space, ray, &sample->path, &w->tracer),
                     (float)sample->weight);
    if (!isfinite(y.x + y.y + y.z)) {
        w->tracer.nonfinite++;
        y = lf_v3(0.0f, 0.0f, 0.0f);
    }
    y = lf_add(y, lf_camera_ray_behind(ray, &w->tracer));
    lf_film_scatter(&w->sums, (size_t)at, y.x, y.y, y.z);
    w->contributions++;
}

/* Algorithm 1: false: cancelled. */
static bool run_visit(const state *s, worker *w, const left_over *left, int row, uint64_t key,
                      uint32_t index, const lf_cancel *cancel)
{
    for (int i = 0; i < w->n_visited; i++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return false;
        begin_pixel(s, w, row, w->visited[i], key, index);
        if (left && left->used)
            look_back(s, w, left, w->visited[i]);
    }
    for (int i = 0; reuses[s->reuse].spatial && i < w->n_visited; i++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return false;
        look_beside(s, w, w->visited[i]);
    }
    for (int i = 0; i < w->n_visited; i++) {
        if (reuses[s->reuse].spatial)
            w->pixels[w->visited[i]].sample = w->spread[w->visited[i]];
        shade(s, w, w->visited[i]);
    }
    return true;
}

static bool visit(void *the_state, const lf_visit_order *order, int row, int half, int worker_index,
                  const lf_cancel *cancel)
{
    const state *s = the_state;
    worker *w = s->workers[worker_index];
    const lf_film_counts *before = &s->film->streams[order->stream].rows[row];
    const uint32_t index = before->visits[half];
    const uint64_t key = lf_hash64(lf_hash64(order->random, (uint64_t)row), (uint64_t)half);
    const double given = (double)order->subsets / order->column_step;
    if (order->subsets == 0)
        return true; /* every pixel has a sample of its own after n_views passes */
    left_over *left = left_of(s, row, half, order->random, index);
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

/* --------------------------------------------------------------------------------- make, free --
 */

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

/* What it does not know, in words behind "renders no"; NULL: it knows all. */
static const char *unknown(const lf_scene *scene, const lf_render_settings *settings)
{
    if (scene->n_meshes > 0)
        return "surfaces yet; the scene has some";
    const char *all = lf_reference_unknown(scene, settings);
    if (!all && lf_max_depth(scene, settings->max_depth) > LF_MAX_PATH_VERTICES)
        return "paths of more than 16 vertices (--max-depth 16)";
    return all;
}

static void destroy(void *the_state)
{
    state *s = the_state;
    for (int i = 0; s && s->workers && i < s->n_workers; i++) {
        worker *w = s->workers[i];
        if (!w)
            continue;
        lf_film_sums_finish(&w->sums);
        lf_free(w->pixels);
        lf_free(w->spread);
        lf_free(w->visited);
        lf_free(w);
    }
    if (!s)
        return;
    lf_coarse_grid_finish(&s->coarse);
    lf_free(s->workers);
    lf_free(s->rows);
    lf_free(s->all_pixels);
    lf_free(s);
}

static lf_status make_workers(state *s, const lf_film_layout *layout)
{
    size_t pixels = (size_t)layout->n_views * (size_t)layout->width;
    s->workers = lf_calloc((size_t)s->n_workers, sizeof *s->workers);
    for (int i = 0; s->workers && i < s->n_workers; i++) {
        worker *w = s->workers[i] = lf_calloc(1, sizeof *w);
        if (!w || lf_film_sums_init(&w->sums, layout) != LF_OK)
            return LF_E_NOMEM;
        w->tracer.scene = &s->seen;
        w->pixels = lf_calloc(pixels, sizeof *w->pixels);
        w->spread = lf_calloc(pixels, sizeof *w->spread);
        w->visited = lf_calloc(pixels, sizeof *w->visited);
        if (!w->pixels || !w->spread || !w->visited)
            return LF_E_NOMEM;
    }
    return s->workers ? LF_OK : LF_E_NOMEM;
}

static lf_status make_history(state *s, const lf_film_layout *layout, lf_error *err)
{
    size_t row = (size_t)layout->n_views * (size_t)layout->width, rows = 2 * (size_t)layout->height;
    if (!reuses[s->reuse].temporal)
        return LF_OK;
    if (row * sizeof(pixel) > MAX_BYTES / rows)
        return lf_error_set(err, LF_E_ARG, "integrator",
                            "reservoirs of %d views of %dx%d would take more than 2 GiB: --reuse "
                            "spatial keeps none",
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
    const char *refused = unknown(input->scene, settings);
    if (refused)
        return lf_error_set(err, LF_E_ARG, "integrator", "%s renders no %s", entries[index].name,
                            refused);
    if (!lf_reuse_name(settings->reuse) || !lf_reuse_weights_name(settings->weights))
        return lf_error_set(err, LF_E_ARG, "integrator", "no such reuse or weights");
    state *s = lf_calloc(1, sizeof *s);
    if (!s)
        return LF_E_NOMEM;
    s->seen = *input->seen;
    s->film = input->film;
    s->across = index == MVRESTIR;
    s->reuse = settings->reuse;
    s->weights = (lf_reuse_weights)settings->weights;
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

static void begin(void *the_state, const lf_pass *pass)
{
    (void)the_state, (void)pass;
}

static void count(const void *the_state, lf_render_stats *out)
{
    const state *s = the_state;
    for (int i = 0; i < s->n_workers; i++) {
        const worker *w = s->workers[i];
        lf_integrator_count(out, &w->tracer, w->base_paths, w->contributions);
    }
    out->rays_traced = out->base_hidden = -1;
}

static void skipped(const void *the_state, json_t *out)
{
    (void)the_state, (void)out;
}

const lf_integrator lf_integrator_restir = {.entry = entry,
                                            .create = create,
                                            .begin = begin,
                                            .visit = visit,
                                            .count = count,
                                            .skipped = skipped,
                                            .destroy = destroy};
