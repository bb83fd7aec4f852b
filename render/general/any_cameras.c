/* mvpt and vpt of cameras that are listed one by one: docs/estimators.md, "Any cameras". */
#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"
#include "render/general/any_cameras.h"

#include "render/general/alike.h"
#include "render/general/depth.h"
#include "render/general/pinhole.h"
#include "render/general/splat.h"
#include "render/transport/path.h"
#include "render/transport/sampler.h"

enum { MVPT, VPT, N_ENTRIES };

static const lf_integrator_entry entries[N_ENTRIES] = {
    [MVPT] = {.name = "mvpt", .what = "every path serves all views that see it", .shares = true},
    [VPT] = {.name = "vpt", .what = "every view for itself"}};

/* Paths that find how bright it gets. */
#define PILOT_PATHS 1024
/* Suffixes behind a shared pivot: what it weighs for all views costs as much as many of them. */
#define SUFFIXES 4

/* A view of a pivot. */
typedef struct sight {
    double density; /* D; 0: it is not seen */
    int row;
    size_t pixel; /* in the row */
    lf_vec3 wo;   /* unit, back to the eye */
} sight;

/* One worker's memory. */
typedef struct worker {
    lf_tracer tracer;
    lf_film_sums sums;
    int64_t base_paths, contributions;
    float brightest; /* radiance of the pilot's */
    sight sight[LF_MAX_VIEWS];
    lf_vec3 f[LF_MAX_VIEWS];     /* of a direction, by views */
    lf_vec3 found[LF_MAX_VIEWS]; /* of a pivot: what it brings */
} worker;

typedef struct state {
    lf_scene seen;
    lf_pool *pool;
    lf_film *film;
    lf_pinhole *views; /* [n_views] */
    int n_views, width, height;
    bool alone; /* nothing is shared */
    bool has_meshes, has_volumes;
    lf_sampler_kind sampler;
    int max_depth, n_workers;
    worker **workers; /* [n_workers] each its own */
    lf_splats splats;
    bool spilt;      /* something is left there of a pass that was cancelled */
    bool *in_pass;   /* [height] rows that the pass visits */
    uint8_t *halves; /* [height] and which half */
} state;

/* A base sample that has found a pivot. */
typedef struct pivot {
    lf_event event;
    int view, row, column;
    float lens[2]; /* the point that its ray has left */
    lf_sampler *sampler;
} pivot;

/* --------------------------------------------------------------------------------- densities --
 */

/* Density of view k's samples at the pivot but for what is lost in media on the way, up to what all
 * of them have in common there, and that way; 0: it sees nothing of it. The base sees its own. */
static double density_of(const state *s, worker *w, const pivot *p, int k, lf_depth_ray *way)
{
    const bool base = k == p->view;
    const lf_event *e = &p->event;
    lf_pinhole_sight seen;
    sight *out = &w->sight[k];
    if (!lf_pinhole_see(&s->views[k], p->lens, e->p, &seen))
        return 0.0;
    if (!base && !(seen.u >= 0.0f && seen.u < (float)s->width && seen.v >= 0.0f &&
                   seen.v < (float)s->height))
        return 0.0;
    const int column = base ? p->column : (int)seen.u;
    out->row = base ? p->row : (int)seen.v;
    out->pixel = (size_t)k * (size_t)s->width + (size_t)column;
    out->wo = lf_scale(seen.w, -1.0f);
    if (!s->in_pass[out->row])
        return 0.0;
    double scale = 1.0 / seen.area;
    lf_vec3 from = e->p;
    if (e->kind == LF_EVENT_SURFACE) {
        const float cosine = lf_dot(e->hit.ng, out->wo);
        if (!base && !(cosine > 0.0f))
            return 0.0;
        scale *= fmax((double)cosine, 1e-7);
        from = lf_offset(&s->seen, e->p, e->hit.ng, out->wo, seen.distance);
    }
    if (!base && s->has_meshes &&
        !(lf_trace_passed_seen(&w->tracer, from, lf_sub(seen.eye, from), 1.0f) > 0.0f))
        return 0.0;
    *way = (lf_depth_ray){seen.eye, seen.w, (double)seen.distance};
    return scale;
}

/* Fills the sights of all views; returns the sum of their densities. */
static double look(const state *s, worker *w, const pivot *p, bool alone)
{
    double sum = 0.0, depth[LF_MAX_VIEWS];
    lf_depth_ray ways[LF_MAX_VIEWS];
    int n = 0;
    if (alone) {
        for (int k = 0; k < s->n_views; k++)
            w->sight[k].density = 0.0;
        sight *own = &w->sight[p->view];
        *own = (sight){1.0, p->row, (size_t)p->view * (size_t)s->width + (size_t)p->column,
                       lf_scale(p->event.w, -1.0f)};
        return 1.0;
    }
    for (int k = 0; k < s->n_views; k++) {
        w->sight[k].density = density_of(s, w, p, k, &ways[n]);
        n += w->sight[k].density > 0.0;
    }
    lf_depths_along(&w->tracer, n, ways, depth);
    n = 0;
    for (int k = 0; k < s->n_views; k++)
        if (w->sight[k].density > 0.0)
            sum += w->sight[k].density *= exp(-depth[n++]);
    return sum;
}

/* ----------------------------------------------------------------------------------- suffixes --
 */

static bool view_dependent(const state *s, const lf_event *event)
{
    return event->kind == LF_EVENT_SURFACE
               ? event->hit.material->kind->view_dependent
               : !lf_volume_is_isotropic(&s->seen.volumes[event->volume]);
}

/* The lobes of all views towards wi into f; returns the sum of density times pdf. */
static double lobes(const state *s, worker *w, const pivot *p, lf_vec3 wi, double densities)
{
    double sum = 0.0;
    if (!view_dependent(s, &p->event)) {
        lf_vec3 f;
        const float pdf = lf_scatter_eval(&s->seen, &p->event, lf_scale(p->event.w, -1.0f), wi, &f);
        for (int k = 0; k < s->n_views; k++)
            w->f[k] = f;
        return densities * (double)pdf;
    }
    for (int k = 0; k < s->n_views; k++)
        if (w->sight[k].density > 0.0)
            sum += w->sight[k].density *
                   (double)lf_scatter_eval(&s->seen, &p->event, w->sight[k].wo, wi, &w->f[k]);
    return sum;
}

/* Radiance that arrives from one direction to all views, over a density. */
static void spread(state *s, worker *w, lf_vec3 arriving, bool pilot)
{
    if (!isfinite(arriving.x + arriving.y + arriving.z)) {
        w->tracer.nonfinite++;
        return;
    }
    for (int k = 0; k < s->n_views; k++) {
        const sight *to = &w->sight[k];
        if (!(to->density > 0.0))
            continue;
        const lf_vec3 n = lf_mul(lf_scale(arriving, (float)to->density), w->f[k]);
        if (pilot)
            w->brightest = lf_max(w->brightest, lf_max3(n));
        else
            w->found[k] = lf_add(w->found[k], n);
    }
}

/* A share of what a pivot brings, by a light sample: its balance is over all views' directions and
 * its own. */
static void spread_light(state *s, worker *w, const pivot *p, double densities, double share,
                         bool pilot)
{
    float u[3];
    lf_light_sample light;
    u[0] = lf_sampler_1d(p->sampler);
    lf_sampler_2d(p->sampler, u + 1);
    if (!lf_light_draw(&s->seen, p->event.p, u, &light))
        return;
    const float visible = lf_path_visible(&w->tracer, &p->event, &light);
    if (!(visible > 0.0f))
        return;
    const double over = lobes(s, w, p, light.wi, densities),
                 density = (double)light.pdf * densities + (light.delta ? 0.0 : over);
    spread(s, w, lf_scale(light.radiance, (float)(share * (double)visible / density)), pilot);
}

/* The same by a direction of the base's own lobe, and all that comes along it. */
static void spread_direction(state *s, worker *w, const pivot *p, double densities, double share,
                             bool pilot)
{
    float u[3], light_pdf;
    lf_vec3 wi, f;
    lf_event next;
    lf_sampler_2d(p->sampler, u);
    u[2] = lf_sampler_1d(p->sampler);
    if (!(lf_scatter_sample(&s->seen, &p->event, lf_scale(p->event.w, -1.0f), u, &wi, &f) > 0.0f))
        return;
    const double over = lobes(s, w, p, wi, densities);
    float most = 0.0f;
    for (int k = 0; k < s->n_views; k++)
        if (w->sight[k].density > 0.0)
            most = lf_max(most, lf_max3(w->f[k]));
    if (!(most > 0.0f) || !(over > 0.0))
        return;
    w->tracer.spread = LF_SUFFIX_SPREAD;
    lf_path_next(&w->tracer, &p->event, wi, &next);
    const lf_vec3 found = lf_path_light_found(&s->seen, &p->event, &next, &light_pdf),
                  scattered = lf_path_arriving(&w->tracer, &next, 2, s->max_depth);
    spread(s, w,
           lf_add(lf_scale(found, (float)(share / (over + (double)light_pdf * densities))),
                  lf_scale(scattered, (float)(share / over))),
           pilot);
}

/* Adds what all that see a pivot have found, and what their samples weigh. */
static void add_found(state *s, worker *w, double densities)
{
    for (int k = 0; k < s->n_views; k++) {
        const sight *to = &w->sight[k];
        if (!(to->density > 0.0))
            continue;
        lf_splats_add(&s->splats, &w->tracer, to->row, to->pixel, w->found[k],
                      to->density / densities);
        w->contributions++;
    }
}

/* -------------------------------------------------------------------------------- base samples --
 */

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

/* Where a ray of a view meets something to scatter at; false: nowhere. What it is made of must not
 * depend on who drew it: pictures on surfaces are read at their finest, cameras having footprints
 * of their own. */
static bool find_pivot(const state *s, worker *w, lf_vec3 d, pivot *out)
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

static void base_sample(state *s, worker *w, pivot *p, uint64_t pixel, uint32_t index, bool pilot)
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
    const double densities = look(s, w, p, s->alone || pilot);
    if (!(densities > 0.0) || !isfinite(densities)) {
        w->tracer.nonfinite++;
        return;
    }
    for (int k = 0; k < s->n_views; k++)
        w->found[k] = lf_v3(0.0f, 0.0f, 0.0f);
    const int n = s->alone || pilot ? 1 : SUFFIXES;
    for (int i = 0; i < n; i++) {
        spread_light(s, w, p, densities, 1.0 / n, pilot);
        spread_direction(s, w, p, densities, 1.0 / n, pilot);
    }
    if (!pilot)
        add_found(s, w, densities);
}

/* How bright it gets, for the unit of the sums: the same whatever is rendered of the picture. */
static void look_ahead(void *the_state, int item, int worker_index)
{
    state *s = the_state;
    worker *w = s->workers[worker_index];
    (void)item;
    for (int i = 0; i < PILOT_PATHS; i++) {
        const uint64_t key = lf_hash64(0x70696c6f74, (uint64_t)i);
        lf_sampler sampler;
        pivot p = {.sampler = &sampler,
                   .view = (int)(lf_hash64(key, 1) % (uint64_t)s->n_views),
                   .row = (int)(lf_hash64(key, 2) % (uint64_t)s->height),
                   .column = (int)(lf_hash64(key, 3) % (uint64_t)s->width)};
        base_sample(s, w, &p, key, 0, true);
    }
    lf_splats_scale(&s->splats, w->brightest);
    w->base_paths = 0;
    w->tracer.rays = w->tracer.lookups = w->tracer.nonfinite = 0;
}

/* ------------------------------------------------------------------------------------- visits --
 */

static uint64_t key_of(const lf_visit_order *order, int row, int half)
{
    return lf_hash64(lf_hash64(order->random, (uint64_t)row), (uint64_t)half);
}

/* Of a view pixel's visit. Its base sample and the ray of its B and q leave through the same point
 * of the film and of the lens: where the one has met a surface, so has the other, and no pixel
 * expects to have found something and has found nothing. */
static uint64_t numbers_of(uint64_t key, size_t pixel)
{
    return lf_hash64(key, (uint64_t)pixel + 16);
}

/* The film takes it all behind the pass. */
static bool visit(void *the_state, const lf_visit_order *order, int row, int half, int worker_index,
                  const lf_cancel *cancel)
{
    state *s = the_state;
    const lf_film_counts *before = &s->film->streams[order->stream].rows[row];
    const uint32_t index = before->visits[half];
    const uint64_t key = key_of(order, row, half);
    const lf_visit_lattice lattice =
        lf_visit_lattice_of(order, key, before->n[half], index, s->n_views);
    s->halves[row] = (uint8_t)half;
    for (int column = lattice.first; column < s->width; column += order->column_step)
        for (int j = 0; j < order->subsets; j++) {
            if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
                return false;
            lf_sampler sampler;
            pivot p = {.sampler = &sampler,
                       .view = lf_visit_lattice_view(&lattice, column, j),
                       .row = row,
                       .column = column};
            const uint64_t pixel =
                numbers_of(key, (size_t)p.view * (size_t)s->width + (size_t)column);
            base_sample(s, s->workers[worker_index], &p, pixel, index, false);
        }
    return true;
}

static lf_vec3 sky_of(const state *s, const lf_pinhole *view, lf_vec3 w, float v)
{
    if (!s->seen.backdrop.given)
        return lf_light_seen(&s->seen, w);
    const float y = (view->y0 + v * view->dy) / view->tangent;
    return lf_backdrop_at(&s->seen.backdrop, lf_min(lf_max(0.5f - 0.5f * y, 0.0f), 1.0f));
}

/* View pixels that are followed side by side. */
enum { FOLLOWED = 64 };

/* What a pixel's ray finds behind the media, and whether that is a surface. */
typedef struct found {
    lf_vec3 light;
    bool met;
} found;

/* Of one ray, which is returned, through a view pixel. */
static lf_depth_ray follow(const state *s, worker *w, int view, int row, int column, uint64_t key,
                           uint32_t index, found *out)
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
    else if (s->seen.has_emission)
        out->light = lf_light_hit(&s->seen, eye, &hit, &pdf);
    return (lf_depth_ray){eye, d, (double)(out->met ? hit.t : INFINITY)};
}

/* B and q of n of a row's pixels in a view. */
static void follow_all(const state *s, worker *w, int view, int row, int first, int n, uint64_t key,
                       uint32_t index)
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
    state *s;
    const lf_pass *pass;
} closing;

static void close_row(void *context, int item, int worker_index)
{
    const closing *c = context;
    state *s = c->s;
    worker *w = s->workers[worker_index];
    const lf_visit_order *order = c->pass->order;
    const int row = c->pass->first_row + item * c->pass->row_step, half = s->halves[row];
    const uint32_t index = s->film->streams[order->stream].rows[row].visits[half];
    const uint64_t key = key_of(order, row, half);
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

static void begin(void *the_state, const lf_pass *pass)
{
    state *s = the_state;
    if (s->spilt)
        lf_splats_clear(&s->splats);
    s->spilt = true;
    for (int row = 0; row < s->height; row++)
        s->in_pass[row] = false;
    for (int i = 0; i < pass->n_rows; i++)
        s->in_pass[pass->first_row + i * pass->row_step] = true;
}

static lf_status end(void *the_state, const lf_pass *pass, const lf_cancel *cancel)
{
    state *s = the_state;
    closing c = {s, pass};
    if (pass->order->subsets == 0)
        return LF_OK; /* every pixel has a sample of its own after n_views passes */
    const lf_status status = lf_pool_run(s->pool, pass->n_rows, close_row, &c, cancel);
    s->spilt = status != LF_OK || (cancel && atomic_load_explicit(cancel, memory_order_relaxed));
    return status;
}

/* --------------------------------------------------------------------------------- make, free --
 */

static const lf_integrator_entry *entry(int index)
{
    return index >= 0 && index < N_ENTRIES ? &entries[index] : NULL;
}

/* What it does not know, in words behind "render no"; NULL: it knows all. */
static const char *unknown(const lf_scene *scene, const lf_render_settings *settings)
{
    const lf_looks *looks = &scene->looks;
    if (scene->has_delta)
        return "mirrors and smooth coats yet; a surface of the scene is one";
    if (looks->veiled || looks->frosted || looks->filled || looks->fleshy)
        return "glass, alpha and subsurface yet; a surface of the scene has some";
    if (looks->caught)
        return "catchers of shadows yet; the scene has one";
    if (scene->flames.n > 0)
        return "volumes that emit yet; the scene has some";
    if (looks->chromatic)
        return "extinction that has a colour yet; the scene's has";
    if (looks->moving || settings->camera.moves)
        return "motion yet; something moves while the shutter is open";
    if (settings->camera.view_blur > 0.0)
        return "view_blur: they have no neighbours";
    if (settings->features)
        return "reconstructed pictures (--reconstruct off) or depth";
    return NULL;
}

static void destroy(void *the_state)
{
    state *s = the_state;
    for (int i = 0; s && s->workers && i < s->n_workers; i++) {
        if (s->workers[i])
            lf_film_sums_finish(&s->workers[i]->sums);
        lf_free(s->workers[i]);
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

static lf_status make_memory(state *s, const lf_film_layout *layout)
{
    const size_t height = (size_t)layout->height;
    s->workers = lf_calloc((size_t)s->n_workers, sizeof *s->workers);
    s->in_pass = lf_calloc(height, sizeof *s->in_pass);
    s->halves = lf_calloc(height, sizeof *s->halves);
    if (!s->workers || !s->in_pass || !s->halves)
        return LF_E_NOMEM;
    for (int i = 0; i < s->n_workers; i++) {
        s->workers[i] = lf_calloc(1, sizeof **s->workers);
        if (!s->workers[i] || lf_film_sums_init(&s->workers[i]->sums, layout) != LF_OK)
            return LF_E_NOMEM;
        s->workers[i]->tracer.scene = &s->seen;
    }
    return lf_splats_init(&s->splats, layout);
}

static void set_up(state *s, const lf_integrator_input *input, int index)
{
    const lf_render_settings *settings = input->settings;
    s->seen = *input->seen;
    s->pool = input->pool;
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
    const char *refused = unknown(input->scene, input->settings);
    if (refused)
        return lf_error_set(err, LF_E_ARG, "camera.views", "cameras listed one by one render no %s",
                            refused);
    state *s = lf_calloc(1, sizeof *s);
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
    const state *s = the_state;
    for (int i = 0; i < s->n_workers; i++) {
        const worker *w = s->workers[i];
        lf_integrator_count(out, &w->tracer, w->base_paths, w->contributions);
    }
    out->nonfinite_dropped += atomic_load(&s->splats.dropped);
    out->film_bytes += lf_splats_bytes(&s->splats);
    out->rays_traced = s->has_meshes ? out->rays_traced : -1;
    out->volume_lookups = s->has_volumes ? out->volume_lookups : -1;
    out->base_hidden = -1;
}

static void skipped(const void *the_state, json_t *out)
{
    (void)the_state, (void)out;
}

const lf_integrator lf_integrator_any_cameras = {.skips = LF_SKIP_SURFACES | LF_SKIP_EMISSION,
                                                 .entry = entry,
                                                 .create = create,
                                                 .begin = begin,
                                                 .visit = visit,
                                                 .end = end,
                                                 .count = count,
                                                 .skipped = skipped,
                                                 .destroy = destroy};
