#include "render/rows/native.h"

#include "render/rows/adaptive.h"
#include "render/transport/surface_glass.h"
#include "render/transport/surface_texture.h"

/* Whether base samples follow delta lobes also where pixels have samples of their own
 * (sample_mirrors): only if all get as many base samples, or as many as the map expects, or there
 * are no others. Those with one more than others would be brighter by it. */
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

/* What one delta lobe of the first surface brings: native, into M. */
static void follow_delta(lf_visit *visit, int view, int column, const lf_pivot *pivot,
                         const lf_delta *lobe, float probability)
{
    const lf_event *event = &pivot->event;
    lf_tracer *tracer = &visit->worker->tracer;
    if (lf_rng(tracer) >= probability)
        return;
    lf_event next;
    lf_path_next(tracer, event, lobe->wi, &next);
    float light_pdf;
    lf_vec3 radiance = lf_path_light_found(visit->scene, event, &next, &light_pdf);
    radiance = lf_mul(radiance, lf_path_absorbed(visit->scene, &next));
    radiance = lf_add(radiance, lf_path_arriving(tracer, &next, 2, visit->max_depth));
    size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    lf_vec3 channels;
    float weight = visit->weight * native_weight(visit, pixel) *
                   lf_visit_correction(visit, view, pivot, &channels);
    radiance = lf_mul(radiance, channels);
    radiance = lf_scale(lf_mul(radiance, lobe->f), weight / probability);
    lf_visit_add_native(visit, pixel, radiance);
}

/* What a veil sends out by itself: native, as how much of it is there is a matter of chance for a
 * sample; of other surfaces it is known (exits.c). */
static void add_glow_of_veil(lf_visit *visit, int view, int column, const lf_pivot *pivot)
{
    const lf_hit *hit = &pivot->event.hit;
    if (hit->material->cover == LF_COVER_OPAQUE || !(lf_max3(hit->material->emission) > 0.0f))
        return;
    size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    lf_vec3 channels;
    float weight = visit->weight * native_weight(visit, pixel) *
                   lf_visit_correction(visit, view, pivot, &channels);
    lf_visit_add_native(visit, pixel,
                        lf_scale(lf_mul(lf_hit_material(hit)->emission, channels), weight));
}

void lf_natives_of_panes(lf_visit *visit, int view, int column, const lf_pivot *ray, lf_vec3 eye,
                         float t_end)
{
    lf_tracer *tracer = &visit->worker->tracer;
    lf_pivot pivot = *ray;
    lf_event *event = &pivot.event;
    float t = 0.0f;
    event->kind = LF_EVENT_SURFACE;
    while (lf_trace_pane(tracer, eye, event->w, t, t_end, &event->hit)) {
        lf_vec3 d = lf_sub(event->hit.p, visit->rig->eye);
        lf_delta lobe[LF_MAX_DELTAS];
        const lf_material *m = event->hit.material;
        float cosine = -lf_dot(event->hit.ns, event->w);
        t = lf_behind(event->hit.t);
        event->p = event->hit.p;
        pivot.x = lf_dot(d, visit->rig->right);
        pivot.z = lf_dot(d, visit->rig->forward);
        if (m->kind->deltas(m, event->hit.ng, event->hit.ns, lf_scale(event->w, -1.0f),
                            event->hit.front, lobe) == 0)
            continue;
        lobe->f = lf_scale(lobe->f, 1.0f - lf_pane_passes(m, cosine));
        follow_delta(visit, view, column, &pivot, lobe, 1.0f);
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
    if (!visit->sums.native)
        return;
    if (visit->scene->looks.veiled)
        add_glow_of_veil(visit, view, column, pivot);
    lf_shade(&pivot->event.hit, lf_scale(pivot->event.w, -1.0f), &shading);
    if (visit->pilot && shading.n_deltas > 0)
        lf_counts_mark_delta(visit->pilot, visit->row, view, column);
    for (int i = 0; i < shading.n_deltas; i++)
        follow_delta(visit, view, column, pivot, &shading.delta[i],
                     lf_min(1.0f, 4.0f * lf_max3(shading.delta[i].f)));
}
