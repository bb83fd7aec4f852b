#include "render/transport/path/catcher.h"

#include "render/transport/path/suffix_one.h"
#include "render/transport/surface/surface_lobes.h"

static float passed_by(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t)
{
    return lf_has(tracer->scene, LF_TRAIT_CHROMATIC_MEDIA)
               ? lf_mean3(lf_track_transmittances(tracer, o, w, t))
               : lf_track_transmittance(tracer, o, w, t);
}

void lf_trace_caught(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, lf_hit *hit, float *out_passed)
{
    lf_vec3 from = o;
    *out_passed = 0.0f;
    while (lf_trace_surface(tracer, from, w, INFINITY, hit)) {
        if (hit->mesh->catcher)
            *out_passed = passed_by(tracer, o, lf_normalize(w), lf_length(lf_sub(hit->p, o)));
        if (!hit->mesh->hidden || hit->mesh->catcher)
            return;
        from = lf_offset(tracer->scene, hit->p, lf_scale(hit->ng, -1.0f), w, 0.0f);
    }
}

/* Excludes catchers (the backdrop plate) and the scene's area lights that light it. */
static bool is_thing(const lf_mesh *mesh)
{
    return !mesh->catcher && !mesh->lamp;
}

/* ----------------------------------------------------------------------------------- shadows -- */

/* e: what the sample would bring by itself. */
static void add(lf_tracer *tracer, const lf_event *event, lf_light_sample *light, double e,
                double out[2])
{
    float all = lf_mean3(light->radiance), passed = lf_path_visible(tracer, event, light);
    if (all > 0.0f)
        out[0] += e * (double)(passed * (lf_mean3(light->radiance) / all));
    out[1] += e;
}

void lf_catcher_light(lf_tracer *tracer, const lf_hit *hit, const float u[5], double out[2])
{
    const lf_scene *scene = tracer->scene;
    const lf_event event = {.kind = LF_EVENT_SURFACE, .p = hit->p, .hit = *hit};
    lf_light_sample light;
    if (lf_light_draw(scene, hit->p, u, &light) &&
        !(hit->mesh->reflects && light.mesh && is_thing(light.mesh))) {
        float cosine = lf_dot(hit->ng, light.wi);
        bool found_too = !(light.distance < INFINITY) && !light.delta;
        float other = found_too ? cosine * LF_INV_PI : 0.0f;
        if (cosine > 0.0f)
            add(tracer, &event, &light,
                (double)(lf_mean3(light.radiance) * cosine / (light.pdf + other)), out);
    }
    lf_vec3 t, b, local = lf_cosine_sample(u[3], u[4]);
    float pdf;
    lf_tangents(hit->ng, &t, &b);
    light = (lf_light_sample){.wi = lf_from_frame(t, b, hit->ng, local), .distance = INFINITY};
    light.radiance = lf_light_escape(scene, light.wi, &pdf);
    if (local.z > 0.0f)
        add(tracer, &event, &light,
            (double)(lf_mean3(light.radiance) * local.z / (pdf + local.z * LF_INV_PI)), out);
}

/* -------------------------------------------------------------------------------- reflection -- */

/* The light along wi, drawn with this pdf; 0: a delta lobe. */
static lf_vec3 arriving(lf_tracer *tracer, const lf_event *event, lf_vec3 wi, float pdf,
                        int max_depth)
{
    lf_event next;
    lf_suffix suffix = {0};
    lf_path_next(tracer, event, wi, &next);
    if (next.kind == LF_EVENT_SURFACE && !is_thing(next.hit.mesh))
        next.kind = LF_EVENT_ESCAPE;
    lf_suffix_meet(tracer, event, &next, max_depth, &suffix);
    if (next.kind == LF_EVENT_ESCAPE)
        return suffix.scattered;
    return lf_madd(suffix.scattered, pdf > 0.0f ? pdf / (pdf + suffix.found_pdf) : 1.0f,
                   suffix.found);
}

/* A light sample of emissive objects. */
static lf_vec3 direct(lf_tracer *tracer, const lf_event *event, lf_vec3 wo)
{
    const lf_vec3 nothing = lf_v3(0.0f, 0.0f, 0.0f);
    const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
    lf_light_sample light;
    lf_vec3 f;
    if (!lf_light_draw(tracer->scene, event->p, u, &light) || !light.mesh ||
        !is_thing(light.mesh) || !(lf_dot(event->hit.ng, light.wi) > 0.0f))
        return nothing;
    const float pdf = lf_scatter_eval(tracer->scene, event, wo, light.wi, &f);
    if (!(lf_max3(f) > 0.0f))
        return nothing;
    const float passed = lf_path_lit(tracer, event, &light);
    return lf_scale(lf_mul(f, light.radiance), passed / (light.pdf + pdf));
}

lf_vec3 lf_catcher_reflection(lf_tracer *tracer, const lf_hit *hit, lf_vec3 w, const float u[3],
                              int max_depth)
{
    const lf_event event = {.kind = LF_EVENT_SURFACE, .p = hit->p, .w = w, .hit = *hit};
    const lf_vec3 wo = lf_scale(w, -1.0f);
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f), wi, f;
    lf_shading shading;
    lf_shade(hit, wo, &shading);
    for (int i = 0; i < shading.n_deltas; i++)
        if (lf_dot(hit->ng, shading.delta[i].wi) > 0.0f)
            sum =
                lf_add(sum, lf_mul(shading.delta[i].f,
                                   arriving(tracer, &event, shading.delta[i].wi, 0.0f, max_depth)));
    if (shading.has_lobe) {
        const float pdf = lf_scatter_sample(tracer->scene, &event, wo, u, &wi, &f);
        tracer->spread = LF_SUFFIX_SPREAD;
        if (pdf > 0.0f && lf_max3(f) > 0.0f && lf_dot(hit->ng, wi) > 0.0f)
            sum = lf_add(
                sum, lf_mul(lf_scale(f, 1.0f / pdf), arriving(tracer, &event, wi, pdf, max_depth)));
        if (lf_has(tracer->scene, LF_TRAIT_EMISSION))
            sum = lf_add(sum, direct(tracer, &event, wo));
    }
    tracer->width = tracer->spread = 0.0f; /* as rays of the camera here have them */
    return sum;
}
