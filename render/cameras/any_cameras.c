/* mvpt and vpt for cameras listed one by one: docs/developer/estimators/cameras.md. */
#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"
#include "render/cameras/any_cameras.h"

#include "render/cameras/any_pivot.h"
#include "render/transport/lanes/depth.h"
#include "render/visit_lattice.h"

enum { MVPT, VPT, N_ENTRIES };

#define SUPPORT                                                                                    \
    (LF_TRAITS_PLAIN_SURFACES | LF_TRAITS_PLAIN_MEDIA | LF_TRAITS_LIGHT | LF_TRAIT_LENS |          \
     LF_TRAIT_LISTED_CAMERAS)

static const lf_integrator_entry entries[N_ENTRIES] = {
    [MVPT] = {.name = "mvpt",
              .what = "all views share paths",
              .shares = true,
              .spreads = true,
              .supports = SUPPORT},
    [VPT] = {.name = "vpt", .what = "each view alone", .spreads = true, .supports = SUPPORT}};

/* Paths that find how bright it gets. */
#define PILOT_PATHS 1024

/* ------------------------------------------------------------------------------ base samples -- */

/* Pinholes draw none. */
static void draw_lens(const lf_pinhole *view, lf_sampler *sampler, float out_lens[2])
{
    float u[2];
    out_lens[0] = out_lens[1] = 0.0f;
    if (!(view->lens_radius > 0.0f))
        return;
    lf_sampler_2d(sampler, u);
    lf_pinhole_lens(view, u, out_lens);
}

/* The point where a view's ray meets a surface or medium that scatters; false: none. The material
 * must not depend on the view that drew it: textures are read at their finest level, because
 * footprints differ between cameras. */
static bool find_pivot(const lf_any_cameras *s, lf_any_worker *w, lf_vec3 d, lf_any_pivot *out)
{
    const lf_vec3 eye = lf_pinhole_eye(&s->views[out->view], out->lens);
    lf_event *e = &out->event;
    e->w = d;
    w->tracer.width = w->tracer.spread = 0.0f;
    const bool met = lf_trace_seen(&w->tracer, eye, d, INFINITY, &e->hit);
    const float t = lf_track_collision(&w->tracer, eye, d, met ? e->hit.t : INFINITY, &e->volume);
    if (!met && isinf(t))
        return false;
    e->kind = isinf(t) ? LF_EVENT_SURFACE : LF_EVENT_MEDIUM;
    e->p = isinf(t) ? e->hit.p : lf_madd(eye, t, d);
    return true;
}

static void base_sample(lf_any_cameras *s, lf_any_worker *w, lf_any_pivot *p, uint64_t pixel,
                        uint32_t index, bool pilot, const lf_cancel *cancel)
{
    float film[2];
    w->base_paths++;
    lf_sampler_init(p->sampler, s->sampler, pixel, index);
    w->tracer.rng = lf_hash64(pixel, ~(uint64_t)index);
    lf_sampler_2d(p->sampler, film);
    draw_lens(&s->views[p->view], p->sampler, p->lens);
    const lf_vec3 d = lf_pinhole_ray(&s->views[p->view], p->lens, (float)p->column + film[0],
                                     (float)p->row + film[1]);
    if (!find_pivot(s, w, d, p))
        return;
    if (w->queue && !pilot && p->event.kind == LF_EVENT_MEDIUM)
        lf_any_push(s, w, p, cancel);
    else
        lf_any_scatter(s, w, p, pilot);
}

/* Finds the largest radiance, for the unit of the sums: the same for every part of the image. */
static void look_ahead(void *the_state, int item, int worker_index)
{
    lf_any_cameras *s = the_state;
    lf_any_worker *w = &s->workers[worker_index];
    (void)item;
    for (int i = 0; i < PILOT_PATHS; i++) {
        const uint64_t key = lf_hash64(0x70696c6f74, (uint64_t)i);
        lf_sampler sampler;
        lf_any_pivot p = {.sampler = &sampler,
                          .view = (int)(lf_hash64(key, 1) % (uint64_t)s->n_views),
                          .row = (int)(lf_hash64(key, 2) % (uint64_t)s->height),
                          .column = (int)(lf_hash64(key, 3) % (uint64_t)s->width)};
        base_sample(s, w, &p, key, 0, true, NULL);
    }
    lf_splats_scale(&s->splats, w->brightest);
    w->base_paths = 0;
    w->tracer.rays = w->tracer.lookups = w->tracer.nonfinite = 0;
}

/* ------------------------------------------------------------------------------------ visits -- */

/* Key of a view pixel's visit. Its base sample and its ray of B and q use the same point of the
 * film and of the lens. If one has met a surface, so has the other. So no pixel expects a surface
 * that its sample has not found. */
static uint64_t numbers_of(uint64_t key, size_t pixel)
{
    return lf_hash64(key, (uint64_t)pixel + 16);
}

/* The film receives everything after the pass. */
static bool visit(void *the_state, const lf_visit_order *order, int row, int half, int worker_index,
                  const lf_cancel *cancel)
{
    lf_any_cameras *s = the_state;
    const lf_film_counts *before = &s->film->streams[order->stream].rows[row];
    const uint32_t index = order->at ? order->at->visits[half] : before->visits[half];
    const double n = order->at ? order->at->given[half] / s->n_views : before->n[half];
    const uint64_t key = lf_visit_key(order->random, row, half);
    const lf_visit_lattice lattice = lf_visit_lattice_of(order, key, n, index, s->n_views);
    s->halves[row] = (uint8_t)half;
    lf_any_worker *w = &s->workers[worker_index];
    if (w->queue)
        lf_suffix_batch_clear(&w->queue->batch); /* a cancelled visit may have left some */
    for (int column = lattice.first; column < s->width; column += order->column_step)
        for (int j = 0; j < order->subsets; j++) {
            if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
                return false;
            lf_sampler sampler;
            lf_any_pivot p = {.sampler = &sampler,
                              .view = lf_visit_lattice_view(&lattice, column, j),
                              .row = row,
                              .column = column};
            const uint64_t pixel =
                numbers_of(key, (size_t)p.view * (size_t)s->width + (size_t)column);
            base_sample(s, w, &p, pixel, index, false, cancel);
        }
    if (w->queue)
        lf_any_flush(s, w, cancel);
    return true;
}

static lf_vec3 sky_of(const lf_any_cameras *s, const lf_pinhole *view, lf_vec3 w, float v)
{
    if (!s->seen.backdrop.given)
        return lf_light_seen(&s->seen, w);
    const float y = (view->y0 + v * view->dy) / view->tangent;
    return lf_backdrop_at(&s->seen.backdrop, lf_min(lf_max(0.5f - 0.5f * y, 0.0f), 1.0f));
}

/* View pixels that are followed side by side. */
enum { FOLLOWED = 64 };

/* The light behind the media on a pixel's ray, and whether it is from a surface. */
typedef struct found {
    lf_vec3 light;
    bool met;
} found;

/* Traces one ray through a view pixel, and returns it. */
static lf_depth_ray follow(const lf_any_cameras *s, lf_any_worker *w, int view, int row, int column,
                           uint64_t key, uint32_t index, found *out)
{
    const lf_pinhole *of = &s->views[view];
    const size_t pixel = (size_t)view * (size_t)s->width + (size_t)column;
    lf_sampler sampler;
    float film[2], lens[2], pdf;
    lf_hit hit;
    lf_sampler_init(&sampler, s->sampler, numbers_of(key, pixel), index);
    lf_sampler_2d(&sampler, film);
    const float v = (float)row + film[1];
    draw_lens(of, &sampler, lens);
    const lf_vec3 eye = lf_pinhole_eye(of, lens),
                  d = lf_pinhole_ray(of, lens, (float)column + film[0], v);
    w->tracer.width = 0.0f;
    w->tracer.spread = 0.5f * lf_min(of->dx, fabsf(of->dy));
    out->met = lf_trace_seen(&w->tracer, eye, d, INFINITY, &hit);
    out->light = lf_v3(0.0f, 0.0f, 0.0f);
    if (!out->met)
        out->light = sky_of(s, of, d, v);
    else if (lf_has(&s->seen, LF_TRAIT_EMISSION))
        out->light = lf_light_hit(&s->seen, eye, &hit, &pdf);
    return (lf_depth_ray){eye, d, (double)(out->met ? hit.t : INFINITY)};
}

/* B and q of n of a row's pixels in a view. */
static void follow_all(const lf_any_cameras *s, lf_any_worker *w, int view, int row, int first,
                       int n, uint64_t key, uint32_t index)
{
    lf_depth_ray rays[FOLLOWED] = {{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, 0.0}};
    double depth[FOLLOWED];
    found behind[FOLLOWED];
    for (int i = 0; i < n; i++)
        rays[i] = follow(s, w, view, row, first + i, key, index, &behind[i]);
    lf_depths_along(&w->tracer, n, rays, depth);
    for (int i = 0; i < n; i++) {
        const size_t pixel = (size_t)view * (size_t)s->width + (size_t)(first + i);
        const lf_vec3 light = lf_scale(behind[i].light, (float)exp(-depth[i]));
        lf_film_known_light(&w->sums, pixel, light.x, light.y, light.z);
        lf_film_pivots(&w->sums, pixel, behind[i].met ? 1.0f : (float)-expm1(-depth[i]));
    }
}

typedef struct closing {
    lf_any_cameras *s;
    const lf_pass *pass;
} closing;

static void close_row(void *context, int item, int worker_index)
{
    const closing *c = context;
    lf_any_cameras *s = c->s;
    lf_any_worker *w = &s->workers[worker_index];
    const lf_visit_order *order = c->pass->order;
    const int row = c->pass->first_row + item * c->pass->row_step, half = s->halves[row];
    const uint32_t index = s->film->streams[order->stream].rows[row].visits[half];
    const uint64_t key = lf_visit_key(order->random, row, half);
    if (order->at && index > order->at->visits[half])
        return; /* it has had this visit */
    lf_film_meet(s->film, row, true);
    lf_film_sums_begin(&w->sums);
    lf_splats_take(&s->splats, row, &w->sums);
    for (int view = 0; view < s->n_views; view++)
        for (int first = 0; first < s->width; first += FOLLOWED)
            follow_all(s, w, view, row, first,
                       s->width - first < FOLLOWED ? s->width - first : FOLLOWED, key, index);
    lf_film_merge(s->film, order->stream, row, half, &w->sums,
                  (double)order->subsets / order->column_step, lf_hash64(lf_hash64(key, 9), index));
}

static lf_status begin(void *the_state, const lf_pass *pass, const lf_cancel *cancel)
{
    lf_any_cameras *s = the_state;
    (void)cancel;
    if (s->spilt)
        lf_splats_clear(&s->splats);
    s->spilt = true;
    for (int row = 0; row < s->height; row++)
        s->in_pass[row] = false;
    for (int i = 0; i < pass->n_rows; i++)
        s->in_pass[pass->first_row + i * pass->row_step] = true;
    return LF_OK;
}

static lf_status end(void *the_state, const lf_pass *pass, const lf_cancel *cancel)
{
    lf_any_cameras *s = the_state;
    closing c = {s, pass};
    if (pass->order->subsets == 0)
        return LF_OK; /* every pixel has a sample of its own after n_views passes */
    const lf_status status = lf_pool_run(s->pool, pass->n_rows, close_row, &c, cancel);
    s->spilt = status != LF_OK || pass->order->at ||
               (cancel && atomic_load_explicit(cancel, memory_order_relaxed));
    return status;
}

/* -------------------------------------------------------------------------------- make, free -- */

static const lf_integrator_entry *entry(int index)
{
    return index >= 0 && index < N_ENTRIES ? &entries[index] : NULL;
}

static void destroy(void *the_state)
{
    lf_any_cameras *s = the_state;
    for (int i = 0; s && s->workers && i < s->n_workers; i++) {
        lf_film_sums_finish(&s->workers[i].sums);
        lf_free(s->workers[i].queue);
    }
    if (s) {
        lf_splats_finish(&s->splats);
        lf_free(s->workers);
        lf_free(s->views);
        lf_free(s->in_pass);
        lf_free(s->halves);
    }
    lf_free(s);
}

static lf_status make_queue(const lf_any_cameras *s, lf_any_worker *w)
{
    w->queue = lf_calloc(1, sizeof *w->queue);
    if (!w->queue)
        return LF_E_NOMEM;
    lf_suffix_batch_init(&w->queue->batch, s->lanes, s->suffixes,
                         s->alone ? LF_ANY_SUFFIXES_ALONE : LF_ANY_SUFFIXES);
    return LF_OK;
}

static lf_status make_memory(lf_any_cameras *s, const lf_film_layout *layout)
{
    const size_t height = (size_t)layout->height;
    s->workers = lf_calloc((size_t)s->n_workers, sizeof *s->workers);
    s->in_pass = lf_calloc(height, sizeof *s->in_pass);
    s->halves = lf_calloc(height, sizeof *s->halves);
    if (!s->workers || !s->in_pass || !s->halves)
        return LF_E_NOMEM;
    for (int i = 0; i < s->n_workers; i++) {
        lf_any_worker *w = &s->workers[i];
        w->tracer.scene = &s->seen;
        if (lf_film_sums_init(&w->sums, layout) != LF_OK || (s->lanes && make_queue(s, w) != LF_OK))
            return LF_E_NOMEM;
    }
    return lf_splats_init(&s->splats, layout);
}

static void set_up(lf_any_cameras *s, const lf_integrator_input *input, int index)
{
    const lf_render_settings *settings = input->settings;
    s->seen = *input->seen;
    s->pool = input->pool;
    s->lanes = input->lanes;
    s->suffixes = input->suffixes;
    s->film = input->film;
    s->n_views = settings->camera.n_views;
    s->width = settings->width;
    s->height = settings->height;
    s->alone = index == VPT;
    s->has_meshes = s->seen.embree;
    s->has_volumes = s->seen.n_volumes > 0;
    s->sampler = settings->sampler;
    s->max_depth = lf_max_depth(input->scene, settings->max_depth);
    s->n_workers = lf_pool_threads(input->pool);
}

static lf_status create(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err)
{
    lf_any_cameras *s = lf_calloc(1, sizeof *s);
    if (!s)
        return LF_E_NOMEM;
    set_up(s, input, index);
    s->views = lf_calloc(LF_MAX_VIEWS, sizeof *s->views);
    lf_status status = s->views
                           ? lf_pinholes_init(s->views, input->settings, input->scene->origin, err)
                           : LF_E_NOMEM;
    const lf_integrator_needs needs = {.layout = {.n_views = s->n_views,
                                                  .width = s->width,
                                                  .height = s->height,
                                                  .has_known = true},
                                       .visit_passes = s->n_views};
    if (status == LF_OK)
        status = make_memory(s, &needs.layout);
    if (status != LF_OK) {
        destroy(s);
        return status;
    }
    status = lf_pool_run(s->pool, 1, look_ahead, s, NULL);
    *out_state = s;
    *out_needs = needs;
    return status;
}

static void count(const void *the_state, lf_render_stats *out)
{
    const lf_any_cameras *s = the_state;
    for (int i = 0; i < s->n_workers; i++) {
        const lf_any_worker *w = &s->workers[i];
        lf_integrator_count(out, &w->tracer, w->base_paths, w->contributions);
    }
    out->nonfinite_dropped += lf_splats_lost(&s->splats);
    out->film_bytes += lf_splats_bytes(&s->splats);
    out->rays_traced = s->has_meshes ? out->rays_traced : -1;
    out->volume_lookups = s->has_volumes ? out->volume_lookups : -1;
    out->base_hidden = -1;
}

const lf_integrator lf_integrator_any_cameras = {.skips = LF_SKIP_SURFACES | LF_SKIP_EMISSION |
                                                          LF_SKIP_PATHS,
                                                 .entry = entry,
                                                 .create = create,
                                                 .begin = begin,
                                                 .visit = visit,
                                                 .end = end,
                                                 .count = count,
                                                 .destroy = destroy};
