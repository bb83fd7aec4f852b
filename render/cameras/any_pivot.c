#include "render/cameras/any_pivot.h"

#include <assert.h>
#include <math.h>

#include "render/transport/lanes/depth.h"

/* --------------------------------------------------------------------------------- densities -- */

/* Density of view k's samples at the pivot without media, up to a factor common to all views, and
 * the ray to the pivot. 0: the view does not see it. The base always sees its own. */
static double density_of(const lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, int k,
                         lf_depth_ray *way)
{
    const bool base = k == p->view;
    const lf_event *e = &p->event;
    lf_pinhole_sight seen;
    lf_any_sight *out = &w->sight[k];
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
static double look(const lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, bool alone)
{
    double sum = 0.0, depth[LF_MAX_VIEWS];
    lf_depth_ray ways[LF_MAX_VIEWS];
    int n = 0;
    if (alone) {
        for (int k = 0; k < s->n_views; k++)
            w->sight[k].density = 0.0;
        lf_any_sight *own = &w->sight[p->view];
        *own = (lf_any_sight){1.0, p->row, (size_t)p->view * (size_t)s->width + (size_t)p->column,
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

/* ---------------------------------------------------------------------------------- suffixes -- */

/* The lobes of all views towards wi into f; returns the sum of density times pdf. */
static double lobes(const lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, lf_vec3 wi,
                    double densities)
{
    double sum = 0.0;
    if (!lf_is_view_dependent(&s->seen, &p->event)) {
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

/* Adds the radiance from one direction to all views, over a density. */
static void spread(lf_any_cameras *s, lf_any_worker *w, lf_vec3 arriving, bool pilot)
{
    if (!isfinite(arriving.x + arriving.y + arriving.z)) {
        w->tracer.nonfinite++;
        return;
    }
    for (int k = 0; k < s->n_views; k++) {
        const lf_any_sight *to = &w->sight[k];
        if (!(to->density > 0.0))
            continue;
        const lf_vec3 n = lf_mul(lf_scale(arriving, (float)to->density), w->f[k]);
        if (pilot)
            w->brightest = lf_max(w->brightest, lf_max3(n));
        else
            w->found[k] = lf_add(w->found[k], n);
    }
}

/* Contribution of a light sample with transmittance `left`, and of a direction, over their
 * densities: each is weighted against all others. over: sum of densities times pdf of all
 * directions. */
static lf_vec3 of_light(const lf_light_sample *light, float left, double densities, double over)
{
    const double density = (double)light->pdf * densities + (light->delta ? 0.0 : over);
    return lf_scale(light->radiance, (float)((double)left / density));
}

static lf_vec3 of_direction(const lf_suffix *d, double densities, double over)
{
    return lf_add(lf_scale(d->scattered, (float)(1.0 / over)),
                  lf_scale(d->found, (float)(1.0 / (over + (double)d->found_pdf * densities))));
}

/* A share of a pivot's light, from a light sample weighted against one direction. */
static void spread_light(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p,
                         double densities, float share, bool pilot)
{
    lf_suffix suffix = {0};
    lf_suffix_draw_light(&w->tracer, &p->event, p->sampler, &suffix);
    if (!(suffix.light_visible > 0.0f))
        return;
    const double over = lobes(s, w, p, suffix.light.wi, densities);
    spread(s, w, lf_scale(of_light(&suffix.light, suffix.light_visible, densities, over), share),
           pilot);
}

/* spread_light for a direction of the base's own lobe, and the light along it. */
static void spread_direction(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p,
                             double densities, float share, bool pilot)
{
    float u[3];
    lf_vec3 f;
    lf_suffix d = {0};
    lf_sampler_2d(p->sampler, u);
    u[2] = lf_sampler_1d(p->sampler);
    if (!(lf_scatter_sample(&s->seen, &p->event, lf_scale(p->event.w, -1.0f), u, &d.wi, &f) > 0.0f))
        return;
    const double over = lobes(s, w, p, d.wi, densities);
    float most = 0.0f;
    for (int k = 0; k < s->n_views; k++)
        if (w->sight[k].density > 0.0)
            most = lf_max(most, lf_max3(w->f[k]));
    if (!(most > 0.0f) || !(over > 0.0))
        return;
    w->tracer.spread = LF_SUFFIX_SPREAD;
    lf_suffix_follow(&w->tracer, &p->event, s->max_depth, &d);
    spread(s, w, lf_scale(of_direction(&d, densities, over), share), pilot);
}

/* Spreads the suffixes that lanes have traced for pivot `at`; in one step if they send the same to
 * every view. */
static void spread_batch(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, int at,
                         double densities)
{
    const lf_suffix_batch *batch = &w->queue->batch;
    const lf_batch_pivot *waits = &batch->pivot[at];
    const bool same = !lf_is_view_dependent(&s->seen, &p->event);
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    for (int k = waits->has_light ? -1 : 0; k < batch->each; k++) {
        lf_suffix d = {.wi = waits->light.wi};
        if (k >= 0)
            lf_suffix_batch_direction(batch, &s->seen, at, k, &d);
        const double over = batch->each * lobes(s, w, p, d.wi, densities);
        if (!(over > 0.0))
            continue;
        const lf_vec3 one = k < 0 ? of_light(&waits->light, batch->left[at], densities, over)
                                  : of_direction(&d, densities, over);
        if (!same || !isfinite(one.x + one.y + one.z))
            spread(s, w, one, false);
        else
            sum = lf_add(sum, one);
    }
    if (same)
        spread(s, w, sum, false);
}

/* Adds what all that see a pivot have found, and what their samples weigh. */
static void add_found(lf_any_cameras *s, lf_any_worker *w, double densities)
{
    for (int k = 0; k < s->n_views; k++) {
        const lf_any_sight *to = &w->sight[k];
        if (!(to->density > 0.0))
            continue;
        lf_splats_add(&s->splats, &w->tracer, to->row, to->pixel, w->found[k],
                      to->density / densities);
        w->contributions++;
    }
}

/* Computes a pivot's densities for all views; false: no view sees it. */
static bool weigh(const lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, bool alone,
                  double *out_densities)
{
    *out_densities = look(s, w, p, alone);
    const bool seen = *out_densities > 0.0 && isfinite(*out_densities);
    w->tracer.nonfinite += !seen;
    for (int k = 0; k < s->n_views && seen; k++)
        w->found[k] = lf_v3(0.0f, 0.0f, 0.0f);
    return seen;
}

void lf_any_scatter(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p, bool pilot)
{
    const int n = s->alone || pilot ? 1 : LF_ANY_SUFFIXES;
    double densities;
    if (!weigh(s, w, p, s->alone || pilot, &densities))
        return;
    for (int i = 0; i < n; i++) {
        spread_light(s, w, p, densities, 1.0f / (float)n, pilot);
        spread_direction(s, w, p, densities, 1.0f / (float)n, pilot);
    }
    if (!pilot)
        add_found(s, w, densities);
}

void lf_any_flush(lf_any_cameras *s, lf_any_worker *w, const lf_cancel *cancel)
{
    lf_any_queue *q = w->queue;
    double densities;
    lf_suffix_batch_trace(&q->batch, &w->tracer, s->max_depth);
    for (int i = 0; i < q->batch.n; i++) {
        const lf_batch_pivot *waits = &q->batch.pivot[i];
        const lf_any_pivot p = {.event = {.kind = LF_EVENT_MEDIUM,
                                          .p = waits->p,
                                          .w = waits->w,
                                          .volume = waits->volume},
                                .view = q->base[i].view,
                                .row = q->base[i].row,
                                .column = q->base[i].column,
                                .lens = {q->base[i].lens[0], q->base[i].lens[1]}};
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            break;
        /* rounding of sums uses separate random numbers, independent of the queue */
        w->tracer.rng = waits->rng;
        if (!weigh(s, w, &p, s->alone, &densities))
            continue;
        spread_batch(s, w, &p, i, densities);
        add_found(s, w, densities);
    }
    lf_suffix_batch_clear(&q->batch);
}

void lf_any_push(lf_any_cameras *s, lf_any_worker *w, const lf_any_pivot *p,
                 const lf_cancel *cancel)
{
    lf_any_queue *q = w->queue;
    const lf_batch_pivot waits = {
        .p = p->event.p, .w = p->event.w, .volume = p->event.volume, .rng = w->tracer.rng};
    const int at = lf_suffix_batch_add(&q->batch, &s->seen, &waits, p->sampler);
    q->base[at].view = p->view;
    q->base[at].row = p->row;
    q->base[at].column = p->column;
    q->base[at].lens[0] = p->lens[0];
    q->base[at].lens[1] = p->lens[1];
    lf_suffix_batch_keep_up(&q->batch, &w->tracer, s->max_depth);
    if (lf_suffix_batch_is_full(&q->batch))
        lf_any_flush(s, w, cancel);
}
