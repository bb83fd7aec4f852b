#include "render/transport/catcher.h"

#include "render/transport/path.h"
#include "render/transport/surface_lobes.h"

static float passed_by(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, float t)
{
    return tracer->scene->looks.chromatic ? lf_mean3(lf_track_transmittances(tracer, o, w, t))
                                          : lf_track_transmittance(tracer, o, w, t);
}

void lf_trace_caught(lf_tracer *tracer, lf_vec3 o, lf_vec3 w, lf_hit *hit, float *out_passed)
{
    lf_vec3 from = o;
    *out_passed = 0.0f;
    while (lf_trace_surface(tracer, from, w, INFINITY, hit)) {
        if (hit->mesh->catcher)
            *out_passed = passed_by(tracer, o, w, lf_length(lf_sub(hit->p, o)));
        if (!hit->mesh->hidden || hit->mesh->catcher)
            return;
        from = lf_offset(tracer->scene, hit->p, lf_scale(hit->ng, -1.0f), w, 0.0f);
    }
}

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
    if (lf_light_draw(scene, hit->p, u, &light)) {
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
