#include "render/papers/share.h"

/* What behind the pivot all views share. */
typedef struct shared {
    lf_light_sample light;
    float visible; /* 0: no light sample */
    lf_vec3 wi, found, scattered;
    float found_pdf;
    bool has_direction;
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

/* The pdf with which the views that share draw a direction: the mean of their lobes'. */
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

/* Follows a direction to what it finds. */
static void follow(const lf_general *g, lf_general_worker *w, const lf_prefix *p, lf_vec3 wi,
                   lf_vec3 *found, float *found_pdf, lf_vec3 *scattered)
{
    lf_event next;
    lf_path_next(&w->tracer, &p->event, wi, &next);
    *found = lf_mul(lf_path_absorbed(&g->seen, &next),
                    lf_path_light_found(&g->seen, &p->event, &next, found_pdf));
    *scattered = lf_path_arriving(&w->tracer, &next, 2, g->max_depth);
}

static void draw_shared(const lf_general *g, lf_general_worker *w, const lf_prefix *p, shared *out)
{
    float u[3];
    lf_vec3 f;
    *out = (shared){.emitted = emitted_by(g, p)};
    if (p->event.kind == LF_EVENT_SURFACE && !p->event.hit.material->has_lobe)
        return;
    u[0] = lf_sampler_1d(p->sampler);
    lf_sampler_2d(p->sampler, u + 1);
    if (lf_light_draw(&g->seen, p->event.p, u, &out->light)) {
        out->visible = lf_path_visible(&w->tracer, &p->event, &out->light);
        out->light.radiance =
            lf_mul(out->light.radiance, lf_path_absorbed_light(&g->seen, &p->event, &out->light));
    }
    int from = pick_view(g, w, lf_sampler_1d(p->sampler));
    lf_sampler_2d(p->sampler, u);
    u[2] = lf_sampler_1d(p->sampler);
    out->has_direction = lf_scatter_sample(&g->seen, &p->event, lf_scale(w->to_pivot[from], -1.0f),
                                           u, &out->wi, &f) > 0.0f;
    if (!out->has_direction || !(lf_max3(f) > 0.0f || lf_path_serves_others(&p->event, out->wi)))
        return;
    w->tracer.spread = LF_SUFFIX_SPREAD;
    follow(g, w, p, out->wi, &out->found, &out->found_pdf, &out->scattered);
}

/* What of it arrives in a view, over the densities of light sampling and of the mixture. */
static lf_vec3 radiance_of(const lf_general *g, const lf_general_worker *w, const lf_prefix *p,
                           const shared *behind, float light_mixture, float own_mixture, int view)
{
    lf_vec3 wo = lf_scale(w->to_pivot[view], -1.0f), f, sum = behind->emitted;
    if (behind->visible > 0.0f) {
        const lf_light_sample *light = &behind->light;
        lf_scatter_eval(&g->seen, &p->event, wo, light->wi, &f);
        float pdf = light->pdf + (light->delta ? 0.0f : light_mixture);
        sum = lf_madd(sum, behind->visible / pdf, lf_mul(f, light->radiance));
    }
    if (behind->has_direction) {
        lf_scatter_eval(&g->seen, &p->event, wo, behind->wi, &f);
        lf_vec3 arriving = lf_add(lf_scale(behind->found, 1.0f / (own_mixture + behind->found_pdf)),
                                  lf_scale(behind->scattered, 1.0f / own_mixture));
        sum = lf_add(sum, lf_mul(f, arriving));
    }
    return sum;
}

/* N and W of a view pixel. */
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
    float light_mixture = behind.visible > 0.0f ? mixture(g, w, p, behind.light.wi) : 0.0f,
          own_mixture = behind.has_direction ? mixture(g, w, p, behind.wi) : 0.0f;
    for (int k = 0; k < g->rig.n_views; k++) {
        if (!(w->weight[k] > 0.0))
            continue;
        add(g, w, k, w->column[k], w->weight[k],
            radiance_of(g, w, p, &behind, light_mixture, own_mixture, k));
        w->contributions++;
    }
}

/* Where native samples are all there is, of delta lobes and here of what escapes, too, their number
 * must not add noise: the map leaves one a pixel. */
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
        float probability = lf_min(1.0f, 4.0f * lf_max3(lobe->f)), pdf;
        lf_vec3 found, scattered;
        if (lf_rng(&w->tracer) >= probability)
            continue;
        follow(g, w, p, lobe->wi, &found, &pdf, &scattered);
        lf_vec3 y = lf_scale(lf_mul(lobe->f, lf_add(found, scattered)), p->alone / probability);
        if (isfinite(y.x + y.y + y.z))
            lf_film_add_native(&w->sums, pixel, y.x, y.y, y.z);
        else
            w->tracer.nonfinite++;
    }
}
