/* vpt: each view separately, the baseline. It uses the same base samples, suffixes, samplers and
 * known light as mvpt. Nothing is shared, so the only weight is one over the expected count of the
 * base pixel. */
#include "render/rows/extinction.h"
#include "render/rows/fan_steps.h"
#include "render/rows/light_paths.h"
#include "render/rows/native.h"
#include "render/rows/prefix_factor.h"

/* Pixels of a view per unit area at a pivot, times the pdf of its lobe. Transmittance of alpha
 * surfaces is left out, here and for light paths (light_connect.c). */
static float over_vpt(lf_visit *visit, int view, int column, const lf_pivot *pivot, lf_vec3 wi)
{
    const lf_rig *rig = visit->rig;
    lf_vec3 f;
    (void)column;
    const lf_vec3 d =
        lf_sub(lf_rig_point(rig, rig->b[view], visit->plane.ly, 0.0f), pivot->event.p);
    const float pdf =
        lf_scatter_eval(visit->scene, &pivot->event, lf_scale(pivot->event.w, -1.0f), wi, &f);
    return lf_fan_unit(visit, pivot) * fabsf(lf_dot(pivot->event.hit.ng, d)) * pdf *
           (float)lf_visit_splitting(visit, &pivot->event).suffixes;
}

/* Draws one of the pivot's suffixes, in balance with light paths. */
static void draw(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                 const lf_splitting *of, int i, lf_suffix *suffix)
{
    lf_tracer *tracer = &visit->worker->tracer;
    lf_light_balance balance;
    lf_suffix_draw_of(tracer, &pivot->event, lf_scale(pivot->event.w, -1.0f), pivot->sampler, of, i,
                      suffix);
    if (!suffix->is_pending)
        return;
    const bool shared =
        visit->plan->light &&
        lf_light_balance_of(visit, pivot, suffix->wi,
                            visit->sharing->over(visit, view, column, pivot, suffix->wi), &balance);
    lf_suffix_follow_in_balance(tracer, &pivot->event, visit->max_depth, shared ? &balance : NULL,
                                suffix);
}

/* Radiance towards the view: the mean of the pivot's suffixes. */
static lf_vec3 sent(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                    const lf_suffix *given)
{
    const lf_splitting of =
        pivot->is_thin ? LF_SPLITTING_NONE : lf_visit_splitting(visit, &pivot->event);
    const lf_vec3 wo = lf_scale(pivot->event.w, -1.0f);
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < of.suffixes; i++) {
        lf_suffix suffix = {0};
        if (given)
            suffix = *given;
        else if (!pivot->is_thin)
            draw(visit, view, column, pivot, &of, i, &suffix);
        if (visit->worker->equiangular.n > 0 && pivot->event.kind == LF_EVENT_MEDIUM)
            visit->sharing->balance(visit, view, column, pivot, &suffix);
        sum = lf_add(sum, lf_suffix_radiance_of(visit->scene, &pivot->event, wo, &of, &suffix));
    }
    return lf_visit_mean(visit, sum, of.suffixes);
}

static void pivot_vpt(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                      const lf_suffix *given)
{
    lf_vec3 channels;
    float correction = lf_prefix_own(visit, view, pivot, &channels);
    if (correction == 0.0f)
        return; /* the pivot sends nothing */
    lf_vec3 radiance = sent(visit, view, column, pivot, given);
    size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    visit->worker->contributions++;
    if (!isfinite(radiance.x + radiance.y + radiance.z)) {
        visit->worker->tracer.nonfinite++;
        radiance = lf_v3(0.0f, 0.0f, 0.0f);
    }
    float weight = pivot->forced_weight * visit->alone * correction;
    radiance = lf_mul(radiance, channels);
    lf_film_scatter(&visit->sums, pixel, weight * radiance.x, weight * radiance.y,
                    weight * radiance.z);
    weight *= lf_mean3(channels);
    lf_film_weigh(&visit->sums, pixel, weight);
    if (visit->sums.half.w2)
        lf_film_weigh_direction(&visit->sums, pixel, weight);
}

/* h sigma and the optical depth of a pivot in a medium, as this view samples it. */
static float density(const lf_visit *visit, int view, const lf_pivot *pivot, float *out_depth)
{
    lf_own_ray ray;
    lf_own_ray_init(&ray, visit, view, pivot);
    return visit->extinction->own_density(visit, pivot, &ray.rays, out_depth) * pivot->z *
           lf_rays_length(&ray.rays, 0);
}

static void balance_vpt(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                        lf_suffix *suffix)
{
    (void)column;
    float depth, sum = density(visit, view, pivot, &depth);
    lf_equiangular_balance(visit, pivot, view, sum, depth, suffix);
}

/* A point around a light serves one view, like every sample here. */
static void equiangular_vpt(lf_visit *visit, int view, const lf_pivot *pivot,
                            const lf_light_sample *light)
{
    const lf_rig *rig = visit->rig;
    lf_scratch *w = visit->worker;
    float x0 = rig->b[view] + pivot->lx, slope = (pivot->x - x0) / pivot->z, depth;
    float u = (rig->skew[view] + pivot->lx * rig->distance / rig->focus + rig->distance * slope -
               rig->x0) /
              rig->dx;
    if (!(u >= 0.0f && u < (float)rig->width))
        return;
    float sum = density(visit, view, pivot, &depth);
    lf_vec3 eye = lf_rig_point(rig, x0, visit->plane.ly, 0.0f), d = lf_sub(pivot->event.p, eye);
    float passed = sum > 0.0f ? lf_trace_passed_seen(&w->tracer, eye, d, 1.0f) : 0.0f;
    if (!(passed > 0.0f))
        return;
    lf_vec3 f;
    float phase = lf_scatter_eval(visit->scene, &pivot->event, lf_normalize(lf_scale(d, -1.0f)),
                                  light->wi, &f);
    float pdf =
        light->pdf * (1.0f + lf_equiangular_ratio(visit, pivot, light->light, view, sum, depth)) +
        (light->delta ? 0.0f : phase);
    lf_light_sample arriving = *light;
    lf_vec3 channels;
    float visible = lf_path_visible(&w->tracer, &pivot->event, &arriving) *
                    lf_prefix_own(visit, view, pivot, &channels);
    visible *= passed;
    lf_visit_add_native(visit, (size_t)view * (size_t)rig->width + (size_t)(int)u,
                        lf_scale(lf_mul(lf_mul(f, arriving.radiance), channels), visible / pdf));
}

const lf_sharing lf_sharing_vpt = {.entry = {.name = "vpt",
                                             .what = "each view alone",
                                             .takes_light_paths = true,
                                             .splits = true,
                                             .supports = LF_ROWS_SUPPORT},
                                   .suffixes = 2,
                                   .pivot = pivot_vpt,
                                   .equiangular = equiangular_vpt,
                                   .balance = balance_vpt,
                                   .over = over_vpt};
