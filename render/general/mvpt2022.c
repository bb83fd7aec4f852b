#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"
#include "render/general/general.h"
#include "render/general/null_chain.h"
#include "render/general/selection.h"
#include "render/rows/rig.h"
#include "render/transport/path.h"
#include "render/transport/sampler.h"

enum { MVPT2022, MISMVPT, N_ENTRIES };

static const lf_integrator_entry entries[N_ENTRIES] = {
    [MVPT2022] = {.name = "mvpt2022",
                  .what = "null chains shifted to all views, as in 2022",
                  .shares = true,
                  .shifts = true,
                  .selects = true},
    [MISMVPT] = {.name = "mismvpt",
                 .what = "the same with weights of multiple importance sampling",
                 .shares = true,
                 .shifts = true}};

/* One worker's memory. */
typedef struct worker {
    lf_tracer tracer;
    lf_film_sums sums;
    int64_t base_paths, contributions;
    lf_null_chain chain;
    /* of a pivot, by views: */
    double ratio[LF_MAX_VIEWS]; /* rho; 0: it has no part in it */
    int column[LF_MAX_VIEWS];
    lf_vec3 to_pivot[LF_MAX_VIEWS]; /* unit */
    bool selected[LF_MAX_VIEWS];
} worker;

typedef struct state {
    lf_scene seen;
    lf_rig rig;
    lf_film *film;
    const lf_shift *shift;
    const lf_selection *selection;
    bool mis; /* W is n */
    lf_sampler_kind sampler;
    int max_depth, n_workers;
    worker **workers; /* [n_workers] each its own */
} state;

/* A base sample that has found a pivot. */
typedef struct prefix {
    lf_event event;
    lf_media_path path; /* from the base's lens to the pivot */
    int view, column;
    double lx, ly;  /* on the lens */
    double x, y, z; /* the pivot, camera space */
    lf_sampler *sampler;
} prefix;

/* What behind the pivot all views share. */
typedef struct shared {
    lf_light_sample light;
    float visible; /* 0: no light sample */
    lf_vec3 wi, found, scattered;
    float found_pdf;
    bool has_direction;
} shared;

/* ----------------------------------------------------------------------------------- prefixes --
 */

/* Area at the pivot for an area on the film of a view. */
static double area_of(const state *s, const prefix *p, int view)
{
    const double axis[3] = {0.0, 0.0, 1.0}, pivot[3] = {p->x, p->y, p->z},
                 lens[3] = {(double)s->rig.b[view] + p->lx, p->ly, 0.0};
    double film[3] = {lens[0] + (p->x - lens[0]) / p->z, lens[1] + (p->y - lens[1]) / p->z, 1.0};
    return lf_shift_area(lens, film, axis, pivot, NULL);
}

/* The column of a view's film that the pivot is seen in through the copied lens point; < 0: none.
 */
static int column_of(const state *s, const prefix *p, int view)
{
    const lf_rig *rig = &s->rig;
    double x = (p->x - (double)rig->b[view] - p->lx) / p->z + p->lx / (double)rig->focus,
           u = ((double)rig->skew[view] + (double)rig->distance * x - (double)rig->x0) /
               (double)rig->dx;
    return u >= 0.0 && u < (double)rig->width ? (int)u : -1;
}

static lf_vec3 lens_point(const state *s, const prefix *p, int view)
{
    return lf_rig_point(&s->rig, s->rig.b[view] + (float)p->lx, (float)p->ly, 0.0f);
}

/* rho of one view. */
static double shift_to(const state *s, worker *w, const prefix *p, int view)
{
    lf_vec3 o = lens_point(s, p, view);
    double length = (double)lf_length(lf_sub(p->event.p, o));
    lf_media_path target;
    lf_media_path_init(&target, &w->tracer, o, w->to_pivot[view], length);
    return area_of(s, p, p->view) / area_of(s, p, view) *
           lf_shift_ratio(s->shift, &p->path.majorant, &target.majorant, w->chain.n, w->chain.nulls,
                          lf_media_path_extinction, &target);
}

/* What equation 24 compares. */
typedef struct lobes {
    const lf_volume *volume;
    const lf_vec3 *to_pivot;
    float sign; /* -1: the phase function is highest straight back */
} lobes;

static double distance_of(const void *context, int a, int b)
{
    const lobes *l = context;
    lf_vec3 wa = l->to_pivot[a], wb = l->to_pivot[b];
    return lf_lobe_distance((double)lf_volume_phase(l->volume, wa, lf_scale(wa, l->sign)),
                            (double)lf_volume_phase(l->volume, wa, lf_scale(wb, l->sign)));
}

static void select_views(const state *s, worker *w, const prefix *p)
{
    const lf_volume *volume = &s->seen.volumes[p->event.volume];
    lf_vec3 on = p->event.w, back = lf_scale(on, -1.0f);
    const lobes l = {volume, w->to_pivot,
                     lf_volume_phase(volume, on, on) >= lf_volume_phase(volume, on, back) ? 1.0f
                                                                                          : -1.0f};
    const lf_selected_views views = {s->rig.n_views, p->view, distance_of, &l};
    s->selection->select(&views, &w->tracer, w->selected);
}

/* Fills ratio and column of all views; returns the sum of the ratios. */
static double shift_prefix(const state *s, worker *w, const prefix *p)
{
    double sum = 0.0;
    for (int k = 0; k < s->rig.n_views; k++)
        w->to_pivot[k] = lf_normalize(lf_sub(p->event.p, lens_point(s, p, k)));
    select_views(s, w, p);
    for (int k = 0; k < s->rig.n_views; k++) {
        bool own = k == p->view;
        w->column[k] = own ? p->column : column_of(s, p, k);
        w->ratio[k] = own ? 1.0 : 0.0;
        if (!own && w->selected[k] && w->column[k] >= 0)
            w->ratio[k] = shift_to(s, w, p, k);
        sum += w->ratio[k];
    }
    return sum;
}

/* ----------------------------------------------------------------------------------- suffixes --
 */

/* The pdf with which the views that share draw a direction: the mean of their lobes'. */
static float mixture(const state *s, const worker *w, const prefix *p, lf_vec3 wi)
{
    float sum = 0.0f;
    int n = 0;
    lf_vec3 f;
    for (int k = 0; k < s->rig.n_views; k++) {
        if (!(w->ratio[k] > 0.0))
            continue;
        sum += lf_scatter_eval(&s->seen, &p->event, lf_scale(w->to_pivot[k], -1.0f), wi, &f);
        n++;
    }
    return sum / (float)n;
}

static int pick_view(const state *s, const worker *w, float u)
{
    int n = 0, last = 0;
    for (int k = 0; k < s->rig.n_views; k++)
        n += w->ratio[k] > 0.0;
    int wanted = (int)(u * (float)n);
    for (int k = 0; k < s->rig.n_views && wanted >= 0; k++) {
        if (!(w->ratio[k] > 0.0))
            continue;
        last = k;
        wanted--;
    }
    return last;
}

static void draw_shared(const state *s, worker *w, const prefix *p, shared *out)
{
    float u[3];
    lf_vec3 f;
    *out = (shared){.visible = 0.0f};
    u[0] = lf_sampler_1d(p->sampler);
    lf_sampler_2d(p->sampler, u + 1);
    if (lf_light_draw(&s->seen, p->event.p, u, &out->light))
        out->visible = lf_path_visible(&w->tracer, &p->event, &out->light);
    int from = pick_view(s, w, lf_sampler_1d(p->sampler));
    lf_sampler_2d(p->sampler, u);
    u[2] = lf_sampler_1d(p->sampler);
    out->has_direction = lf_scatter_sample(&s->seen, &p->event, lf_scale(w->to_pivot[from], -1.0f),
                                           u, &out->wi, &f) > 0.0f;
    if (!out->has_direction || !(lf_max3(f) > 0.0f))
        return;
    lf_event next;
    lf_path_next(&w->tracer, &p->event, out->wi, &next);
    out->found = lf_path_light_found(&s->seen, &p->event, &next, &out->found_pdf);
    out->scattered = lf_path_arriving(&w->tracer, &next, 2, s->max_depth);
}

/* What of it arrives in a view, over the densities of light sampling and of the mixture. */
static lf_vec3 radiance_of(const state *s, const worker *w, const prefix *p, const shared *behind,
                           float light_mixture, float own_mixture, int view)
{
    lf_vec3 wo = lf_scale(w->to_pivot[view], -1.0f), f, sum = lf_v3(0.0f, 0.0f, 0.0f);
    if (behind->visible > 0.0f) {
        const lf_light_sample *light = &behind->light;
        lf_scatter_eval(&s->seen, &p->event, wo, light->wi, &f);
        float pdf = light->pdf + (light->delta ? 0.0f : light_mixture);
        sum = lf_scale(lf_mul(f, light->radiance), behind->visible / pdf);
    }
    if (behind->has_direction) {
        lf_scatter_eval(&s->seen, &p->event, wo, behind->wi, &f);
        lf_vec3 arriving = lf_add(lf_scale(behind->found, 1.0f / (own_mixture + behind->found_pdf)),
                                  lf_scale(behind->scattered, 1.0f / own_mixture));
        sum = lf_add(sum, lf_mul(f, arriving));
    }
    return sum;
}

/* N and W of a view pixel. */
static void add(const state *s, worker *w, int view, int column, double weight, lf_vec3 y)
{
    size_t pixel = (size_t)view * (size_t)s->rig.width + (size_t)column;
    float scale = (float)weight;
    if (!isfinite(y.x + y.y + y.z)) {
        w->tracer.nonfinite++;
        y = lf_v3(0.0f, 0.0f, 0.0f);
    }
    lf_film_scatter(&w->sums, pixel, scale * y.x, scale * y.y, scale * y.z);
    if (!s->mis)
        lf_film_weigh(&w->sums, pixel, scale);
}

/* Algorithm 2, lines 4 to 18. */
static void spread(const state *s, worker *w, const prefix *p)
{
    shared behind;
    double sum = shift_prefix(s, w, p);
    if (!isfinite(sum)) {
        w->tracer.nonfinite++;
        return;
    }
    draw_shared(s, w, p, &behind);
    float light_mixture = behind.visible > 0.0f ? mixture(s, w, p, behind.light.wi) : 0.0f,
          own_mixture = behind.has_direction ? mixture(s, w, p, behind.wi) : 0.0f;
    for (int k = 0; k < s->rig.n_views; k++) {
        if (!(w->ratio[k] > 0.0))
            continue;
        add(s, w, k, w->column[k], w->ratio[k] / sum,
            radiance_of(s, w, p, &behind, light_mixture, own_mixture, k));
        w->contributions++;
    }
}

/* -------------------------------------------------------------------------------- base samples --
 */

static lf_vec3 sky_of(const state *s, lf_vec3 w, float my)
{
    if (s->seen.backdrop.given)
        return lf_backdrop_at(&s->seen.backdrop, lf_rig_height_between(&s->rig, my));
    return lf_light_seen(&s->seen, w);
}

static void base_sample(const state *s, worker *w, int row, int view, int column, uint64_t key,
                        uint32_t index)
{
    const lf_rig *rig = &s->rig;
    lf_sampler sampler;
    uint64_t pixel = lf_hash64(key, (uint64_t)view * (uint64_t)rig->width + (uint64_t)column + 16);
    float film[2], lens[2], chord;
    lf_row_plane plane;
    w->base_paths++;
    lf_sampler_init(&sampler, s->sampler, pixel, index);
    w->tracer.rng = lf_hash64(pixel, ~(uint64_t)index);
    lf_sampler_2d(&sampler, film);
    lf_sampler_2d(&sampler, lens);
    lf_rig_row_plane(rig, (float)row + film[1], lens, &plane);
    chord = (2.0f * lf_sampler_1d(&sampler) - 1.0f) * plane.lens_chord;

    prefix p = {.view = view, .column = column, .sampler = &sampler};
    p.lx = (double)chord;
    p.ly = (double)plane.ly;
    float slope = lf_rig_slope(rig, view, (float)column + film[0]) - chord / rig->focus,
          length = sqrtf(1.0f + slope * slope + plane.my * plane.my);
    lf_vec3 o = lens_point(s, &p, view),
            d = lf_scale(lf_rig_direction(rig, slope, plane.my, 1.0f), 1.0f / length);
    lf_media_path_init(&p.path, &w->tracer, o, d, INFINITY);
    int volume = 0;
    double t = lf_null_chain_draw(&p.path, &w->chain, &volume);
    if (isinf(t)) {
        add(s, w, view, column, 1.0, sky_of(s, d, plane.my));
        return;
    }
    p.z = t / (double)length;
    p.x = (double)(rig->b[view] + chord) + (double)slope * p.z;
    p.y = p.ly + (double)plane.my * p.z;
    p.event.kind = LF_EVENT_MEDIUM;
    p.event.p = lf_madd(o, (float)t, d);
    p.event.w = d;
    p.event.volume = volume;
    lf_media_path_init(&p.path, &w->tracer, o, d, t);
    spread(s, w, &p);
}

/* ------------------------------------------------------------------------------------- visits --
 */

/* Each pixel with probability subsets / n_views, each once in any n_views passes: column u takes
 * the views u + start + j, j < subsets, start uniform in a half's first visit and running on. */
static bool visit(void *the_state, const lf_visit_order *order, int row, int half, int worker_index,
                  const lf_cancel *cancel)
{
    const state *s = the_state;
    worker *w = s->workers[worker_index];
    const lf_film_counts *before = &s->film->streams[order->stream].rows[row];
    const uint32_t index = before->visits[half];
    const uint64_t key = lf_hash64(lf_hash64(order->random, (uint64_t)row), (uint64_t)half);
    const int views = s->rig.n_views, step = order->column_step;
    if (order->subsets == 0)
        return true; /* every pixel has a sample of its own after n_views passes */
    int start = (int)((lf_hash64(key, 7) >> 32) % (uint64_t)views) +
                (int)(llround(before->n[half] * views) % views),
        first = (int)((lf_hash64(lf_hash64(key, 3), index) >> 32) % (uint64_t)step);
    lf_film_meet(s->film, row, true);
    lf_film_sums_begin(&w->sums);
    const double given = (double)order->subsets / order->column_step;
    for (size_t i = 0; i < (size_t)views * (size_t)s->rig.width; i++) {
        lf_film_pivots(&w->sums, i, 1.0f);
        if (s->mis)
            lf_film_weigh(&w->sums, i, (float)(given / views));
    }
    for (int column = first; column < s->rig.width; column += step)
        for (int j = 0; j < order->subsets; j++) {
            if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
                return false;
            base_sample(s, w, row, (column + start + j) % views, column, key, index);
        }
    lf_film_merge(s->film, order->stream, row, half, &w->sums, given,
                  lf_hash64(lf_hash64(key, 9), index));
    return true;
}

/* --------------------------------------------------------------------------------- make, free --
 */

static const lf_integrator_entry *entry(int index)
{
    return index >= 0 && index < N_ENTRIES ? &entries[index] : NULL;
}

/* What it does not know, in words behind "renders no"; NULL: it knows all. */
static const char *unknown(const lf_scene *scene, const lf_render_settings *settings)
{
    if (scene->n_meshes > 0)
        return "surfaces yet; the scene has some";
    if (scene->flames.n > 0)
        return "volumes that emit; the scene has some";
    if (scene->looks.chromatic)
        return "extinction that has a colour; the scene's has";
    if (scene->looks.moving || settings->camera.moves)
        return "motion; something moves while the shutter is open";
    if (settings->features)
        return "reconstructed pictures (--reconstruct off) or depth";
    if (lf_media_path_depth_bound(scene) > LF_MAX_NULL_DEPTH)
        return "media of more than 2900 mean free paths of their largest extinction";
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
    lf_free(s ? s->workers : NULL);
    lf_free(s);
}

static lf_status make_workers(state *s, const lf_film_layout *layout)
{
    s->workers = lf_calloc((size_t)s->n_workers, sizeof *s->workers);
    for (int i = 0; s->workers && i < s->n_workers; i++) {
        s->workers[i] = lf_calloc(1, sizeof **s->workers);
        if (!s->workers[i] || lf_film_sums_init(&s->workers[i]->sums, layout) != LF_OK)
            return LF_E_NOMEM;
        s->workers[i]->tracer.scene = &s->seen;
    }
    return s->workers ? LF_OK : LF_E_NOMEM;
}

static lf_status create(const lf_integrator_input *input, int index, void **out_state,
                        lf_integrator_needs *out_needs, lf_error *err)
{
    const char *refused = unknown(input->scene, input->settings);
    if (refused)
        return lf_error_set(err, LF_E_ARG, "integrator", "%s renders no %s", entries[index].name,
                            refused);
    state *s = lf_calloc(1, sizeof *s);
    if (!s)
        return LF_E_NOMEM;
    s->seen = *input->seen;
    s->film = input->film;
    s->shift = lf_shift_at(input->settings->shift);
    s->mis = index == MISMVPT;
    s->selection = s->mis ? &lf_selection_none : lf_selection_at(input->settings->selection);
    s->sampler = input->settings->sampler;
    s->max_depth = lf_max_depth(input->scene, input->settings->max_depth);
    s->n_workers = lf_pool_threads(input->pool);
    lf_status status =
        s->shift && s->selection
            ? lf_rig_init(&s->rig, input->settings, input->scene->origin, err)
            : lf_error_set(err, LF_E_ARG, "integrator", "no such shift or selection");
    const lf_integrator_needs needs = {
        .layout = {.n_views = s->rig.n_views, .width = s->rig.width, .height = s->rig.height},
        .visit_passes = s->rig.n_views};
    if (status == LF_OK)
        status = make_workers(s, &needs.layout);
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
        out->base_paths += w->base_paths;
        out->contributions += w->contributions;
        out->volume_lookups += w->tracer.lookups;
        out->nonfinite_dropped += w->tracer.nonfinite;
    }
    out->rays_traced = out->base_hidden = -1;
}

static void skipped(const void *the_state, json_t *out)
{
    (void)the_state, (void)out;
}

const lf_integrator lf_integrator_mvpt2022 = {.entry = entry,
                                              .create = create,
                                              .begin = begin,
                                              .visit = visit,
                                              .count = count,
                                              .skipped = skipped,
                                              .destroy = destroy};
