#include "render/papers/share.h"

#include "render/transport/path/suffix_one.h"

/* Data behind the pivot that all views share. */
typedef struct shared {
    lf_suffix suffix;
    lf_vec3 emitted; /* by the pivot itself */
} shared;

static lf_vec3 emitted_by(const lf_general *g, const lf_prefix *p)
{
    float pdf;
    return p->event.kind == LF_EVENT_SURFACE && lf_has(&g->seen, LF_TRAIT_EMISSION)
               ? lf_light_hit(&g->seen, p->event.p, &p->event.hit, &pdf)
               : lf_v3(0.0f, 0.0f, 0.0f);
}

bool lf_share_possible(const lf_general *g, const lf_prefix *p)
{
    return p->event.kind == LF_EVENT_MEDIUM || p->event.hit.material->has_lobe ||
           lf_max3(emitted_by(g, p)) > 0.0f;
}

/* The pdf with which the sharing views draw a direction: the mean of their lobes' pdfs. */
static float mixture(const lf_general *g, const lf_general_worker *w, const lf_prefix *p,
                     lf_vec3 wi)
{
    float sum = 0.0f;
    int n = 0;
    lf_vec3 f;
    for (int k = 0; k < g->rig.n_views; k++) {
        if (!(w->weight[k] > 0.0))
            continue;
        sum += lf_scatter_eval(&g->seen, &p->event, lf_scale(w->to_pivot[k], -1.0f), wi, &f);
        n++;
    }
    return sum / (float)n;
}

static int pick_view(const lf_general *g, const lf_general_worker *w, float u)
{
    int n = 0, last = 0;
    for (int k = 0; k < g->rig.n_views; k++)
        n += w->weight[k] > 0.0;
    int wanted = (int)(u * (float)n);
    for (int k = 0; k < g->rig.n_views && wanted >= 0; k++) {
        if (!(w->weight[k] > 0.0))
            continue;
        last = k;
        wanted--;
    }
    return last;
}

static void draw_shared(const lf_general *g, lf_general_worker *w, const lf_prefix *p, shared *out)
{
    *out = (shared){.emitted = emitted_by(g, p)};
    if (p->event.kind == LF_EVENT_SURFACE && !p->event.hit.material->has_lobe)
        return;
    lf_suffix_draw_light(&w->tracer, &p->event, p->sampler, &out->suffix);
    const int from = pick_view(g, w, lf_sampler_1d(p->sampler));
    lf_suffix_redraw(&w->tracer, &p->event, lf_scale(w->to_pivot[from], -1.0f), p->sampler,
                     g->max_depth, &out->suffix);
}

/* Its radiance in a view, over the densities of light sampling and of the mixture. */
static lf_vec3 radiance_of(const lf_general *g, const lf_general_worker *w, const lf_prefix *p,
                           const shared *behind, float light_mixture, float own_mixture, int view)
{
    const lf_suffix *s = &behind->suffix;
    lf_vec3 wo = lf_scale(w->to_pivot[view], -1.0f), f, sum = behind->emitted;
    if (s->light_visible > 0.0f) {
        lf_scatter_eval(&g->seen, &p->event, wo, s->light.wi, &f);
        float pdf = s->light.pdf + (s->light.delta ? 0.0f : light_mixture);
        sum = lf_madd(sum, s->light_visible / pdf, lf_mul(f, s->light.radiance));
    }
    if (s->has_direction) {
        lf_scatter_eval(&g->seen, &p->event, wo, s->wi, &f);
        lf_vec3 arriving = lf_add(lf_scale(s->found, 1.0f / (own_mixture + s->found_pdf)),
                                  lf_scale(s->scattered, 1.0f / own_mixture));
        sum = lf_add(sum, lf_mul(f, arriving));
    }
    return sum;
}

/* Adds to N and W of a view pixel. */
static void add(const lf_general *g, lf_general_worker *w, int view, int column, double weight,
                lf_vec3 y)
{
    size_t pixel = (size_t)view * (size_t)g->rig.width + (size_t)column;
    float scale = (float)weight;
    if (!isfinite(y.x + y.y + y.z)) {
        w->tracer.nonfinite++;
        y = lf_v3(0.0f, 0.0f, 0.0f);
    }
    lf_film_scatter(&w->sums, pixel, scale * y.x, scale * y.y, scale * y.z);
    if (!g->kind->mis)
        lf_film_weigh(&w->sums, pixel, scale);
}

void lf_share_spread(const lf_general *g, lf_general_worker *w, const lf_prefix *p)
{
    shared behind;
    draw_shared(g, w, p, &behind);
    const lf_suffix *s = &behind.suffix;
    float light_mixture = s->light_visible > 0.0f ? mixture(g, w, p, s->light.wi) : 0.0f,
          own_mixture = s->has_direction ? mixture(g, w, p, s->wi) : 0.0f;
    for (int k = 0; k < g->rig.n_views; k++) {
        if (!(w->weight[k] > 0.0))
            continue;
        add(g, w, k, w->column[k], w->weight[k],
            radiance_of(g, w, p, &behind, light_mixture, own_mixture, k));
        w->contributions++;
    }
}

/* Marks pixels with only native samples, of delta lobes and here also of escapes: their number must
 * not add noise, so the map keeps one per pixel. */
static void mark_alone(const lf_general *g, const lf_prefix *p)
{
    if (g->kind->adaptive)
        lf_counts_mark_delta(&g->counts, p->row, p->view, p->column);
}

void lf_share_alone(const lf_general *g, lf_general_worker *w, const lf_prefix *p, lf_vec3 y)
{
    mark_alone(g, p);
    add(g, w, p->view, p->column, (double)p->alone, y);
}

void lf_share_deltas(const lf_general *g, lf_general_worker *w, const lf_prefix *p)
{
    lf_shading shading;
    size_t pixel = (size_t)p->view * (size_t)g->rig.width + (size_t)p->column;
    lf_shade(&p->event.hit, lf_scale(p->event.w, -1.0f), &shading);
    if (shading.n_deltas > 0)
        mark_alone(g, p);
    for (int i = 0; i < shading.n_deltas; i++) {
        const lf_delta *lobe = &shading.delta[i];
        float probability = lf_min(1.0f, 4.0f * lf_max3(lobe->f));
        lf_suffix suffix = {.wi = lobe->wi};
        if (lf_rng(&w->tracer) >= probability)
            continue;
        lf_suffix_follow(&w->tracer, &p->event, g->max_depth, &suffix);
        lf_vec3 y = lf_scale(lf_mul(lobe->f, lf_add(suffix.found, suffix.scattered)),
                             p->alone / probability);
        if (isfinite(y.x + y.y + y.z))
            lf_film_add_native(&w->sums, pixel, y.x, y.y, y.z);
        else
            w->tracer.nonfinite++;
    }
}
