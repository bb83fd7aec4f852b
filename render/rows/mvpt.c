/* mvpt: every pivot serves all views that see it. Prefix densities D_k and the full balance over
 * (pivot, direction) of docs/developer/estimators.md, sections 4 and 7. */
#include <string.h>

#include "render/rows/extinction.h"
#include "render/rows/fan_steps.h"
#include "render/rows/light_paths.h"
#include "render/rows/native.h"
#include "render/rows/prefix_factor.h"

/* Here and below, base is the view that drew the pivot; < 0: none, light has drawn it. */
void lf_fan_project(const lf_visit *visit, const lf_pivot *pivot, int base)
{
    const lf_rig *rig = visit->rig;
    lf_scratch *w = visit->worker;
    bool surface = pivot->event.kind == LF_EVENT_SURFACE;
    lf_vec3 n = surface ? pivot->event.hit.ng : lf_v3(0.0f, 0.0f, 0.0f);
    float nx = lf_dot(n, rig->right),
          nyz = (lf_dot(n, rig->up) * visit->plane.my + lf_dot(n, rig->forward)) * pivot->z;
    float yz2 = (1.0f + visit->plane.my * visit->plane.my) * pivot->z * pivot->z;
    const lf_projection of = {rig, pivot->x, pivot->z, pivot->lx, surface, nx, nyz, yz2};
    const lf_projected out = {w->x0, w->slope, w->z_end, w->column, w->scale};
    visit->kernels->fans->project(&of, lf_rig_lanes(rig), &out);
    for (int k = 0; k < rig->n_views && lf_has_fault(visit, LF_FAULT_NO_H); k++)
        w->scale[k] = w->scale[k] > 0.0f ? 1.0f : 0.0f;
    /* The base always sees its own pivot, although rounding may contradict at the frame's edge or
     * on a grazing surface. */
    if (base >= 0 && !(w->scale[base] > 0.0f)) {
        float lens = pivot->lx * rig->distance / rig->focus, per_pixel = 1.0f / rig->dx;
        float u = (rig->skew[base] + lens + rig->distance * w->slope[base] - rig->x0) * per_pixel;
        w->column[base] = (int)lf_min(lf_max(u, 0.0f), (float)(rig->width - 1));
        w->scale[base] = 1e-6f * fabsf(pivot->z);
    }
}

/* Clears scale[k] if a surface hides the pivot from view k; else multiplies it by the prefix
 * factors. The base always sees its pivot; disagreements are counted. */
static void visibility(const lf_visit *visit, const lf_pivot *pivot, int base)
{
    lf_scratch *w = visit->worker;
    const float seen[2] = {base >= 0 ? w->scale[base] : 0.0f, w->scale[0]};
    const lf_hit *on = pivot->event.kind == LF_EVENT_SURFACE ? &pivot->event.hit : NULL;
    const lf_row_cut section = lf_visit_section(visit);
    lf_section_hide(&section, pivot->event.p, on, lf_rig_lanes(visit->rig), w->x0, w->scale);
    lf_prefix_between(visit, pivot);
    if (base >= 0 && !(w->scale[base] > 0.0f)) {
        w->base_hidden++;
        w->scale[base] = seen[0];
    }
    if (lf_has_fault(visit, LF_FAULT_NO_VISIBILITY))
        w->scale[0] = seen[1];
}

/* Optical depths to the views, and the collision density in the slab that holds a medium pivot. */
static void prefixes(const lf_visit *visit, const lf_pivot *pivot, int base)
{
    lf_scratch *w = visit->worker;
    bool surface = pivot->event.kind == LF_EVENT_SURFACE;
    int lanes = lf_rig_lanes(visit->rig);
    for (int k = 0; k < lanes && w->media.n_here == 0; k++)
        w->tau[k] = 0.0f;
    if (w->media.n_here == 0)
        return;
    visit->extinction->depths(visit, surface ? -1 : pivot->medium);
    /* At the edge of a medium, rounding may give a density of 0, but the base has collided there.
     */
    if (!surface && base >= 0 && !(w->sigma[base] > 0.0f))
        w->sigma[base] = lf_max(
            lf_volume_sigma_t(&visit->scene->volumes[pivot->event.volume], pivot->event.p), 1e-6f);
    float my2 = 1.0f + visit->plane.my * visit->plane.my;
    for (int k = 0; k < lanes; k++) {
        w->tau[k] *= sqrtf(my2 + w->slope[k] * w->slope[k]);
        w->scale[k] *= surface ? 1.0f : w->sigma[k];
    }
}

/* Expected counts of the pixels that the pivot projects to; views whose pixel no reader needs are
 * excluded. */
static void counts(const lf_visit *visit, int base, int column)
{
    lf_scratch *w = visit->worker;
    size_t width = (size_t)visit->rig->width;
    for (int k = 0; k < visit->rig->n_views; k++) {
        w->count[k] = visit->expected[(size_t)k * width + (size_t)w->column[k]];
        w->scale[k] = w->count[k] > 0.0f ? w->scale[k] : 0.0f;
    }
    /* Rounding may have moved the base's own pivot over the edge of a pixel that is read. */
    if (base >= 0 && !(w->count[base] > 0.0f)) {
        w->column[base] = column;
        w->count[base] = visit->expected[(size_t)base * width + (size_t)column];
        w->scale[base] = 1e-6f * fabsf(w->z_end[base]);
    }
}

/* The densities of all strategies, c_k D_k. sum is their sum if all c_k are 1; returns the actual
 * sum. */
static float strategies(const lf_visit *visit, float sum)
{
    lf_scratch *w = visit->worker;
    memcpy(w->strategy, w->density, sizeof *w->strategy * (size_t)lf_rig_lanes(visit->rig));
    if (!visit->expected)
        return sum;
    sum = 0.0f;
    for (int k = 0; k < visit->rig->n_views; k++) {
        w->strategy[k] =
            lf_has_fault(visit, LF_FAULT_NO_COUNTS) ? w->density[k] : w->count[k] * w->density[k];
        sum += w->strategy[k];
    }
    return sum;
}

/* Replaces the sampling densities by the densities that views receive: D_k becomes D_k R_k. The sum
 * over strategies is unchanged. false: all are 0. */
static bool receive(const lf_visit *visit, const lf_pivot *pivot)
{
    lf_scratch *w = visit->worker;
    const int n = lf_rig_lanes(visit->rig);
    float sampled[LF_MAX_LANES];
    if (!visit->prefix.received)
        return true;
    const lf_rays rays = lf_visit_rays(visit, 0, n);
    for (int k = 0; k < n; k++)
        sampled[k] = w->density[k] > 0.0f ? w->sigma[k] : 0.0f;
    if (!lf_prefix_received(visit, pivot, &rays, sampled, w->channels.factor))
        return false;
    visit->extinction->weigh(visit, w->channels.factor);
    return true;
}

/* LF_FAULT_REALISED: the sum over the views that happen to have a base sample here, instead of over
 * expected counts. */
static float realised_sum(const lf_visit *visit, int base)
{
    const lf_scratch *w = visit->worker;
    float sum = 0.0f;
    for (int k = 0; k < visit->rig->n_views; k++)
        if (k == base || lf_lattice_has(visit, k, w->column[k]))
            sum += w->density[k];
    return sum * (float)visit->rig->n_views / (float)visit->subsets;
}

/* Computes the light along a direction of a pivot on a surface, if that is pending. over: the
 * density of the direction under all views, times c_k D_k. */
static void follow(lf_visit *visit, const lf_pivot *pivot, float over, lf_suffix *suffix)
{
    lf_tracer *tracer = &visit->worker->tracer;
    lf_light_balance balance;
    const bool shared =
        lf_light_balance_of(visit, pivot, suffix->wi, lf_fan_unit(visit, pivot) * over, &balance);
    if (suffix->is_pending)
        lf_suffix_follow_in_balance(tracer, &pivot->event, visit->max_depth,
                                    shared ? &balance : NULL, suffix);
}

/* The radiance of one of the suffixes. */
static lf_vec3 sent_by(lf_visit *visit, const lf_pivot *pivot, const lf_splitting *of, lf_vec3 wo,
                       float sum, lf_suffix *suffix)
{
    if (suffix->is_pending) {
        lf_vec3 f;
        const float pdf = visit->plan->light
                              ? lf_scatter_eval(visit->scene, &pivot->event, wo, suffix->wi, &f)
                              : 0.0f;
        follow(visit, pivot, (float)of->suffixes * pdf * sum, suffix);
    }
    return lf_suffix_radiance_of(visit->scene, &pivot->event, wo, of, suffix);
}

/* Draws the suffixes after the first; returns the mean of all. */
static lf_vec3 sent_by_all(lf_visit *visit, const lf_pivot *pivot, lf_vec3 wo, float sum,
                           lf_suffix *first)
{
    const lf_splitting of = lf_visit_splitting(visit, &pivot->event);
    lf_vec3 y = sent_by(visit, pivot, &of, wo, sum, first);
    for (int i = 1; i < of.suffixes; i++) {
        lf_suffix next = {0};
        lf_suffix_draw_of(&visit->worker->tracer, &pivot->event, wo, pivot->sampler, &of, i, &next);
        y = lf_add(y, sent_by(visit, pivot, &of, wo, sum, &next));
    }
    return lf_visit_mean(visit, y, of.suffixes);
}

/* The lobe does not depend on the view: one radiance for all views. */
static void spread_uniform(lf_visit *visit, const lf_pivot *pivot, lf_suffix *suffix, lf_vec3 wo,
                           float sum)
{
    lf_scratch *w = visit->worker;
    lf_vec3 y = sent_by_all(visit, pivot, wo, sum, suffix);
    if (!isfinite(y.x + y.y + y.z)) {
        w->tracer.nonfinite++;
        y = lf_v3(0.0f, 0.0f, 0.0f);
    }
    float scale = pivot->forced_weight / sum;
    visit->extinction->spread(visit, y, scale);
    for (int k = 0; k < visit->rig->n_views && visit->sums.half.w2; k++)
        if (w->density[k] * scale != 0.0f)
            lf_film_weigh_direction(&visit->sums, lf_visit_pixel(visit, k), w->density[k] * scale);
}

/* Henyey-Greenstein of every view towards wi (phase.h: lf_phase_between). */
static void phases(lf_visit *visit, float g, lf_vec3 wi, float *out)
{
    const lf_rig *rig = visit->rig;
    const float sign = copysignf(1.0f, g),
                to[3] = {sign * lf_dot(wi, rig->right), sign * lf_dot(wi, rig->up),
                         sign * lf_dot(wi, rig->forward)};
    visit->kernels->fans->phases(g, to, visit->plane.my, lf_rig_lanes(rig), visit->worker->slope,
                                 out);
}

/* The cosines between w and the rays. */
static void cosines(const lf_visit *visit, lf_vec3 w, float *out)
{
    const lf_rig *rig = visit->rig;
    const float my = visit->plane.my;
    const lf_fan_axis axis = {.across = lf_dot(w, rig->right),
                              .along = my * lf_dot(w, rig->up) + lf_dot(w, rig->forward),
                              .my2 = 1.0f + my * my};
    visit->kernels->fans->cosines(&axis, lf_rig_lanes(rig), visit->worker->slope, out);
}

static void mix_second_lobe(lf_visit *visit, const lf_second_lobe *second, lf_vec3 wi)
{
    lf_scratch *w = visit->worker;
    float other[LF_MAX_LANES], cosine[LF_MAX_LANES];
    phases(visit, second->g, wi, other);
    cosines(visit, wi, cosine);
    for (int k = 0; k < lf_rig_lanes(visit->rig); k++)
        w->lobe[k] =
            lf_lerp(w->lobe[k], other[k] * lf_phase_draine(second->g, second->alpha, cosine[k]),
                    second->share);
}

/* The directions to the views in a surface's frame. */
void lf_fan_look_back(const lf_visit *visit, const lf_hit *hit)
{
    lf_vec3 t, b;
    lf_tangents(hit->ns, &t, &b);
    const lf_vec3 axis[3] = {t, b, hit->ns};
    for (int a = 0; a < 3; a++)
        cosines(visit, lf_scale(axis[a], -1.0f), visit->worker->local[a]);
}

/* wi in the frame of the shading normal. */
static void eval_surface(const lf_visit *visit, const lf_material *material, lf_vec3 wi,
                         lf_fan_lobes *out)
{
    float(*local)[LF_MAX_LANES] = visit->worker->local;
    visit->kernels->surfaces->of[material->kind->fan](material, wi, lf_rig_lanes(visit->rig),
                                                      local[0], local[1], local[2], out);
}

/* Adds the mirrored lobe of a bent normal (lf_hit_bent_normal). */
static void fold(const lf_visit *visit, const lf_hit *hit, lf_vec3 wi, lf_fan_lobes *out)
{
    const lf_material *material = lf_hit_material(hit);
    float pdf[LF_MAX_LANES], f[3][LF_MAX_LANES];
    lf_fan_lobes more = {.pdf = pdf, .f = {f[0], f[1], f[2]}};
    lf_vec3 t, b, back = lf_hit_mirrored(hit, wi);
    lf_tangents(hit->ns, &t, &b);
    eval_surface(visit, material, lf_to_frame(t, b, hit->ns, back), &more);
    const float own = lf_hit_wrong_side(hit, wi) ? 0.0f : 1.0f,
                mirrored = lf_hit_wrong_side(hit, back) ? 1.0f : 0.0f;
    for (int k = 0; k < lf_rig_lanes(visit->rig); k++) {
        out->pdf[k] = own * out->pdf[k] + mirrored * pdf[k];
        for (int c = 0; c < 3; c++)
            out->f[c][k] = own * out->f[c][k] + mirrored * f[c][k];
    }
}

float lf_fan_eval(lf_visit *visit, const lf_pivot *pivot, lf_vec3 wi, lf_fan_lobes *out)
{
    lf_scratch *w = visit->worker;
    *out = (lf_fan_lobes){
        .pdf = w->lobe, .f = {w->f[0], w->f[1], w->f[2]}, .colour = {1.0f, 1.0f, 1.0f}};
    if (pivot->event.kind == LF_EVENT_MEDIUM) {
        const lf_volume *volume = &visit->scene->volumes[pivot->event.volume];
        phases(visit, volume->g, wi, w->lobe);
        if (volume->second.share > 0.0f)
            mix_second_lobe(visit, &volume->second, wi);
        out->f[0] = out->f[1] = out->f[2] = w->lobe;
        out->colour = lf_volume_albedo(volume, pivot->event.p);
    } else {
        const lf_hit *hit = &pivot->event.hit;
        lf_vec3 t, b;
        lf_tangents(hit->ns, &t, &b);
        const lf_material *material = lf_hit_material(hit);
        eval_surface(visit, material, lf_to_frame(t, b, hit->ns, wi), out);
        if (lf_hit_bent_normal(hit))
            fold(visit, hit, wi, out);
    }
    return visit->kernels->fans->pdf(lf_rig_lanes(visit->rig), w->strategy, w->lobe);
}

static void begin_sent(int lanes, lf_sent *sent)
{
    for (int c = 0; c < 3; c++)
        memset(sent->n[c], 0, (size_t)lanes * sizeof *sent->n[c]);
    memset(sent->w2, 0, (size_t)lanes * sizeof *sent->w2);
}

/* Adds density_k f_k times one radiance of every view. */
static void add_lobes(lf_visit *visit, const lf_fan_lobes *f, lf_vec3 radiance, lf_sent *sent)
{
    lf_scratch *w = visit->worker;
    if (!isfinite(radiance.x + radiance.y + radiance.z)) {
        w->tracer.nonfinite++;
        return;
    }
    /* below 0 if a control variate was too large */
    if (radiance.x == 0.0f && radiance.y == 0.0f && radiance.z == 0.0f)
        return;
    visit->kernels->fans->collect(lf_rig_lanes(visit->rig), w->channels.received, f,
                                  lf_mul(radiance, f->colour), sent);
}

/* W' of every view: the weight of the direction, independent of the light along it; over = 0: no
 * direction. Views from below the shading horizon draw no directions and receive nothing; they get
 * their share of W. */
static void add_directional(lf_visit *visit, const lf_pivot *pivot, float over, float sum,
                            lf_sent *sent)
{
    const lf_scratch *w = visit->worker;
    const bool blinds =
        pivot->event.kind == LF_EVENT_SURFACE && !lf_is_way_out(lf_hit_material(&pivot->event.hit));
    const lf_fan_share share = {.lobe = over > 0.0f ? w->lobe : NULL,
                                .z = blinds ? w->local[2] : NULL,
                                .drawn = over > 0.0f ? pivot->forced_weight / over : 0.0f,
                                .blind = pivot->forced_weight / sum};
    visit->kernels->fans->collect_shares(lf_rig_lanes(visit->rig), w->density, &share, sent);
}

/* Adds to the film what all directions of a pivot send, and W of every view: scale times its
 * density. */
static void deliver(lf_visit *visit, const lf_sent *sent, float scale)
{
    lf_scratch *w = visit->worker;
    for (int k = 0; k < visit->rig->n_views; k++) {
        const lf_film_scattered one = {{sent->n[0][k], sent->n[1][k], sent->n[2][k]},
                                       w->density[k] * scale};
        if (w->density[k] == 0.0f)
            continue;
        const size_t pixel = lf_visit_pixel(visit, k);
        lf_film_add_times(&visit->sums, pixel, 1.0f, &one);
        if (visit->sums.half.w2)
            lf_film_weigh_direction(&visit->sums, pixel, sent->w2[k]);
        w->contributions++;
    }
}

/* The light sample, in balance with n directions. */
static void spread_light(lf_visit *visit, const lf_pivot *pivot, const lf_suffix *suffix, float sum,
                         int n, lf_sent *sent)
{
    const lf_light_sample *light = &suffix->light;
    lf_fan_lobes f;
    float over = (float)n * lf_fan_eval(visit, pivot, light->wi, &f);
    bool alone = light->delta || lf_has_fault(visit, LF_FAULT_NO_LIGHT_PDF);
    float denominator = light->pdf * sum + (alone ? 0.0f : over);
    add_lobes(visit, &f,
              lf_scale(light->radiance, pivot->forced_weight * suffix->light_visible / denominator),
              sent);
}

/* One of n directions, weighted against the light sample. */
static void spread_direction(lf_visit *visit, const lf_pivot *pivot, lf_suffix *suffix, float sum,
                             int n, lf_sent *sent)
{
    lf_fan_lobes f;
    bool below =
        pivot->event.kind == LF_EVENT_SURFACE && !(lf_dot(pivot->event.hit.ns, suffix->wi) > 0.0f);
    bool drawn = suffix->has_direction && !(below && lf_has_fault(visit, LF_FAULT_HORIZON));
    float over = drawn ? (float)n * lf_fan_eval(visit, pivot, suffix->wi, &f) : 0.0f;
    if (suffix->is_pending)
        follow(visit, pivot, over, suffix);
    if (over > 0.0f) {
        float with_light =
            over + (lf_has_fault(visit, LF_FAULT_NO_LIGHT_PDF) ? 0.0f : suffix->found_pdf * sum);
        lf_vec3 radiance = lf_madd(lf_scale(suffix->scattered, pivot->forced_weight / over),
                                   pivot->forced_weight / with_light, suffix->found);
        add_lobes(visit, &f, radiance, sent);
    }
    if (visit->sums.half.w2)
        add_directional(visit, pivot, over, (float)n * sum, sent);
}

/* The direction back to view k with probability c_k D_k / sum, u in [0, 1). */
static lf_vec3 some_way_back(const lf_visit *visit, const lf_pivot *pivot, float u, float sum)
{
    const lf_scratch *w = visit->worker;
    float rest = u * sum;
    int view = 0;
    for (int k = 0; k < visit->rig->n_views && rest >= 0.0f; k++) {
        view = w->strategy[k] > 0.0f ? k : view;
        rest -= w->strategy[k];
    }
    return lf_normalize(
        lf_sub(lf_rig_point(visit->rig, w->x0[view], visit->plane.ly, 0.0f), pivot->event.p));
}

int lf_fan_directions(const lf_visit *visit, const lf_pivot *pivot)
{
    return lf_fan_is_glossy(visit->scene, &pivot->event)
               ? LF_GLOSSY_DIRECTIONS
               : lf_visit_splitting(visit, &pivot->event).suffixes;
}

/* The lobe depends on the view: balance heuristic over all views' lobes and light sampling. Further
 * directions are drawn from the base's own lobe, too, or from the lobes of other views, in
 * proportion to their densities. Averaged over bases, the density is sum_k c_k D_k pdf_k. */
static void spread_lobes(lf_visit *visit, const lf_pivot *pivot, lf_suffix *suffix, float sum)
{
    bool surface = pivot->event.kind == LF_EVENT_SURFACE;
    lf_sent sent;
    int n = lf_fan_directions(visit, pivot);
    begin_sent(lf_rig_lanes(visit->rig), &sent);
    for (const lf_suffix *next = suffix->next; next; next = next->next)
        n++;
    if (surface)
        lf_fan_look_back(visit, &pivot->event.hit);
    if (suffix->has_light)
        spread_light(visit, pivot, suffix, sum, n, &sent);
    spread_direction(visit, pivot, suffix, sum, n, &sent);
    for (lf_suffix *next = suffix->next; next; next = next->next)
        spread_direction(visit, pivot, next, sum, n, &sent);
    for (int i = 1; i < n && !suffix->next; i++) {
        float u = ((float)(i - 1) + lf_rng(&visit->worker->tracer)) / (float)(n - 1);
        lf_suffix_turn(&visit->worker->tracer, &pivot->event, some_way_back(visit, pivot, u, sum),
                       pivot->sampler, suffix);
        spread_direction(visit, pivot, suffix, sum, n, &sent);
    }
    deliver(visit, &sent, pivot->forced_weight / sum);
}

/* Thin glass has weight in W and in W' like any hit; its reflection is native. */
static void spread_thin(lf_visit *visit, const lf_pivot *pivot, float sum)
{
    const lf_scratch *w = visit->worker;
    const float scale = pivot->forced_weight / sum;
    lf_sent sent;
    begin_sent(lf_rig_lanes(visit->rig), &sent);
    for (int k = 0; k < visit->rig->n_views; k++)
        sent.w2[k] = w->density[k] * scale;
    deliver(visit, &sent, scale);
}

/* The densities of the pivot under all views; returns the sum of those that samples are drawn with.
 */
static float fan(lf_visit *visit, int base, int column, const lf_pivot *pivot)
{
    lf_fan_project(visit, pivot, base);
    if (visit->expected)
        counts(visit, base, column);
    prefixes(visit, pivot, base);
    if (visit->triangles)
        visibility(visit, pivot, base);
    lf_prefix_at(visit, pivot);
    float sum = visit->extinction->densities(visit, pivot);
    sum = strategies(visit, sum);
    return lf_has_fault(visit, LF_FAULT_REALISED) && base >= 0 ? realised_sum(visit, base) : sum;
}

/* The smallest depth, which the densities of the fan omit (lf_kernels.densities). */
static float least_depth(const lf_visit *visit)
{
    const lf_scratch *w = visit->worker;
    float least = INFINITY;
    for (int k = 0; k < visit->rig->n_views; k++)
        least = lf_min(least, w->scale[k] > 0.0f ? w->tau[k] : INFINITY);
    return least;
}

static void pivot_mvpt(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                       const lf_suffix *given)
{
    float sum = fan(visit, view, column, pivot);
    if (!(sum > 0.0f && sum < INFINITY)) { /* a camera touches the pivot */
        visit->worker->tracer.nonfinite++;
        return;
    }
    if (!receive(visit, pivot))
        return;
    if (pivot->is_thin) {
        spread_thin(visit, pivot, sum);
        return;
    }
    lf_tracer *tracer = &visit->worker->tracer;
    lf_suffix suffix;
    lf_vec3 wo = lf_scale(pivot->event.w, -1.0f);
    if (given) {
        suffix = *given;
    } else {
        suffix = (lf_suffix){0};
        const lf_splitting of = lf_visit_splitting(visit, &pivot->event);
        lf_suffix_draw_of(tracer, &pivot->event, wo, pivot->sampler, &of, 0, &suffix);
    }
    if (suffix.is_pending && pivot->event.kind == LF_EVENT_MEDIUM)
        lf_suffix_follow(tracer, &pivot->event, visit->max_depth, &suffix);
    if (visit->worker->equiangular.n > 0 && pivot->event.kind == LF_EVENT_MEDIUM)
        lf_equiangular_balance(visit, pivot, -1, sum, least_depth(visit), &suffix);
    if (lf_is_view_dependent(visit->scene, &pivot->event))
        spread_lobes(visit, pivot, &suffix, sum);
    else
        spread_uniform(visit, pivot, &suffix, wo, sum);
}

/* A point around a light serves all views that see it, in addition to their own base samples. */
static void equiangular_mvpt(lf_visit *visit, int view, const lf_pivot *pivot,
                             const lf_light_sample *light)
{
    (void)view;
    float sum = fan(visit, -1, 0, pivot);
    if (!(sum > 0.0f) || !receive(visit, pivot))
        return;
    lf_light_sample arriving = *light;
    float visible = lf_path_visible(&visit->worker->tracer, &pivot->event, &arriving);
    if (!(visible > 0.0f))
        return;
    lf_fan_lobes f;
    float over = lf_fan_eval(visit, pivot, light->wi, &f),
          ratio = lf_equiangular_ratio(visit, pivot, light->light, -1, sum, least_depth(visit));
    float denominator = light->pdf * (1.0f + ratio) * sum + (light->delta ? 0.0f : over);
    lf_vec3 radiance = lf_scale(lf_mul(arriving.radiance, f.colour), visible / denominator);
    const float *const *d = visit->worker->channels.received;
    for (int k = 0; k < visit->rig->n_views; k++) {
        if (visit->worker->density[k] == 0.0f)
            continue;
        lf_vec3 own = lf_v3(d[0][k], d[1][k], d[2][k]);
        lf_visit_add_native(visit, lf_visit_pixel(visit, k),
                            lf_mul(radiance, lf_scale(own, visit->worker->lobe[k])));
    }
}

static void balance_mvpt(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                         lf_suffix *suffix)
{
    float sum = fan(visit, view, column, pivot);
    lf_equiangular_balance(visit, pivot, -1, sum, least_depth(visit), suffix);
}

static float over_mvpt(lf_visit *visit, int view, int column, const lf_pivot *pivot, lf_vec3 wi)
{
    lf_fan_lobes lobes;
    lf_vec3 f;
    const float sum = fan(visit, view, column, pivot);
    if (lf_is_view_dependent(visit->scene, &pivot->event)) {
        lf_fan_look_back(visit, &pivot->event.hit);
        return lf_fan_unit(visit, pivot) * (float)lf_fan_directions(visit, pivot) *
               lf_fan_eval(visit, pivot, wi, &lobes);
    }
    return lf_fan_unit(visit, pivot) * sum * (float)lf_fan_directions(visit, pivot) *
           lf_scatter_eval(visit->scene, &pivot->event, lf_scale(pivot->event.w, -1.0f), wi, &f);
}

const lf_sharing lf_sharing_mvpt = {.entry = {.name = "mvpt",
                                              .what = "all views share paths",
                                              .shares = true,
                                              .reconstructs = true,
                                              .takes_light_paths = true,
                                              .splits = true,
                                              .supports = LF_ROWS_SUPPORT},
                                    .suffixes = 4,
                                    .pivot = pivot_mvpt,
                                    .equiangular = equiangular_mvpt,
                                    .balance = balance_mvpt,
                                    .over = over_mvpt};
const lf_sharing lf_sharing_amvpt = {.entry = {.name = "amvpt",
                                               .what = "adaptive mvpt",
                                               .shares = true,
                                               .reconstructs = true,
                                               .remembers = true,
                                               .supports = LF_ROWS_SUPPORT},
                                     .suffixes = 4,
                                     .adaptive = true,
                                     .pivot = pivot_mvpt,
                                     .equiangular = equiangular_mvpt,
                                     .balance = balance_mvpt};
