#include "render/rows/prefix_factor.h"

#include "render/rows/extinction.h"

/* --------------------------------------------------------------------------- alpha and panes -- */

static bool scene_has_alphas(const lf_visit *visit)
{
    return lf_has(visit->scene, LF_TRAITS_SEEN_THROUGH);
}

static void alphas_between(const lf_visit *visit, const lf_pivot *pivot)
{
    lf_scratch *w = visit->worker;
    const lf_row_cut alphas = lf_visit_alphas(visit);
    const lf_hit *on = pivot->event.kind == LF_EVENT_SURFACE ? &pivot->event.hit : NULL;
    lf_alphas_before(&alphas, pivot->event.p, on, lf_rig_lanes(visit->rig), w->x0, w->scale);
}

/* Base rays end on alpha surfaces at random, so one view's own pixel needs no further factor. */
static const lf_prefix_factor alphas = {
    .applies = scene_has_alphas, .between = alphas_between, .along = lf_unscattered_alphas};

static bool has_thin_glass(const lf_visit *visit)
{
    return lf_has(visit->scene, LF_TRAIT_THIN_GLASS);
}

/* Thin glass is met with the probability of the light that it does not transmit, for each view. */
static void thin_glass_at(const lf_visit *visit, const lf_pivot *pivot)
{
    lf_scratch *w = visit->worker;
    if (!pivot->is_thin)
        return;
    lf_fan_look_back(visit, &pivot->event.hit);
    for (int k = 0; k < visit->rig->n_views; k++)
        w->scale[k] *= 1.0f - lf_thin_passes(pivot->event.hit.material, w->local[2][k]);
}

/* Along rays and in front of pivots it acts like an alpha surface. */
static const lf_prefix_factor thin_glass = {.applies = has_thin_glass, .at = thin_glass_at};

/* ------------------------------------------------------------------------------- corrections -- */

static bool has_slices(const lf_visit *visit)
{
    return lf_correction_needed(&visit->worker->media) &&
           !lf_has_fault(visit, LF_FAULT_NO_CORRECTION);
}

/* The truth over the slice, at the pivot. */
static bool correct_density(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                            const float *sampled, float *factor)
{
    lf_scratch *w = visit->worker;
    const float truth =
        lf_correction_density(&w->media, pivot->medium, visit->scene, pivot->event.p, &w->tracer);
    float share[LF_MAX_LANES];
    int drawn = 0;
    for (int k = 0; k < rays->n; k++) {
        share[k] = sampled[k] > 0.0f ? truth / sampled[k] : 1.0f;
        drawn |= sampled[k] > 0.0f;
    }
    for (int c = 0; c < visit->extinction->channels; c++)
        for (int k = 0; k < rays->n; k++)
            factor[c * rays->n + k] *= share[k];
    return !drawn || truth > 0.0f;
}

static bool correct(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                    const float *sampled, float *factor)
{
    lf_scratch *w = visit->worker;
    if (pivot->event.kind == LF_EVENT_MEDIUM &&
        w->media.item[pivot->medium].kind == LF_MEDIUM_SLICE &&
        !correct_density(visit, pivot, rays, sampled, factor))
        return false;
    lf_correction_transmittance(&w->media, rays, LF_CORRECTION_PIVOT, 0.0f, &w->tracer, factor);
    return true;
}

/* In thin media 1 - T matters, so at least every other fan gets a point. A coarse visit uses the
 * slices without correction. */
static void correct_along(const lf_unscattered *e, const lf_unscattered_rays *fan)
{
    lf_scratch *w = e->visit->worker;
    if (!e->visit->plan->order.coarse)
        lf_correction_transmittance(&w->media, &fan->rays, e->density, 0.5f, &w->tracer,
                                    fan->rays.channels ? w->channels.factor
                                                       : w->factor + fan->from);
}

static const lf_prefix_factor corrections = {
    .applies = has_slices, .received = correct, .along = correct_along};

/* ---------------------------------------------------------------------------------- the list -- */

static const lf_prefix_factor *const factors[LF_PREFIX_FACTORS] = {&corrections, &alphas,
                                                                   &thin_glass};

void lf_prefix_find(lf_visit *visit)
{
    lf_prefix_list *prefix = &visit->prefix;
    *prefix = (lf_prefix_list){0};
    for (int i = 0; i < LF_PREFIX_FACTORS; i++) {
        if (!factors[i]->applies(visit))
            continue;
        prefix->factor[prefix->n++] = factors[i];
        prefix->received |= !!factors[i]->received;
        prefix->along |= !!factors[i]->along;
    }
}

bool lf_prefix_received(const lf_visit *visit, const lf_pivot *pivot, const lf_rays *rays,
                        const float *sampled, float *factor)
{
    const lf_prefix_list *prefix = &visit->prefix;
    bool there = true;
    for (int i = 0; i < visit->extinction->channels * rays->n; i++)
        factor[i] = 1.0f;
    for (int i = 0; i < prefix->n && there; i++)
        if (prefix->factor[i]->received)
            there = prefix->factor[i]->received(visit, pivot, rays, sampled, factor);
    return there;
}

/* ---------------------------------------------------------------------------- one view's own -- */

void lf_own_ray_init(lf_own_ray *out, const lf_visit *visit, int view, const lf_pivot *pivot)
{
    const float x0 = visit->rig->b[view] + pivot->lx, slope = (pivot->x - x0) / pivot->z;
    for (int i = 0; i < LF_LANES; i++) {
        out->x0[i] = x0;
        out->slope[i] = slope;
        out->z_end[i] = pivot->z;
    }
    out->rays = (lf_rays){.scene = visit->scene,
                          .rig = visit->rig,
                          .plane = &visit->plane,
                          .kernels = visit->kernels,
                          .n = LF_LANES,
                          .x0 = out->x0,
                          .slope = out->slope,
                          .z_end = out->z_end,
                          .channels = visit->extinction->channels > 1};
}

float lf_prefix_own(const lf_visit *visit, int view, const lf_pivot *pivot, lf_vec3 *out_channels)
{
    const lf_media *media = &visit->worker->media;
    lf_own_ray ray;
    float sampled[LF_LANES] = {0.0f}, factor[3 * LF_LANES];
    *out_channels = lf_v3(1.0f, 1.0f, 1.0f);
    if (!visit->prefix.received && visit->extinction->channels == 1)
        return 1.0f;
    lf_own_ray_init(&ray, visit, view, pivot);
    if (pivot->event.kind == LF_EVENT_MEDIUM && media->item[pivot->medium].kind == LF_MEDIUM_SLICE)
        sampled[0] =
            lf_slice_density(&media->item[pivot->medium].slice, ray.x0[0], ray.slope[0], pivot->z);
    for (int i = 1; i < LF_LANES; i++)
        sampled[i] = sampled[0];
    if (!lf_prefix_received(visit, pivot, &ray.rays, sampled, factor))
        return 0.0f;
    return visit->extinction->own(visit, pivot, &ray.rays, factor, out_channels);
}
