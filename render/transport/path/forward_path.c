#include "render/transport/path/forward_path.h"

#include <string.h>

/* A light path on its way. */
typedef struct forward {
    lf_tracer *tracer;
    const lf_emitters *emitters;
    const lf_light *light;
    lf_hit start; /* on the light, for hit_pdf */
    int cell;
    lf_vec3 flux; /* that arrives at the current vertex */
    float most;   /* largest channel of the flux at the start */
    /* p_light / p_suffix of the vertices before, the pdf of the scattering that led here, and the
     * cosine where it did */
    float rate, pdf, cosine;
    bool is_inside; /* of a solid: after an odd number of refractions */
} forward;

static void start(forward *path, lf_event *from, lf_vec3 *w)
{
    lf_tracer *tracer = path->tracer;
    float u[LF_EMITTER_NUMBERS];
    lf_emitted emitted;
    u[0] = lf_rng_fine(tracer);
    u[1] = lf_rng_fine(tracer);
    for (int i = 2; i < LF_EMITTER_NUMBERS; i++)
        u[i] = lf_rng(tracer);
    path->light = lf_emitters_draw(path->emitters, u, &emitted, &path->cell);
    if (!path->light)
        return;
    path->flux = emitted.flux;
    path->most = lf_max3(emitted.flux);
    *w = emitted.w;
    from->kind = emitted.mesh ? LF_EVENT_SURFACE : LF_EVENT_MEDIUM;
    from->p = emitted.p;
    if (!emitted.mesh)
        return;
    const lf_scene *scene = tracer->scene;
    lf_hit *hit = &path->start;
    hit->p = emitted.p;
    hit->ng = hit->ns = emitted.normal;
    hit->mesh = emitted.mesh;
    hit->triangle = emitted.triangle;
    hit->material = &scene->materials[path->light->mesh_material];
    from->hit = *hit;
}

/* The density per unit solid angle with which camera paths find the light from its first vertex,
 * where their scattering has the pdf `pdf`; delta: by a delta lobe. 0: they cannot. */
static float camera_end(const forward *path, const lf_event *first, lf_vec3 back, float pdf,
                        bool delta)
{
    const lf_light *light = path->light;
    const bool hits = path->start.mesh || (light->kind->varies && light->kind->varies(light));
    float drawn = light->select;
    if (path->start.mesh)
        drawn *= light->kind->hit_pdf(light, first->p, &path->start);
    else if (hits)
        (void)lf_light_escape(path->tracer->scene, back, &drawn);
    if (!path->start.mesh && !light->kind->escape) /* points and spots */
        return delta ? 0.0f : light->select;
    if (delta)
        return hits ? 1.0f : 0.0f;
    return hits ? drawn + pdf : drawn;
}

typedef enum turn { TURN_END, TURN_LOBE, TURN_DELTA } turn;

/* Chooses between delta lobes and other lobes, as camera paths do, and passes a delta lobe. Its
 * light is that of the camera path along the same way. */
static turn choose(forward *path, const lf_event *here, lf_vec3 back, lf_vec3 *wi)
{
    const lf_hit *hit = &here->hit;
    lf_shading shading;
    lf_shade(hit, back, &shading);
    if (shading.n_deltas == 0)
        return shading.has_lobe ? TURN_LOBE : TURN_END;
    float mean[LF_MAX_DELTAS] = {0.0f}, sum = 0.0f;
    for (int i = 0; i < shading.n_deltas; i++)
        sum += mean[i] = lf_mean3(shading.delta[i].f);
    const float any = shading.has_lobe ? lf_min(sum, 0.95f) : 1.0f, u = lf_rng(path->tracer);
    if (u >= any) {
        path->flux = lf_scale(path->flux, 1.0f / (1.0f - any));
        return shading.has_lobe ? TURN_LOBE : TURN_END;
    }
    const int i = shading.n_deltas > 1 && u * sum >= any * mean[0];
    lf_vec3 f;
    *wi = shading.delta[i].wi;
    if (!lf_path_reverse_delta(here, back, *wi, &f))
        return TURN_END;
    const bool through = lf_dot(hit->ng, *wi) < 0.0f;
    float k = fabsf(lf_dot(hit->ng, *wi)) / lf_max(fabsf(lf_dot(hit->ng, back)), 1e-6f);
    if (through && hit->material->is_solid) {
        k *= fabsf(lf_dot(hit->ns, back)) / lf_max(fabsf(lf_dot(hit->ns, *wi)), 1e-6f);
        path->is_inside = !path->is_inside;
    }
    path->flux = lf_scale(lf_mul(path->flux, f), k / (any * (mean[i] / sum)));
    return TURN_DELTA;
}

/* Scatters by the other lobes. *out_back: the pdf of camera paths along the same way. false: the
 * path ends. */
static bool scatter(forward *path, const lf_event *here, lf_vec3 back, lf_vec3 *wi, float *out_pdf,
                    float *out_back)
{
    lf_tracer *tracer = path->tracer;
    const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
    lf_vec3 f;
    *out_pdf = lf_scatter_sample(tracer->scene, here, back, u, wi, &f);
    if (!(*out_pdf > 0.0f) || !(lf_dot(here->hit.ng, *wi) > 0.0f))
        return false;
    *out_back = lf_scatter_eval(tracer->scene, here, *wi, back, &f);
    const float k = fabsf(lf_dot(here->hit.ng, *wi)) /
                    (*out_pdf * lf_max(fabsf(lf_dot(here->hit.ng, back)), 1e-6f));
    path->flux = lf_scale(lf_mul(path->flux, f), k);
    return true;
}

/* Leaves a vertex, the first after the light or a later one. false: the path ends. */
static bool leave(forward *path, const lf_event *here, lf_vec3 back, bool is_first, lf_vec3 *wi)
{
    const float cosine = fabsf(lf_dot(here->hit.ng, back));
    float pdf = 1.0f, camera = 1.0f;
    const turn turned = choose(path, here, back, wi);
    if (turned == TURN_END ||
        (turned == TURN_LOBE && !scatter(path, here, back, wi, &pdf, &camera)))
        return false;
    lf_vec3 beta = lf_scale(path->flux, 1.0f / path->most);
    if (!(lf_max3(beta) > 0.0f) || !lf_path_survives(path->tracer, &beta))
        return false;
    path->flux = lf_scale(beta, path->most);
    if (is_first) {
        const lf_light_end end = {back, here->surface, path->start.triangle};
        const float camera_pdf = camera_end(path, here, back, camera, turned == TURN_DELTA),
                    density = lf_emitters_density(path->emitters, path->light, here->p,
                                                  here->hit.ng, &end);
        path->rate = camera_pdf > 0.0f ? density / camera_pdf : INFINITY;
    } else {
        path->rate *= path->pdf * cosine / lf_max(camera * path->cosine, 1e-30f);
    }
    path->pdf = pdf;
    path->cosine = fabsf(lf_dot(here->hit.ng, *wi));
    return true;
}

void lf_forward_trace(lf_tracer *tracer, const lf_emitters *emitters, int max_depth,
                      lf_forward_fn fn, void *context)
{
    forward path = {.tracer = tracer, .emitters = emitters};
    lf_event from, events[2], *here = &events[0];
    lf_vec3 w;
    memset(&from, 0, sizeof from);
    tracer->width = 0.0f;
    tracer->spread = 0.0f; /* textures are averaged by where paths arrive */
    start(&path, &from, &w);
    if (!path.light || !(path.most > 0.0f))
        return;
    lf_path_next(tracer, &from, w, here);
    for (int i = 1; here->kind == LF_EVENT_SURFACE; i++) {
        const lf_vec3 back = lf_scale(here->w, -1.0f);
        const float cosine = fabsf(lf_dot(here->hit.ng, back));
        if (lf_has(tracer->scene, LF_TRAITS_FILLED))
            path.flux = lf_mul(path.flux, lf_path_absorbed(tracer->scene, here));
        if (i > 1 && !path.is_inside && lf_hit_material(&here->hit)->has_lobe) {
            const float rate = path.rate * path.pdf * cosine / lf_max(path.cosine, 1e-9f);
            fn(context,
               &(lf_forward_vertex){here, back, lf_scale(path.flux, 1.0f / lf_max(cosine, 1e-6f)),
                                    rate, path.cell});
        }
        if (i == max_depth || !leave(&path, here, back, i == 1, &w))
            return;
        lf_event *next = here == &events[0] ? &events[1] : &events[0];
        lf_path_next(tracer, here, w, next);
        here = next;
    }
}
