/* vpt: each view alone, the baseline. The same base samples, suffixes, samplers and known light as mvpt; nothing is shared, so no
 * weights are needed but one over the expected count of the base's own pixel. */
#include "render/integrator.h"

static void pivot_vpt(lf_visit *visit, int view, int column, const lf_pivot *pivot)
{
    float correction = lf_visit_correction(visit, view, pivot);
    if (correction == 0.0f)
        return; /* nothing is there */
    lf_suffix suffix;
    lf_vec3 wo = lf_scale(pivot->event.w, -1.0f);
    lf_suffix_draw(visit, pivot, wo, &suffix);
    lf_vec3 radiance = lf_suffix_radiance(visit, pivot, &suffix, wo);
    size_t pixel = (size_t)view * (size_t)visit->rig->width + (size_t)column;
    lf_film_scattered *out = &visit->sums.half.scattered[pixel];
    visit->worker->contributions++;
    if (!isfinite(radiance.x + radiance.y + radiance.z)) {
        visit->worker->tracer.nonfinite++;
        radiance = lf_v3(0.0f, 0.0f, 0.0f);
    }
    float weight = pivot->boost * visit->alone * correction;
    out->n[0] += weight * radiance.x;
    out->n[1] += weight * radiance.y;
    out->n[2] += weight * radiance.z;
    out->w += weight;
    if (visit->sums.half.w2)
        visit->sums.half.w2[pixel] += weight;
}

const lf_integrator lf_integrator_vpt = {.name = "vpt", .shares = false, .pivot = pivot_vpt};
