#include "render/transport/path/path.h"

#include "render/scene/fault.h"
#include "render/transport/light/equiangular.h"
#include "render/transport/path/interior.h"
#include "render/transport/path/subsurface.h"
#include "render/transport/surface/surface_texture.h"

/* Whether the path came here through subsurface, where no light sample was drawn. */
static bool is_in_subsurface(const lf_scene *scene, const lf_event *event)
{
    return lf_has(scene, LF_TRAIT_SUBSURFACE) && event->subsurface.of;
}

/* lf_path_next of a path that carries beta. */
static void next_event(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_vec3 beta,
                       lf_event *out)
{
    if (lf_has(tracer->scene, LF_TRAIT_SUBSURFACE)) {
        out->subsurface = lf_subsurface_beyond(from, w);
        if (out->subsurface.of) {
            lf_subsurface_walk(tracer, from, w, beta, out);
            if (lf_has(tracer->scene, LF_TRAIT_NESTED_GLASS))
                lf_nest_after_subsurface(tracer->scene, from, w, out);
            return;
        }
    }
    lf_vec3 o = from->kind == LF_EVENT_SURFACE
                    ? lf_offset(tracer->scene, from->p, from->hit.ng, w, 0.0f)
                    : from->p;
    float t_max = INFINITY;
    tracer->width = from->kind == LF_EVENT_SURFACE && from->hit.varies ? from->hit.width : 0.0f;
    out->kind = LF_EVENT_ESCAPE;
    out->w = w;
    if (lf_has(tracer->scene, LF_TRAIT_NESTED_GLASS)
            ? lf_nest_trace(tracer, from, o, w, t_max, &out->nest, &out->hit)
            : lf_trace_surface(tracer, o, w, t_max, &out->hit)) {
        out->kind = LF_EVENT_SURFACE;
        out->p = out->hit.p;
        t_max = out->hit.t;
    }
    out->from = o;
    out->surface = t_max;
    float way = t_max;
    if (lf_has(tracer->scene, LF_TRAITS_FILLED))
        way = lf_min(lf_interior_segment(tracer, from, w, beta, out), t_max);
    out->t = lf_has(tracer->scene, LF_TRAIT_CHROMATIC_MEDIA)
                 ? lf_track_channels(tracer, o, w, way, beta, &out->volume, &out->channels)
                 : lf_track_collision(tracer, o, w, way, &out->volume);
    if (way < t_max && out->t >= way) {
        out->volume = LF_INTERIOR;
        out->t = way;
    }
    if (out->t < t_max) {
        out->kind = LF_EVENT_MEDIUM;
        out->p = lf_madd(o, out->t, w);
    }
    if (lf_has(tracer->scene, LF_TRAITS_FILLED))
        lf_interior_weigh(beta, out);
}

void lf_path_next(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_event *out)
{
    next_event(tracer, from, w, lf_v3(1.0f, 1.0f, 1.0f), out);
}

static lf_vec3 channels_of(const lf_scene *scene, const lf_event *event)
{
    return lf_has(scene, LF_TRAIT_CHROMATIC_MEDIA) ? event->channels : lf_v3(1.0f, 1.0f, 1.0f);
}

lf_vec3 lf_path_absorbed(const lf_scene *scene, const lf_event *event)
{
    return lf_has(scene, LF_TRAITS_FILLED) ? event->left : lf_v3(1.0f, 1.0f, 1.0f);
}

lf_vec3 lf_path_absorbed_light(const lf_scene *scene, const lf_event *event,
                               const lf_light_sample *light)
{
    const lf_material *in = lf_has(scene, LF_TRAITS_FILLED) && light->distance < INFINITY
                                ? lf_interior_beyond(scene, event, light->wi)
                                : NULL;
    return in ? lf_interior_left(in, light->distance) : lf_v3(1.0f, 1.0f, 1.0f);
}

/* For the medium of a collision. */
static float phase_of(const lf_scene *scene, const lf_event *event, lf_vec3 w, lf_vec3 wi)
{
    return event->volume == LF_INTERIOR ? lf_phase_between(event->interior->g, w, wi)
                                        : lf_volume_phase(&scene->volumes[event->volume], w, wi);
}

/* Light scattered inside of glass is already weighted in lf_event.left. */
static lf_vec3 albedo_of(const lf_scene *scene, const lf_event *event)
{
    return event->volume == LF_INTERIOR
               ? lf_v3(1.0f, 1.0f, 1.0f)
               : lf_volume_albedo(&scene->volumes[event->volume], event->p);
}

bool lf_path_serves_others(const lf_event *event, lf_vec3 wi)
{
    const lf_hit *hit = &event->hit;
    return event->kind == LF_EVENT_SURFACE &&
           (hit->material->glass.is_rough || (hit->varies && hit->own.coat_normal.z > 0.0f)) &&
           !lf_hit_wrong_side(hit, wi);
}

float lf_hit_eval_folded(const lf_hit *hit, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    const lf_material *m = lf_hit_material(hit);
    const lf_vec3 way[2] = {wi, lf_hit_mirrored(hit, wi)};
    float pdf = 0.0f;
    *f = lf_v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < 2; i++) {
        lf_vec3 own;
        if (lf_hit_wrong_side(hit, way[i]) != (i == 1))
            continue;
        pdf += m->kind->eval(m, hit->ns, wo, way[i], &own);
        *f = lf_add(*f, own);
    }
    return pdf;
}

float lf_scatter_eval(const lf_scene *scene, const lf_event *event, lf_vec3 wo, lf_vec3 wi,
                      lf_vec3 *f)
{
    if (event->kind == LF_EVENT_SURFACE) {
        const lf_material *m = lf_hit_material(&event->hit);
        if (lf_hit_bent_normal(&event->hit))
            return lf_hit_eval_folded(&event->hit, wo, wi, f);
        float pdf = m->kind->eval(m, event->hit.ns, wo, wi, f);
        if (lf_hit_wrong_side(&event->hit, wi))
            *f = lf_v3(0.0f, 0.0f, 0.0f);
        return pdf;
    }
    float phase = phase_of(scene, event, lf_scale(wo, -1.0f), wi);
    *f = lf_scale(albedo_of(scene, event), phase);
    return phase;
}

float lf_scatter_sample(const lf_scene *scene, const lf_event *event, lf_vec3 wo, const float u[3],
                        lf_vec3 *wi, lf_vec3 *f)
{
    if (event->kind == LF_EVENT_SURFACE) {
        const lf_material *m = lf_hit_material(&event->hit);
        float pdf = m->kind->sample(m, event->hit.ns, wo, u, wi, f);
        if (pdf > 0.0f && lf_hit_bent_normal(&event->hit)) {
            if (lf_hit_wrong_side(&event->hit, *wi))
                *wi = lf_hit_mirrored(&event->hit, *wi);
            return lf_hit_eval_folded(&event->hit, wo, *wi, f);
        }
        if (lf_hit_wrong_side(&event->hit, *wi))
            *f = lf_v3(0.0f, 0.0f, 0.0f);
        return pdf;
    }
    lf_vec3 w = lf_scale(wo, -1.0f);
    *wi = event->volume == LF_INTERIOR
              ? lf_phase_sample(event->interior->g, w, u)
              : lf_volume_phase_sample(&scene->volumes[event->volume], w, u);
    float phase = phase_of(scene, event, w, *wi);
    *f = lf_scale(albedo_of(scene, event), phase);
    return phase;
}

/* Whether the drawn face is the first that a ray from o meets. If faces coincide, rays find one of
 * them, and so must light sampling. So the ray goes to the light itself, not to an offset point. A
 * face in front of the light that is nearer than the precision of rays hides it for both strategies
 * alike.
 *
 * A point within rounding of its triangle's edge may be met on the neighbour, and is lost. The loss
 * is a few times 1/n, for lights cut into triangles n times as wide as the rounding of coordinates
 * (a ball of radius 0.05, 1000 from the middle of the scene: 2.8 %).
 *
 * A ray ends on an alpha surface at random, so its chance replaces its share of the light. */
static float meets_area_light(lf_tracer *tracer, const lf_event *event, lf_vec3 o,
                              lf_light_sample *light)
{
    const lf_vec3 d = lf_sub(light->point, o);
    lf_hit hit;
    lf_nest nest;
    const bool met = lf_has(tracer->scene, LF_TRAIT_NESTED_GLASS)
                         ? lf_nest_trace(tracer, event, o, d, INFINITY, &nest, &hit)
                         : lf_trace_surface(tracer, o, d, INFINITY, &hit);
    if (!met || hit.mesh != light->mesh || hit.triangle != light->triangle)
        return 0.0f;
    const float share = lf_hit_cover(&hit, tracer->width + tracer->spread * hit.t);
    light->radiance = lf_scale(light->radiance, 1.0f / share);
    return 1.0f;
}

/* Transmittance from there to the event; ignored glass faces do not occlude. */
static float passed_from(lf_tracer *tracer, const lf_event *event, lf_vec3 o, lf_vec3 d,
                         float t_max)
{
    lf_hit hit;
    lf_nest nest;
    if (!lf_has(tracer->scene, LF_TRAIT_NESTED_GLASS))
        return lf_trace_passed(tracer, o, d, t_max);
    return lf_nest_trace(tracer, event, o, d, t_max, &nest, &hit) ? 0.0f : 1.0f;
}

float lf_path_visible(lf_tracer *tracer, const lf_event *event, lf_light_sample *light)
{
    lf_vec3 o = event->p, d = light->wi;
    float t_max = INFINITY;
    if (event->kind == LF_EVENT_SURFACE) {
        if (lf_hit_wrong_side(&event->hit, light->wi) &&
            !(lf_hit_bent_normal(&event->hit) && lf_has_far_lobe(event->hit.material)))
            return 0.0f;
        if (lf_has(tracer->scene, LF_TRAIT_SUBSURFACE) && lf_subsurface_beyond(event, light->wi).of)
            return 0.0f;
        o = lf_offset(tracer->scene, event->p, event->hit.ng, light->wi, 0.0f);
    }
    if (light->distance < INFINITY) {
        /* Both ends must be offset together: otherwise the ray would pass the light and meet a
         * surface behind it. */
        d = lf_sub(lf_offset(tracer->scene, light->point, light->normal, lf_scale(light->wi, -1.0f),
                             light->distance),
                   o);
        t_max = 1.0f - 1e-6f;
    }
    float passed = lf_has(tracer->scene, LF_TRAIT_OVERLAPS) && light->mesh
                       ? meets_area_light(tracer, event, o, light)
                       : passed_from(tracer, event, o, d, t_max);
    if (!(passed > 0.0f))
        return 0.0f;
    if (!lf_has(tracer->scene, LF_TRAIT_CHROMATIC_MEDIA))
        return passed * lf_track_transmittance(tracer, event->p, light->wi, light->distance);
    light->radiance = lf_mul(light->radiance,
                             lf_track_transmittances(tracer, event->p, light->wi, light->distance));
    return passed;
}

float lf_path_lit(lf_tracer *tracer, const lf_event *event, lf_light_sample *light)
{
    const float passed = lf_path_visible(tracer, event, light);
    if (lf_has(tracer->scene, LF_TRAITS_FILLED))
        light->radiance =
            lf_mul(light->radiance, lf_path_absorbed_light(tracer->scene, event, light));
    return passed;
}

lf_vec3 lf_path_light_found(const lf_scene *scene, const lf_event *from, const lf_event *event,
                            float *out_light_pdf)
{
    *out_light_pdf = 0.0f;
    lf_vec3 found = lf_v3(0.0f, 0.0f, 0.0f);
    if (event->kind == LF_EVENT_ESCAPE)
        found = lf_light_escape(scene, event->w, out_light_pdf);
    else if (event->kind == LF_EVENT_SURFACE && lf_has(scene, LF_TRAIT_EMISSION))
        found = lf_light_hit(scene, from->p, &event->hit, out_light_pdf);
    if (is_in_subsurface(scene, event)) {
        *out_light_pdf = 0.0f;
        if (event->kind == LF_EVENT_SURFACE &&
            event->hit.material ==
                event->subsurface.of) /* emission of its own face leaves outwards */
            return lf_v3(0.0f, 0.0f, 0.0f);
    }
    return lf_has(scene, LF_TRAIT_CHROMATIC_MEDIA) ? lf_mul(found, event->channels) : found;
}

static float extinction(const lf_scene *scene, lf_vec3 p)
{
    float sigma = 0.0f;
    for (int i = 0; i < scene->n_volumes; i++)
        sigma += lf_volume_sigma_t(&scene->volumes[i], p);
    return sigma;
}

static const lf_equiangular_light *pick_equiangular(const lf_scene *scene, float u)
{
    int i = 0;
    for (; i < scene->equiangular.n - 1 && u >= scene->equiangular.item[i].share; i++)
        u -= scene->equiangular.item[i].share;
    return &scene->equiangular.item[i];
}

/* Albedo times phase function times extinction of all volumes at p, each over the pdf with which
 * this light is found from there. */
static lf_vec3 scattered_by_volumes(const lf_scene *scene, lf_vec3 p, lf_vec3 w,
                                    const lf_light_sample *light)
{
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *v = &scene->volumes[i];
        float phase = lf_volume_phase(v, w, light->wi);
        sum = lf_madd(
            sum, lf_volume_sigma_t(v, p) * phase / (light->delta ? light->pdf : light->pdf + phase),
            lf_mul(lf_volume_albedo(v, p), lf_volume_colour(v)));
    }
    return sum;
}

lf_vec3 lf_path_equiangular(lf_tracer *tracer, const lf_event *next)
{
    const lf_vec3 nothing = lf_v3(0.0f, 0.0f, 0.0f);
    const lf_scene *scene = tracer->scene;
    if (scene->equiangular.n == 0 || (lf_has(scene, LF_TRAITS_FILLED) && next->interior) ||
        is_in_subsurface(scene, next))
        return nothing; /* interior media are not looked up there */
    const lf_equiangular_light *equiangular = pick_equiangular(scene, lf_rng(tracer));
    lf_equiangular_segment segment;
    if (!lf_equiangular_segment_init(&segment, scene, equiangular, next->from, next->w) ||
        lf_rng(tracer) >= segment.count)
        return nothing;
    lf_event event = {.kind = LF_EVENT_MEDIUM};
    float t = lf_equiangular_segment_draw(&segment, lf_rng(tracer)), pdf;
    const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
    event.p = lf_madd(next->from, t, next->w);
    if (lf_has(scene, LF_TRAIT_NESTED_GLASS))
        event.nest = next->nest;
    float sigma = t < next->surface ? extinction(scene, event.p) : 0.0f;
    const lf_light *from = &scene->lights[equiangular->light];
    lf_light_sample light;
    if (!(sigma > 0.0f) || !lf_light_draw_from(scene, from, event.p, u, &light))
        return nothing;
    float weight =
        lf_equiangular_segment_weight(&segment, t, sigma, equiangular->share, from->select, &pdf);
    weight *= from->select / (segment.count * equiangular->share * pdf) *
              lf_path_visible(tracer, &event, &light);
    if (!(weight > 0.0f))
        return nothing;
    lf_vec3 scattered =
        lf_mul(scattered_by_volumes(scene, event.p, next->w, &light), light.radiance);
    if (lf_has(scene, LF_TRAIT_CHROMATIC_MEDIA))
        scattered = lf_mul(scattered, lf_track_transmittances(tracer, next->from, next->w, t));
    else
        weight *= lf_track_transmittance(tracer, next->from, next->w, t);
    return lf_scale(scattered, weight);
}

/* The weight that remains for the collision at `event` in the light sampling of an equiangular
 * light. */
static float near_equiangular(const lf_scene *scene, const lf_event *event, const lf_light *light)
{
    lf_equiangular_segment segment;
    if (event->kind != LF_EVENT_MEDIUM || light->equiangular == 0 ||
        (lf_has(scene, LF_TRAITS_FILLED) && event->interior))
        return 1.0f;
    const lf_equiangular_light *equiangular = &scene->equiangular.item[light->equiangular - 1];
    if (!lf_equiangular_segment_init(&segment, scene, equiangular, event->from, event->w))
        return 1.0f;
    float sigma = extinction(scene, event->p);
    return sigma > 0.0f
               ? 1.0f - lf_equiangular_segment_weight(&segment, event->t, sigma, equiangular->share,
                                                      light->select, NULL)
               : 1.0f;
}

/* ----------------------------------------------------------------------------------- balance -- */

float lf_path_reverse_pdf(const lf_scene *scene, const lf_event *event, lf_vec3 wo, lf_vec3 wi)
{
    lf_vec3 f;
    if (event->kind != LF_EVENT_SURFACE || !(lf_dot(event->hit.ng, wi) > 0.0f) ||
        !(lf_dot(event->hit.ng, wo) > 0.0f))
        return 0.0f;
    return lf_scatter_eval(scene, event, wi, wo, &f);
}

bool lf_path_reverse_delta(const lf_event *event, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f)
{
    const float least = 1.0f - 1e-4f; /* cosine between directions that count as the same */
    const lf_hit *hit = &event->hit;
    const lf_material *m = lf_hit_material(hit);
    const bool through = lf_dot(hit->ng, wi) < 0.0f;
    const float side = through ? -1.0f : 1.0f;
    lf_delta delta[LF_MAX_DELTAS];
    const int n = m->kind->deltas(m, lf_scale(hit->ng, side), lf_scale(hit->ns, side), wi,
                                  hit->front != through, delta);
    for (int i = 0; i < n; i++)
        if (lf_dot(delta[i].wi, wo) > least) {
            *f = delta[i].f;
            return true;
        }
    return false;
}

/* p_light / p_suffix of a camera path that has come to `here`, without what follows from there;
 * 0: light paths do not come here. */
static float reached(const lf_reverse *reverse, const lf_event *here)
{
    if (here->kind != LF_EVENT_SURFACE)
        return 0.0f;
    return reverse->rate * reverse->cosine / lf_max(fabsf(lf_dot(here->hit.ng, here->w)), 1e-9f);
}

/* Continues from `here` along wi. rate: reached there, times the pdfs of scattering by light paths
 * over that by this one. */
static void continue_reverse(lf_reverse *reverse, const lf_event *here, lf_vec3 wi, float rate,
                             bool delta)
{
    const float cosine = here->kind == LF_EVENT_SURFACE ? lf_dot(here->hit.ng, wi) : 0.0f;
    if (delta && cosine < 0.0f && here->hit.material->is_solid)
        reverse->is_inside = !reverse->is_inside;
    reverse->rate = rate;
    reverse->cosine = fabsf(cosine);
}

/* A light sample's radiance times its balance weight. */
static lf_vec3 weigh_sample(const lf_light_balance *balance, const lf_event *event, lf_vec3 wo,
                            const lf_light_sample *light, float pdf, float rate)
{
    const bool sums = light->distance == INFINITY && !light->delta;
    const float reverse = lf_path_reverse_pdf(balance->emitters->scene, event, wo, light->wi),
                drawn = light->delta ? light->pdf : light->pdf + pdf;
    if (!(rate * reverse > 0.0f))
        return light->radiance;
    const lf_light_end end = {light->wi, light->distance, light->triangle};
    return lf_emitters_weigh(balance->emitters, sums ? NULL : light->light, light->radiance,
                             balance->scale * rate * reverse / drawn, event->p, event->hit.ng,
                             &end);
}

/* The same for light that a direction has found; rate: p_light / p_suffix, without the light. */
static lf_vec3 weigh_found(const lf_light_balance *balance, const lf_event *from,
                           const lf_event *next, lf_vec3 found, float rate)
{
    if (!(rate > 0.0f) || !(lf_max3(found) > 0.0f))
        return found;
    const lf_light *light = next->kind == LF_EVENT_SURFACE
                                ? lf_light_of_hit(balance->emitters->scene, &next->hit)
                                : NULL;
    const lf_light_end end = {next->w, INFINITY, light ? next->hit.triangle : 0};
    return lf_emitters_weigh(balance->emitters, light, found, balance->scale * rate, from->p,
                             from->hit.ng, &end);
}

/* ---------------------------------------------------------------------------------- the walk -- */

/* Next-event estimation with the balance heuristic against direction sampling. rate: see reached.
 */
static inline __attribute__((always_inline)) lf_vec3 direct(lf_tracer *tracer,
                                                            const lf_event *event, lf_vec3 wo,
                                                            const lf_light_balance *balance,
                                                            float rate)
{
    const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
    lf_light_sample light;
    lf_vec3 f;
    if (!lf_light_draw(tracer->scene, event->p, u, &light))
        return lf_v3(0.0f, 0.0f, 0.0f);
    float pdf = lf_scatter_eval(tracer->scene, event, wo, light.wi, &f);
    if (!(lf_max3(f) > 0.0f))
        return lf_v3(0.0f, 0.0f, 0.0f);
    float weight = lf_path_lit(tracer, event, &light) / (light.delta ? light.pdf : light.pdf + pdf);
    weight *= near_equiangular(tracer->scene, event, light.light);
    if (balance && rate > 0.0f && weight > 0.0f)
        light.radiance = weigh_sample(balance, event, wo, &light, pdf, rate);
    return lf_scale(lf_mul(f, light.radiance), weight);
}

/* Volume emission along the segment that ends at `next`, for a path with throughput beta,
 * attenuated by glass. No light sample finds it: only directions do, with weight 1. */
static lf_vec3 emitted(lf_tracer *tracer, const lf_event *next, lf_vec3 beta)
{
    if (is_in_subsurface(tracer->scene, next))
        return lf_v3(0.0f, 0.0f, 0.0f);
    const float t = lf_min(next->t, next->surface);
    lf_dimming dimming;
    const bool is_dimmed = lf_has(tracer->scene, LF_TRAITS_FILLED) && next->interior;
    if (is_dimmed)
        dimming = lf_interior_dimming(next->interior, beta);
    return lf_mul(channels_of(tracer->scene, next),
                  lf_track_emission(tracer, next->from, next->w, t, is_dimmed ? &dimming : NULL));
}

bool lf_path_follows_delta(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_vec3 *wi,
                           lf_vec3 *beta)
{
    lf_shading shading;
    lf_shade(&event->hit, wo, &shading);
    if (shading.n_deltas == 0)
        return false;
    float mean[LF_MAX_DELTAS] = {0.0f}, sum = 0.0f;
    for (int i = 0; i < shading.n_deltas; i++)
        sum += mean[i] = lf_mean3(shading.delta[i].f);
    float any = shading.has_lobe ? lf_min(sum, 0.95f) : 1.0f, u = lf_rng(tracer);
    if (u >= any) {
        *beta = lf_scale(*beta, 1.0f / (1.0f - any));
        return false;
    }
    int chosen = shading.n_deltas > 1 && u * sum >= any * mean[0];
    *beta = lf_scale(lf_mul(*beta, shading.delta[chosen].f), 1.0f / (any * (mean[chosen] / sum)));
    *wi = shading.delta[chosen].wi;
    return true;
}

/* lf_path_scattered; balance NULL: alone. */
static inline __attribute__((always_inline)) lf_vec3 scattered(lf_tracer *tracer,
                                                               const lf_event *event, int depth,
                                                               int max_depth,
                                                               const lf_light_balance *balance)
{
    lf_vec3 radiance = lf_v3(0.0f, 0.0f, 0.0f), beta = channels_of(tracer->scene, event);
    lf_event events[2];
    const lf_event *here = event;
    lf_reverse reverse = {.rate = 1.0f, .cosine = balance ? balance->cosine : 0.0f};
    for (; depth <= max_depth; depth++) {
        lf_vec3 wo = lf_scale(here->w, -1.0f), wi, f, fire;
        float pdf = 0.0f, rate = balance ? reached(&reverse, here) : 0.0f;
        bool delta =
            here->kind == LF_EVENT_SURFACE && lf_path_follows_delta(tracer, here, wo, &wi, &beta);
        if (!delta) {
            const float lit = balance && !reverse.is_inside ? rate : 0.0f;
            radiance = lf_add(radiance, lf_mul(beta, direct(tracer, here, wo, balance, lit)));
            const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
            pdf = lf_scatter_sample(tracer->scene, here, wo, u, &wi, &f);
            if (!(pdf > 0.0f))
                break;
            beta = lf_scale(lf_mul(beta, f), 1.0f / pdf);
            tracer->spread = LF_SUFFIX_SPREAD;
            if (balance && rate > 0.0f && !lf_has_fault(balance, LF_FAULT_NO_REVERSE_PDF))
                rate *= lf_path_reverse_pdf(tracer->scene, here, wo, wi);
        } else if (balance && !lf_path_reverse_delta(here, wo, wi, &f)) {
            rate = 0.0f;
        }
        if (!(lf_max3(beta) > 0.0f) || !lf_path_survives(tracer, &beta))
            break;
        lf_event *next = here == &events[0] ? &events[1] : &events[0];
        next_event(tracer, here, wi, beta, next);
        if (tracer->scene->emissive.n > 0)
            fire = lf_mul(beta, emitted(tracer, next, beta));
        if (lf_has(tracer->scene, LF_TRAITS_FILLED))
            beta = lf_mul(beta, lf_path_absorbed(tracer->scene, next));
        float light_pdf;
        lf_vec3 found = lf_path_light_found(tracer->scene, here, next, &light_pdf);
        float weight = delta || light_pdf <= 0.0f ? 1.0f : pdf / (pdf + light_pdf);
        if (balance) {
            continue_reverse(&reverse, here, wi, delta ? rate : rate / pdf, delta);
            if (!reverse.is_inside)
                found = weigh_found(balance, here, next, found,
                                    delta ? rate : rate / (pdf + light_pdf));
        }
        radiance = lf_add(radiance, lf_scale(lf_mul(beta, found), weight));
        if (tracer->scene->emissive.n > 0)
            radiance = lf_add(radiance, fire);
        if (depth < max_depth && tracer->scene->equiangular.n > 0)
            radiance = lf_add(radiance, lf_mul(beta, lf_path_equiangular(tracer, next)));
        if (next->kind == LF_EVENT_ESCAPE)
            break;
        if (lf_has(tracer->scene, LF_TRAIT_CHROMATIC_MEDIA))
            beta = lf_mul(beta, next->channels);
        here = next;
    }
    if (depth > max_depth)
        tracer->suffixes_cut += (double)lf_max3(beta);
    return radiance;
}

lf_vec3 lf_path_scattered(lf_tracer *tracer, const lf_event *event, int depth, int max_depth)
{
    return scattered(tracer, event, depth, max_depth, NULL);
}

lf_vec3 lf_path_scattered_in_balance(lf_tracer *tracer, const lf_event *event, int depth,
                                     int max_depth, const lf_light_balance *balance)
{
    return scattered(tracer, event, depth, max_depth, balance);
}

lf_vec3 lf_path_along(lf_tracer *tracer, const lf_event *next, bool scatters)
{
    lf_vec3 radiance = scatters ? lf_path_equiangular(tracer, next) : lf_v3(0.0f, 0.0f, 0.0f);
    if (tracer->scene->emissive.n > 0)
        radiance = lf_add(radiance, emitted(tracer, next, lf_v3(1.0f, 1.0f, 1.0f)));
    return radiance;
}

lf_vec3 lf_path_arriving(lf_tracer *tracer, const lf_event *next, int depth, int max_depth)
{
    const lf_vec3 radiance = lf_path_along(tracer, next, depth <= max_depth);
    tracer->suffixes++;
    if (next->kind == LF_EVENT_ESCAPE)
        return radiance;
    const lf_vec3 left = lf_path_absorbed(tracer->scene, next);
    const double cut = tracer->suffixes_cut;
    lf_vec3 scattered = lf_path_scattered(tracer, next, depth, max_depth);
    tracer->suffixes_cut = cut + (tracer->suffixes_cut - cut) * (double)lf_max3(left);
    return lf_add(radiance, lf_mul(scattered, left));
}

lf_vec3 lf_path_arriving_in_balance(lf_tracer *tracer, const lf_event *next, int depth,
                                    int max_depth, const lf_light_balance *balance)
{
    const lf_vec3 radiance = lf_path_along(tracer, next, depth <= max_depth);
    tracer->suffixes++;
    if (next->kind == LF_EVENT_ESCAPE)
        return radiance;
    const lf_vec3 left = lf_path_absorbed(tracer->scene, next);
    const double cut = tracer->suffixes_cut;
    lf_vec3 scattered = lf_path_scattered_in_balance(tracer, next, depth, max_depth, balance);
    tracer->suffixes_cut = cut + (tracer->suffixes_cut - cut) * (double)lf_max3(left);
    return lf_add(radiance, lf_mul(scattered, left));
}
