/* What happens along a path behind the camera's segment: events, scattering, direct light and the
 * whole suffix; private to render/. vpt and mvpt share all of it. */
#ifndef LF_RENDER_PATH_H
#define LF_RENDER_PATH_H

#include "render/transport/path/nest.h"
#include "render/transport/path/phase.h"
#include "render/transport/path/track.h"

typedef enum lf_event_kind { LF_EVENT_ESCAPE, LF_EVENT_MEDIUM, LF_EVENT_SURFACE } lf_event_kind;

/* What fills a closed mesh whose surface has subsurface (subsurface.h). */
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
    lf_vec3 w;  /* unit direction of travel with which the path arrived */
    int volume; /* LF_EVENT_MEDIUM: whose collision; LF_INTERIOR: of what fills solid glass */
    lf_hit hit; /* LF_EVENT_SURFACE */
    /* Set by lf_path_next: the segment that ends here. */
    lf_vec3 from;  /* where it began … */
    float t;       /* … and how far from here that is */
    float surface; /* distance of the first surface along it, INFINITY: none */
    /* In chromatic scenes: of each channel, what comes here by the density with which tracking in
     * one of them or the other does (lf_track_channels). */
    lf_vec3 channels;
    /* ... and in scenes with LF_TRAITS_FILLED: the glass that it lies in, NULL: none, and what
     * light along it is to be multiplied by (interior.h). */
    const lf_material *interior;
    lf_vec3 left;
    lf_nest nest; /* in scenes with LF_TRAIT_NESTED_GLASS: of solids about that segment */
    /* In scenes with LF_TRAIT_SUBSURFACE: through which the path came here. */
    lf_subsurface subsurface;
} lf_event;
#define LF_INTERIOR (-1)

/* What a path averages of textures behind a vertex that is no mirror: widens by this with each unit
 * of length. */
#define LF_SUFFIX_SPREAD 0.05f

/* The next event of a path that leaves `from` (a vertex) along the unit vector w. */
void lf_path_next(lf_tracer *tracer, const lf_event *from, lf_vec3 w, lf_event *out);

/* What solid glass leaves of light along the segment that ends at the event, or flesh along the way
 * through it. 1 in scenes whose glass is clear and that have no flesh. */
lf_vec3 lf_path_absorbed(const lf_scene *scene, const lf_event *event);
/* The same of a light sample on its way to the event. */
lf_vec3 lf_path_absorbed_light(const lf_scene *scene, const lf_event *event,
                               const lf_light_sample *light);

/* Unbiased roulette: paths of small throughput go on with a probability that keeps what survives at
 * the threshold. */
static inline bool lf_path_survives(lf_tracer *tracer, lf_vec3 *beta)
{
    const float threshold = 0.25f;
    float m = lf_max3(*beta);
    if (m >= threshold)
        return true;
    if (lf_rng(tracer) * threshold >= m)
        return false;
    *beta = lf_scale(*beta, threshold / m);
    return true;
}

/* What lf_scatter_eval says of a hit that folds. */
float lf_hit_eval_folded(const lf_hit *hit, lf_vec3 wo, lf_vec3 wi, lf_vec3 *f);

/* Non-delta scattering at a vertex towards wi: returns the pdf of sampling it, *f gets albedo x
 * phase or f |cos|; 0 where wi leads through the surface, which a lobe about a shading normal may.
 * wo is the unit direction back to where the path came from. */
float lf_scatter_eval(const lf_scene *scene, const lf_event *event, lf_vec3 wo, lf_vec3 wi,
                      lf_vec3 *f);
/* Draws wi; pdf 0 = absorbed. */
float lf_scatter_sample(const lf_scene *scene, const lf_event *event, lf_vec3 wo, const float u[3],
                        lf_vec3 *wi, lf_vec3 *f);

/* Whether a direction along which `wo` gets nothing may bring light to somebody who looks from
 * elsewhere on the same side: what one direction refracts into glass lies in a cone of its own. */
bool lf_path_serves_others(const lf_event *event, lf_vec3 wi);

/* What is left of a light sample on its way to the vertex: visibility times an unbiased estimate of
 * the transmittance; chromatic media take theirs from the sample's radiance. 0 where the light lies
 * behind the surface. */
float lf_path_visible(lf_tracer *tracer, const lf_event *event, lf_light_sample *light);
/* The same; what solid glass takes of it, too, is taken from the sample's radiance. */
float lf_path_lit(lf_tracer *tracer, const lf_event *event, lf_light_sample *light);

/* Radiance found at the first event of a path that leaves with direction w (light reached without a
 * collision), times the event's channels, and the pdf with which light sampling at `from` would
 * have drawn w. */
lf_vec3 lf_path_light_found(const lf_scene *scene, const lf_event *from, const lf_event *event,
                            float *out_light_pdf);

/* Radiance scattered back along the segment that ends at `next`, at points drawn about one of the
 * lights in media (equiangular.h); what collisions find of these lights in lf_path_scattered makes
 * room for it. 0 where the scene has none. */
lf_vec3 lf_path_equiangular(lf_tracer *tracer, const lf_event *next);

/* What comes from the segment that ends at `next` itself: lf_path_equiangular, if it scatters, and
 * what volumes emit along it. `next` comes from lf_path_next. */
lf_vec3 lf_path_along(lf_tracer *tracer, const lf_event *next, bool scatters);

/* All that is scattered along the segment that ends at `next`, at it and behind it, and what
 * volumes emit along it, times its channels and what glass or flesh leaves of it; arguments as in
 * lf_path_scattered. `next` comes from lf_path_next. */
lf_vec3 lf_path_arriving(lf_tracer *tracer, const lf_event *next, int depth, int max_depth);

/* Radiance scattered at `event` back along the path, by next-event estimation and a random walk;
 * the vertex is number `depth` behind the camera (the pivot is 1) and paths end behind vertex
 * max_depth. Light emitted AT the vertex, or before it, is not counted. The event comes from
 * lf_path_next, whose channels count. */
lf_vec3 lf_path_scattered(lf_tracer *tracer, const lf_event *event, int depth, int max_depth);

#endif
