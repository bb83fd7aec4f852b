#include "render/transport/path/suffix_one.h"

void lf_suffix_draw_light(lf_tracer *tracer, const lf_event *event, lf_sampler *sampler,
                          lf_suffix *suffix)
{
    float u[3];
    u[0] = lf_sampler_1d(sampler);
    lf_sampler_2d(sampler, u + 1);
    suffix->has_light = lf_light_draw(tracer->scene, event->p, u, &suffix->light);
    if (suffix->has_light)
        suffix->light_visible = lf_path_lit(tracer, event, &suffix->light);
}

static void meet(lf_tracer *tracer, const lf_event *event, const lf_event *next, int max_depth,
                 const lf_light_balance *balance, lf_suffix *suffix)
{
    const lf_scene *scene = tracer->scene;
    suffix->is_pending = false;
    suffix->found = lf_path_light_found(scene, event, next, &suffix->found_pdf);
    if (scene->equiangular.n > 0 && suffix->found_pdf > 0.0f && next->kind == LF_EVENT_SURFACE)
        suffix->found_light = lf_light_of_hit(scene, &next->hit);
    suffix->scattered = balance ? lf_path_arriving_in_balance(tracer, next, 2, max_depth, balance)
                                : lf_path_arriving(tracer, next, 2, max_depth);
    if (lf_has(scene, LF_TRAITS_FILLED))
        suffix->found = lf_mul(suffix->found, lf_path_absorbed(scene, next));
}

void lf_suffix_meet(lf_tracer *tracer, const lf_event *event, const lf_event *next, int max_depth,
                    lf_suffix *suffix)
{
    meet(tracer, event, next, max_depth, NULL, suffix);
}

void lf_suffix_follow_in_balance(lf_tracer *tracer, const lf_event *event, int max_depth,
                                 const lf_light_balance *balance, lf_suffix *suffix)
{
    lf_event next;
    lf_path_next(tracer, event, suffix->wi, &next);
    meet(tracer, event, &next, max_depth, balance, suffix);
}

void lf_suffix_follow(lf_tracer *tracer, const lf_event *event, int max_depth, lf_suffix *suffix)
{
    lf_suffix_follow_in_balance(tracer, event, max_depth, NULL, suffix);
}

void lf_suffix_turn(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                    lf_suffix *suffix)
{
    lf_vec3 f;
    float u[3];
    lf_sampler_2d(sampler, u);
    u[2] = lf_sampler_1d(sampler);
    suffix->found = suffix->scattered = lf_v3(0.0f, 0.0f, 0.0f);
    suffix->found_pdf = 0.0f;
    suffix->found_light = NULL;
    float pdf = lf_scatter_sample(tracer->scene, event, wo, u, &suffix->wi, &f);
    /* A direction counts in W' even if no light is reflected along it. */
    suffix->has_direction = pdf > 0.0f;
    suffix->is_pending =
        suffix->has_direction && (lf_max3(f) > 0.0f || lf_path_serves_others(event, suffix->wi));
    if (suffix->is_pending)
        tracer->spread = LF_SUFFIX_SPREAD;
}

void lf_suffix_redraw(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                      int max_depth, lf_suffix *suffix)
{
    lf_suffix_turn(tracer, event, wo, sampler, suffix);
    if (suffix->is_pending)
        lf_suffix_follow(tracer, event, max_depth, suffix);
}

void lf_suffix_draw(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                    int max_depth, lf_suffix *out)
{
    *out = (lf_suffix){0};
    lf_suffix_draw_light(tracer, event, sampler, out);
    lf_suffix_redraw(tracer, event, wo, sampler, max_depth, out);
}

lf_vec3 lf_suffix_radiance(const lf_scene *scene, const lf_event *event, const lf_suffix *suffix,
                           lf_vec3 wo)
{
    lf_vec3 radiance = lf_v3(0.0f, 0.0f, 0.0f), f;
    if (suffix->has_light) {
        float pdf = lf_scatter_eval(scene, event, wo, suffix->light.wi, &f);
        float weight = suffix->light_visible /
                       (suffix->light.delta ? suffix->light.pdf : suffix->light.pdf + pdf);
        radiance = lf_scale(lf_mul(f, suffix->light.radiance), weight);
    }
    if (suffix->has_direction) {
        float pdf = lf_scatter_eval(scene, event, wo, suffix->wi, &f);
        lf_vec3 arriving =
            lf_madd(suffix->scattered, pdf / (pdf + suffix->found_pdf), suffix->found);
        if (pdf > 0.0f)
            radiance = lf_madd(radiance, 1.0f / pdf, lf_mul(f, arriving));
    }
    return radiance;
}

/* Numbers of the sampler for the light sample of a suffix, and for all of it. */
enum { LIGHT_DIMENSIONS = 3, DIMENSIONS = 6 };

void lf_suffix_draw_of(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                       const lf_splitting *of, int i, lf_suffix *suffix)
{
    const bool is_shared = of->lights < of->suffixes;
    if (is_shared && i == 0)
        lf_suffix_draw_light(tracer, event, sampler, suffix);
    if (i > 0)
        lf_sampler_next(sampler, sampler->dimension - DIMENSIONS);
    else if (of->suffixes > 1)
        lf_sampler_split(sampler, of->suffixes);
    if (!is_shared)
        lf_suffix_draw_light(tracer, event, sampler, suffix);
    else if (i > 0)
        sampler->dimension += LIGHT_DIMENSIONS;
    lf_suffix_turn(tracer, event, wo, sampler, suffix);
}

lf_vec3 lf_suffix_radiance_of(const lf_scene *scene, const lf_event *event, lf_vec3 wo,
                              const lf_splitting *of, const lf_suffix *suffix)
{
    if (of->lights == of->suffixes)
        return lf_suffix_radiance(scene, event, suffix, wo);
    const float each = (float)of->suffixes / (float)of->lights;
    lf_suffix own = *suffix;
    lf_vec3 f;
    if (own.has_light && !own.light.delta)
        own.light.pdf += (each - 1.0f) * lf_scatter_eval(scene, event, wo, own.light.wi, &f);
    own.light.radiance = lf_scale(own.light.radiance, each);
    own.found_pdf /= each;
    return lf_suffix_radiance(scene, event, &own, wo);
}

bool lf_is_view_dependent(const lf_scene *scene, const lf_event *event)
{
    return event->kind == LF_EVENT_SURFACE
               ? event->hit.material->kind->view_dependent
               : !lf_volume_is_isotropic(&scene->volumes[event->volume]);
}
