/* Adaptive Multi-view Path Tracing (Fraboni et al. 2019): a view is taken at random, with a
 * probability that is part of the sums over strategies (equation 19), so that they are unbiased. */
#include "render/papers/amv2019.h"

#include "base/alloc.h"
#include "render/papers/count.h"
#include "render/papers/share.h"
#include "render/papers/variation.h"

double lf_accepted(double jacobian, double own, double others, double alpha)
{
    double similar = fmin(jacobian, 1.0 / jacobian),
           distance = own + others > 0.0 ? fabs(own - others) / (own + others) : 0.0;
    return similar * pow(1.0 - distance, 1.0 / alpha);
}

/* The views of a pivot. */
typedef struct views {
    const lf_general *g;
    const lf_prefix *p;
    const lf_general_worker *w;
    bool sees[LF_MAX_VIEWS];
    double density[LF_MAX_VIEWS]; /* relative to the base's */
    double alpha;
    bool alike; /* lobes do not depend on the view */
} views;

static double pdf_of(const views *v, int view, lf_vec3 wi)
{
    lf_vec3 f;
    return (double)lf_scatter_eval(&v->g->seen, &v->p->event, lf_scale(v->w->to_pivot[view], -1.0f),
                                   wi, &f);
}

/* With which a view is taken by a base. */
static double probability(const views *v, int base, int view)
{
    double own = 1.0, others = 1.0;
    if (base == view)
        return 1.0;
    if (!v->alike) {
        lf_vec3 w = v->w->to_pivot[base], ns = v->p->event.hit.ns,
                mirrored = lf_madd(w, -2.0f * lf_dot(ns, w), ns);
        own = pdf_of(v, base, mirrored);
        others = pdf_of(v, view, mirrored);
    }
    return lf_accepted(v->density[view] / v->density[base], own, others, v->alpha);
}

static void look(views *v, lf_general_worker *w)
{
    const lf_general *g = v->g;
    const lf_prefix *p = v->p;
    const lf_material *m = lf_hit_material(&p->event.hit);
    double area = lf_prefix_area(g, p, p->view);
    lf_prefix_look(g, w, p);
    v->alike = !m->has_lobe || !m->kind->view_dependent;
    v->alpha = fmax((double)(m->roughness * m->roughness), 1e-4);
    for (int k = 0; k < g->rig.n_views; k++) {
        v->sees[k] = k == p->view || lf_prefix_visible(g, w, p, k);
        v->density[k] = v->sees[k] ? area / lf_prefix_area(g, p, k) : 0.0;
    }
}

/* Equation 19 over the sampling density, for a view that was taken: the sum is over all views that
 * could have drawn the pivot and taken this view. */
static double weight_of(const views *v, int view)
{
    double sum = 0.0;
    for (int j = 0; j < v->g->rig.n_views; j++)
        if (v->sees[j])
            sum += lf_expected_count(v->g, v->w, j, v->w->column[j]) * v->density[j] *
                   probability(v, j, view);
    return v->density[view] / sum;
}

static bool weigh(const lf_general *g, lf_general_worker *w, const lf_prefix *p)
{
    views v = {.g = g, .p = p, .w = w};
    double all = 0.0;
    look(&v, w);
    for (int k = 0; k < g->rig.n_views; k++) {
        bool taken =
            k == p->view || (v.sees[k] && (double)lf_rng(&w->tracer) < probability(&v, p->view, k));
        w->weight[k] = taken ? weight_of(&v, k) : 0.0;
        if (g->share_seen && k != p->view)
            w->weight[k] *= (double)g->share_seen[p->view * g->rig.n_views + k];
        all += w->weight[k];
    }
    return isfinite(all);
}

/* ----------------------------------------------------------------------------- normalisation -- */

/* Adds the views that see the pivot, each with the Jacobian as printed. */
static void add_seen(const lf_general *g, lf_general_worker *w, const lf_prefix *p, double n)
{
    if (p->event.kind == LF_EVENT_ESCAPE)
        return;
    lf_prefix_look(g, w, p);
    double area = lf_prefix_area(g, p, p->view);
    for (int k = 0; k < g->rig.n_views; k++)
        if (k != p->view && lf_prefix_visible(g, w, p, k))
            g->share_seen[p->view * g->rig.n_views + k] +=
                (float)(lf_prefix_area(g, p, k) / area / n);
}

lf_status lf_normalise(lf_general *g)
{
    enum { LINES = 32 };
    const int n_views = g->rig.n_views, width = g->rig.width, height = g->rig.height;
    const uint64_t key = lf_hash64(2019, 9);
    g->share_seen = lf_calloc((size_t)n_views * (size_t)n_views, sizeof *g->share_seen);
    if (!g->share_seen)
        return LF_E_NOMEM;
    lf_general_worker *w = &g->workers[0];
    const int64_t rays = w->tracer.rays;
    for (int view = 0; view < n_views; view++)
        for (int i = 0; i < LINES * LINES; i++) {
            lf_sampler sampler;
            uint64_t own = lf_hash64(key, (uint64_t)view * LINES * LINES + (uint64_t)i);
            const int line = i / LINES;
            double down = line + (double)(own >> 48) * 0x1p-16,
                   across = i % LINES + (double)(own & 0xffff) * 0x1p-16;
            lf_prefix p = {.row = (int)(down * height / LINES),
                           .view = view,
                           .column = (int)(across * width / LINES),
                           .alone = 1.0f,
                           .sampler = &sampler};
            lf_sampler_init(&sampler, LF_SAMPLER_INDEPENDENT, own, 0);
            w->tracer.rng = own;
            lf_prefix_draw(g, w, &p);
            add_seen(g, w, &p, LINES * LINES);
        }
    w->tracer.rays = rays; /* they do not contribute to the image */
    return LF_OK;
}

const lf_general_kind lf_general_amv2019 = {
    .entry = {.name = "amv2019",
              .what = "surfaces shared by Jacobian and lobe, as in 2019",
              .shares = true,
              .remembers = true,
              .supports = LF_GENERAL_SUPPORT},
    .adaptive = true,
    .map = lf_variation_map,
    .weigh = weigh};
const lf_general_kind lf_general_amv2019k = {
    .entry = {.name = "amv2019k",
              .what = "the same normalised by K, as printed: biased",
              .shares = true,
              .remembers = true,
              .supports = LF_GENERAL_SUPPORT},
    .mis = true,
    .adaptive = true,
    .normalises = true,
    .map = lf_variation_map,
    .weigh = weigh};
