/* A path after the camera's segment: events, scattering, direct light and the whole suffix; private
 * to render/. vpt and mvpt share all of it. */
#ifndef LF_RENDER_PATH_H
#define LF_RENDER_PATH_H

#include "render/transport/path/light_balance.h"
#include "render/transport/path/nest.h"
#include "render/transport/path/phase.h"
#include "render/transport/path/track.h"

typedef enum lf_event_kind { LF_EVENT_ESCAPE, LF_EVENT_MEDIUM, LF_EVENT_SURFACE } lf_event_kind;

/* The medium inside a closed mesh whose surface has subsurface (subsurface.h). */
typedef struct lf_subsurface {
    const lf_material *of; /* the surface that was entered; NULL: none */
    lf_vec3 sigma_t;       /* per scene unit */
    lf_vec3 albedo;        /* single-scattering */
    float g;               /* Henyey-Greenstein */
} lf_subsurface;

/* A vertex of a path. */
typedef struct lf_event {
    lf_event_kind kind;
    lf_vec3 p;
    lf_vec3 w; /* unit direction of travel with which the path arrived */
    /* LF_EVENT_MEDIUM: the volume that the path collided with; LF_INTERIOR: an interior medium of
     * glass */
    int volume;
    lf_hit hit; /* LF_EVENT_SURFACE */
    /* Set by lf_path_next: the segment that ends here. */
    lf_vec3 from;  /* its start … */
    float t;       /* … and its length */
    float surface; /* distance of the first surface along it, INFINITY: none */
    /* In chromatic scenes: for each channel, the light over the density with which tracking in a
     * randomly chosen channel comes here (lf_track_channels). */
    lf_vec3 channels;
    /* In scenes with LF_TRAITS_FILLED: the glass in which the segment lies, NULL: none, and the
     * factor of light along it (interior.h). */
    const lf_material *interior;
    lf_vec3 left;
    lf_nest nest; /* in scenes with LF_TRAIT_NESTED_GLASS: the solids around that segment */
    /* In scenes with LF_TRAIT_SUBSURFACE: the medium through which the path came here. */
    lf_subsurface subsurface;
} lf_event;
#define LF_INTERIOR (-1)

/* Growth of a path's texture footprint after a vertex that is not a mirror, per unit of length. */
#define LF_SUFFIX_SPREAD 0.05f

/* The next event of a path that leaves `from` (a vertex) along the unit vector w. */
void lf_path_next(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_event *out);

/* The transmittance of the glass interior along the segment that ends at the event, or of the
 * random walk through subsurface. 1 in scenes with clear glass and no subsurface. */
lf_vec3 lf_path_absorbed(const lf_scene *scene, const lf_event *event);
/* The same for a light sample on its way to the event. */
lf_vec3 lf_path_absorbed_light(const lf_scene *scene, const lf_event *event,
                               const lf_light_sample *light);

/* The threshold of a tracer whose `roulette` is 0. */
#define LF_ROULETTE 0.25f
/* Unbiased roulette: a path with a throughput below the threshold survives with a probability that
 * raises the survivors' throughput to the threshold. */
static inline bool lf_path_survives(lf_tracer *tracer, lf_vec3 *beta)
{
    const float threshold = LF_ROULETTE + tracer->roulette;
    float m = lf_max3(*beta);
    if (m >= threshold)
        return true;
    if (lf_rng(tracer) * threshold >= m)
        return false;
    *beta = lf_scale(*beta, threshold / m);
    return true;
}

/* lf_scatter_eval for a hit with lf_hit_bent_normal. */
float lf_hit_eval_folded(const lf_hit *hit, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);

/* Non-delta scattering at a vertex towards wi. Returns the pdf of sampling it; *f gets albedo x
 * phase or f |cos|. 0 if wi leads through the surface, which is possible with a shading normal. wo
 * is the unit direction back along the path. */
float lf_scatter_eval(const lf_scene *scene, const lf_event *event, lf_vec3 wo, lf_vec3 wi,
                      lf_vec3 *f);
/* Draws wi; pdf 0 = absorbed. */
float lf_scatter_sample(const lf_scene *scene, const lf_event *event, lf_vec3 wo, const float u[3],
                        lf_vec3 *wi, lf_vec3 *f);

/* Whether light along wi may matter for other view directions on the same side although `wo`
 * receives none: what one direction refracts into glass lies in a cone of its own. */
bool lf_path_serves_others(const lf_event *event, lf_vec3 wi);

/* Visibility of a light sample from the vertex, times an unbiased estimate of the transmittance. In
 * chromatic media the transmittance is applied to the sample's radiance. 0 if the light is behind
 * the surface. */
float lf_path_visible(lf_tracer *tracer, const lf_event *event, lf_light_sample *light);
/* lf_path_visible, with the absorption of solid glass applied to the sample's radiance. */
float lf_path_lit(lf_tracer *tracer, const lf_event *event, lf_light_sample *light);

/* Radiance of light at the first event of a path that leaves with direction w (light reached
 * without a collision), times the event's channels, and the pdf with which light sampling at `from`
 * would draw w. */
lf_vec3 lf_path_light_found(const lf_scene *scene, const lf_event *from, const lf_event *event,
                            float *out_light_pdf);

/* Radiance scattered back along the segment that ends at `next`, at points drawn around one of the
 * equiangular lights (equiangular.h). lf_path_scattered weights collisions for these lights
 * accordingly. 0 if the scene has none. */
lf_vec3 lf_path_equiangular(lf_tracer *tracer, const lf_event *next);

/* Radiance from the segment that ends at `next`: lf_path_equiangular, if it scatters, and volume
 * emission along it. `next` comes from lf_path_next. */
lf_vec3 lf_path_along(lf_tracer *tracer, const lf_event *next, bool scatters);

/* All radiance scattered along the segment that ends at `next`, at `next` and after it, and volume
 * emission along the segment, times its channels and the transmittance of glass or subsurface.
 * Arguments as in lf_path_scattered. `next` comes from lf_path_next. */
lf_vec3 lf_path_arriving(lf_tracer *tracer, const lf_event *next, int depth, int max_depth);

/* Radiance scattered at `event` back along the path, by next-event estimation and a random walk.
 * The vertex is number `depth` after the camera (the pivot is 1); paths end after vertex max_depth.
 * Excludes light emitted AT the vertex or before it. The event comes from lf_path_next and includes
 * its channels. */
lf_vec3 lf_path_scattered(lf_tracer *tracer, const lf_event *event, int depth, int max_depth);

/* The same for a path that shares its light with light paths (light_balance.h): every contribution
 * has its balance weight. `event` is the first vertex after the pivot, or `next` leads to it. */
lf_vec3 lf_path_arriving_in_balance(lf_tracer *tracer, const lf_event *next, int depth,
                                    int max_depth, const lf_light_balance *balance);
lf_vec3 lf_path_scattered_in_balance(lf_tracer *tracer, const lf_event *event, int depth,
                                     int max_depth, const lf_light_balance *balance);

/* The pdf with which scattering at a vertex turns light from wi towards wo, for the balance of
 * light paths. 0 in media, and unless both lie on the side of the geometric normal. */
float lf_path_reverse_pdf(const lf_scene *scene, const lf_event *event, lf_vec3 wo, lf_vec3 wi);

/* Whether the delta lobe that leads from wo to wi also leads back, so that light paths can come the
 * same way: not if a bent normal has mirrored it. *f: its lobe then, for light from wo. */
bool lf_path_reverse_delta(const lf_event *event, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);

/* Chooses between a surface's delta lobes and its other lobes; true: the path continues along *wi,
 * the direction of a delta lobe. */
bool lf_path_follows_delta(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_vec3 *wi,
                           lf_vec3 *beta);

#endif
