/* A vertex of restir's paths: the media at a point, and how a path leaves it; private to render/.
 * Media may overlap; the code sums over the medium that scattered. */
#ifndef LF_RENDER_PATH_VERTEX_H
#define LF_RENDER_PATH_VERTEX_H

#include "render/scene/look_up.h"
#include "render/transport/path/phase.h"
#include "render/transport/path/track.h"

typedef struct lf_mixture {
    const lf_volume *volume[LF_MAX_VOLUMES];
    float sigma[LF_MAX_VOLUMES], total;
    lf_vec3 albedo[LF_MAX_VOLUMES];
    int n; /* 0: none */
} lf_mixture;

static inline void lf_mixture_at(lf_tracer *tracer, lf_vec3 p, lf_mixture *out)
{
    const lf_scene *scene = tracer->scene;
    out->n = 0;
    out->total = 0.0f;
    tracer->lookups += scene->n_volumes;
    for (int i = 0; i < scene->n_volumes; i++) {
        const lf_volume *volume = &scene->volumes[i];
        float sigma = lf_volume_sigma_t(volume, p);
        if (!(sigma > 0.0f))
            continue;
        out->volume[out->n] = volume;
        out->sigma[out->n] = sigma;
        out->albedo[out->n++] = lf_volume_albedo(volume, p);
        out->total += sigma;
    }
}

/* sigma_s times phase function from w to `on`, and the density with which lf_mixture_draw draws it;
 * n >= 1. */
static inline lf_vec3 lf_mixture_scatter(const lf_mixture *m, lf_vec3 w, lf_vec3 on, float *out_pdf)
{
    lf_vec3 sum = lf_v3(0.0f, 0.0f, 0.0f);
    float pdf = 0.0f;
    for (int i = 0; i < m->n; i++) {
        float lobe = m->sigma[i] * lf_volume_phase(m->volume[i], w, on);
        sum = lf_madd(sum, lobe, m->albedo[i]);
        pdf += lobe;
    }
    *out_pdf = pdf / m->total;
    return sum;
}

static inline lf_vec3 lf_mixture_draw(const lf_mixture *m, lf_vec3 w, lf_tracer *tracer)
{
    float left = lf_rng(tracer) * m->total;
    int i = 0;
    for (; i < m->n - 1 && left >= m->sigma[i]; i++)
        left -= m->sigma[i];
    const float u[3] = {lf_rng(tracer), lf_rng(tracer), lf_rng(tracer)};
    return lf_volume_phase_sample(m->volume[i], w, u);
}

/* How a path leaves a vertex, and the light along this direction: to another vertex (1), to a light
 * sample or to the sky (radiance; light_pdf: of drawing the direction as a light sample). */
typedef struct lf_leaving {
    enum { LF_LEAVES_ON, LF_LEAVES_TO_LIGHT, LF_LEAVES_TO_DELTA_LIGHT, LF_LEAVES_TO_SKY } how;
    lf_vec3 w, brings;
    float light_pdf;
    double distance; /* to the light; else INFINITY */
} lf_leaving;

static inline lf_leaving lf_leave_on(lf_vec3 w)
{
    return (lf_leaving){LF_LEAVES_ON, w, {1.0f, 1.0f, 1.0f}, 0.0f, (double)INFINITY};
}

static inline lf_leaving lf_leave_to_sky(const lf_scene *scene, lf_vec3 w)
{
    float pdf;
    const lf_vec3 radiance = lf_light_escape(scene, w, &pdf);
    return (lf_leaving){LF_LEAVES_TO_SKY, w, radiance, pdf, (double)INFINITY};
}

/* To the light sample that these numbers draw there. Lights at a distance are delta lights here,
 * because there are no surfaces. A sample without light: there is none. */
static inline lf_leaving lf_leave_to_light(const lf_scene *scene, lf_vec3 p, const float u[3])
{
    lf_light_sample light;
    if (!lf_light_draw(scene, p, u, &light))
        return (lf_leaving){.distance = (double)INFINITY};
    return (lf_leaving){light.delta ? LF_LEAVES_TO_DELTA_LIGHT : LF_LEAVES_TO_LIGHT, light.wi,
                        light.radiance, light.pdf, (double)light.distance};
}

/* The contribution of a path that arrives at the vertex along w and leaves it in this way, over the
 * density of the part that a walk does not draw: light samples; skies with the balance heuristic
 * between both strategies. There is no occlusion. */
static inline lf_vec3 lf_mixture_leave(const lf_mixture *m, lf_vec3 w, const lf_leaving *leaving)
{
    float pdf, by;
    const lf_vec3 f = lf_mul(lf_mixture_scatter(m, w, leaving->w, &pdf), leaving->brings);
    switch (leaving->how) {
    case LF_LEAVES_TO_LIGHT:
        by = 1.0f / (leaving->light_pdf + pdf);
        break;
    case LF_LEAVES_TO_DELTA_LIGHT:
        by = 1.0f / leaving->light_pdf;
        break;
    case LF_LEAVES_TO_SKY:
        by = pdf / (pdf + leaving->light_pdf);
        break;
    default:
        by = 1.0f;
    }
    return lf_scale(f, by);
}

#endif
