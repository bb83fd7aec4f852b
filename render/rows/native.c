#include "render/rows/native.h"

#include "render/rows/adaptive.h"
#include "render/rows/prefix_factor.h"
#include "render/transport/path/delta_chain.h"
#include "render/transport/surface/surface_glass.h"
#include "render/transport/surface/surface_texture.h"

/* Whether base samples follow delta lobes also in pixels with samples of their own
 * (sample_mirrors). Only if all pixels get equally many base samples, or as many as the map
 * expects, or if there are no others. Otherwise pixels with one more would be brighter. */
static bool base_counts(const lf_visit *visit)
{
    return visit->mirror_rounds == 0 || visit->expected ||
           visit->subsets % visit->rig->n_views == 0;
}

/* 1 over the native samples that a pixel expects, base samples and its own, in units of g / n. */
static float native_weight(const lf_visit *visit, size_t pixel)
{
    float base = visit->expected ? visit->expected[pixel] : 1.0f;
    if (!visit->worker->mirrors || !visit->worker->mirrors[pixel])
        return visit->alone;
    return 1.0f / ((base_counts(visit) ? base : 0.0f) + visit->more);
}

void lf_visit_add_native(lf_visit *visit, size_t pixel, lf_vec3 radiance)
{
    if (!isfinite(radiance.x + radiance.y + radiance.z)) {
        visit->worker->tracer.nonfinite++;
        return;
    }
    lf_film_add_native(&visit->sums, pixel, radiance.x, radiance.y, radiance.z);
}

/* Of a visit's sample of a pixel: native, times what it weighs in M and N. */
static lf_vec3 weight_of(const lf_visit *visit, int view, size_t pixel, const lf_pivot *pivot)
{
    lf_vec3 channels;
    float weight =
        visit->weight * native_weight(visit, pixel) * lf_prefix_own(visit, view, pivot, &channels);
    return lf_scale(channels, weight);
}

/* Whether light scattered behind the delta lobes of a first surface goes to N, with its own weight,
 * q and features. So it is if that surface has no other lobe and the film has features for the
 * reconstruction. */
static bool stands_apart(const lf_visit *visit, const lf_pivot *pivot)
{
    return visit->sums.feature && visit->mirror_rounds > 0 &&
           !lf_hit_material(&pivot->event.hit)->has_lobe;
}

static void chain_begin(const lf_visit *visit, int view, const lf_pivot *pivot, bool apart,
                        lf_delta_chain *out)
{
    const float slope = (pivot->x - visit->rig->b[view] - pivot->lx) / pivot->z,
                my = visit->plane.my;
    *out = (lf_delta_chain){.tracer = &visit->worker->tracer,
                            .max_depth = visit->max_depth,
                            .sunlight = visit->plan->order.sunlight,
                            .apart = apart,
                            .tinted = visit->worker->sums.albedo,
                            .distance = visit->rig->distance,
                            .z = pivot->z,
                            .forward = 1.0f / sqrtf(1.0f + slope * slope + my * my)};
}

/* Updates the albedo of a visit's pixel in the same way. The colour of the chain itself, for
 * example tinted glass, may exceed 1 relative to the mean; the excess stays in R. */
static void note_chain_albedo(const lf_visit *visit, size_t pixel, float q,
                              const lf_delta_chain *chain)
{
    const float before = lf_max(visit->sums.half.q[pixel], 0.0f);
    float albedo[LF_ALBEDO_NUMBERS];
    for (int i = 0; i < LF_ALBEDO_NUMBERS && q > 0.0f; i++) {
        float of_chain = lf_min(chain->albedo[i] / chain->weight, 1.0f);
        albedo[i] = (before * visit->sums.albedo[pixel][i] + q * of_chain) / (before + q);
    }
    if (q > 0.0f)
        lf_film_note_albedo(&visit->sums, pixel, albedo);
}

/* Updates q and features of a visit's pixel, which already describe its own surface if that is not
 * all smooth. */
static void note_chain(const lf_visit *visit, size_t pixel, float q, const lf_delta_chain *chain)
{
    const float inverse = 1.0f / chain->weight, nearness = chain->nearness * inverse,
                variance = chain->nearness2 * inverse - nearness * nearness,
                before = visit->sums.half.q[pixel];
    lf_feature feature = {
        .nearness = lf_min(nearness, LF_NEARNESS_MAX),
        .spread = sqrtf(lf_max(variance, 0.0f)),
        .surface = 1.0f, /* a mirror counts fully, whatever it shows (renderer_layers.c) */
        .light = chain->light * inverse};
    if (q < 0.0f)
        feature = visit->sums.feature[pixel];
    else if (before > 0.0f)
        feature = lf_feature_mix(&visit->sums.feature[pixel], (double)before, &feature, (double)q);
    if (visit->sums.albedo)
        note_chain_albedo(visit, pixel, q, chain);
    lf_film_note(&visit->sums, pixel, feature);
    lf_film_pivots(&visit->sums, pixel, before + q);
}

/* Light goes to M and, for light that stands apart, to N. The divisor of N is known for each
 * sample, and so is q: its mean. */
static void chain_end(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                      const lf_delta_chain *chain)
{
    size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    const lf_vec3 weight = weight_of(visit, view, pixel, pivot);
    const lf_vec3 scattered = lf_mul(chain->scattered, weight);
    const float w = lf_mean3(weight) * chain->weight;
    lf_visit_add_native(visit, pixel, lf_mul(chain->known, weight));
    if (!chain->apart || w == 0.0f)
        return;
    if (!isfinite(scattered.x + scattered.y + scattered.z + w)) {
        visit->worker->tracer.nonfinite++;
        return;
    }
    lf_film_scatter(&visit->sums, pixel, scattered.x, scattered.y, scattered.z);
    lf_film_weigh(&visit->sums, pixel, w);
    if (visit->sums.half.w2)
        lf_film_weigh_direction(&visit->sums, pixel, w);
    note_chain(visit, pixel, w * (float)visit->rig->n_views / (float)visit->subsets, chain);
}

/* The emission of an alpha surface: native, because a sample ends on it at random. The emission of
 * other surfaces is known (unscattered.c). */
static void add_emission_of_alpha(lf_visit *visit, int view, int column, const lf_pivot *pivot)
{
    const lf_hit *hit = &pivot->event.hit;
    if (hit->material->cover == LF_COVER_OPAQUE || !(lf_max3(hit->material->emission) > 0.0f))
        return;
    size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    lf_visit_add_native(
        visit, pixel, lf_mul(lf_hit_material(hit)->emission, weight_of(visit, view, pixel, pivot)));
}

void lf_natives_of_thin_glass(lf_visit *visit, int view, int column, const lf_pivot *ray,
                              lf_vec3 eye, float t_end)
{
    lf_tracer *tracer = &visit->worker->tracer;
    lf_pivot pivot = *ray;
    lf_event *event = &pivot.event;
    float t = 0.0f;
    event->kind = LF_EVENT_SURFACE;
    while (lf_trace_thin(tracer, eye, event->w, t, t_end, &event->hit)) {
        lf_vec3 d = lf_sub(event->hit.p, visit->rig->eye);
        lf_delta lobe[LF_MAX_DELTAS];
        lf_delta_chain chain;
        const lf_material *m = event->hit.material;
        float cosine = -lf_dot(event->hit.ns, event->w);
        t = lf_behind(event->hit.t);
        event->p = event->hit.p;
        pivot.x = lf_dot(d, visit->rig->right);
        pivot.z = lf_dot(d, visit->rig->forward);
        if (m->kind->deltas(m, event->hit.ng, event->hit.ns, lf_scale(event->w, -1.0f),
                            event->hit.front, lobe) == 0)
            continue;
        chain_begin(visit, view, &pivot, false, &chain);
        lf_delta_chain_follow(&chain, event, lobe, 1.0f - lf_thin_passes(m, cosine));
        chain_end(visit, view, column, &pivot, &chain);
    }
}

bool lf_natives_by_base(const lf_visit *visit, int view, int column)
{
    const bool *mirrors = visit->worker->mirrors;
    return !mirrors || !mirrors[(size_t)view * (size_t)visit->rig->width + (size_t)column] ||
           base_counts(visit);
}

void lf_natives_of_surface(lf_visit *visit, int view, int column, const lf_pivot *pivot)
{
    lf_shading shading;
    lf_delta_chain chain;
    if (!visit->sums.native)
        return;
    if (lf_has(visit->scene, LF_TRAITS_SEEN_THROUGH))
        add_emission_of_alpha(visit, view, column, pivot);
    lf_shade(&pivot->event.hit, lf_scale(pivot->event.w, -1.0f), &shading);
    if (visit->plan->pilot && shading.n_deltas > 0)
        lf_counts_mark_delta(visit->plan->pilot, visit->row, view, column);
    chain_begin(visit, view, pivot, stands_apart(visit, pivot), &chain);
    for (int i = 0; i < shading.n_deltas; i++)
        lf_delta_chain_follow(&chain, &pivot->event, &shading.delta[i], 1.0f);
    if (shading.n_deltas > 0)
        chain_end(visit, view, column, pivot, &chain);
}
