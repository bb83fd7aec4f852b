/* Light paths of a pass: traced before its rows are visited, connected to the views, and added to
 * the rows as native light; private to render/. docs/developer/estimators/light-paths.md.
 *
 * Each native sample of every view pixel comes with `m` light paths. Their random numbers follow
 * from the pass's stream, the half and the number of the visit. So the same paths belong to a visit
 * whatever rows a program renders, and with any number of threads. */
#ifndef LF_RENDER_LIGHT_PATHS_H
#define LF_RENDER_LIGHT_PATHS_H

#include "render/integrator.h"
#include "render/rows/light_pilot.h"
#include "render/rows/visit.h"

/* Light in a view pixel, an index [view][column] of its row. */
typedef struct lf_light_splat {
    float rgb[3];
    uint32_t pixel;
} lf_light_splat;

/* Splats of consecutive paths, in their order. */
typedef struct lf_light_chunk {
    lf_light_splat *splats;
    uint32_t *rows; /* of each splat */
    size_t n, allocated;
} lf_light_chunk;

/* The light paths of one visit. */
typedef struct lf_light_set {
    int half;
    uint32_t index; /* of the visit in its half */
    uint64_t key;
    int64_t n; /* paths */
    int first_chunk, n_chunks;
    size_t *row_end; /* [height + 1] the splats of row i end at [i + 1], in `sorted` */
    lf_light_splat *sorted;
    size_t allocated;
} lf_light_set;

typedef struct lf_light_paths {
    lf_emitters emitters;
    lf_light_plan plan; /* emitters, number of paths, roulette */
    const lf_scene *scene;
    const lf_rig *rig;
    lf_pool *pool;
    lf_scratch *workers; /* borrowed: not in use between visits */
    lf_light_chunk *chunks;
    lf_light_set *sets;
    int *set_of; /* [height] the row's set in this pass, -1: none */
    int n_chunks, n_sets, chunks_allocated, sets_allocated;
    int max_depth;
    bool alone; /* each path serves one view */
    double cpu; /* seconds of lf_light_paths_begin so far, of the process */
} lf_light_paths;

/* Whether light paths serve a scene and its view; both kinds of paths ask here. */
bool lf_light_paths_serve(const lf_scene *scene, const lf_render_settings *settings);

/* Finds the number of light paths: paths->plan.per_pass, 0 none. paths, seen and rig must stay
 * where they are. alone: each path serves one view. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_light_paths_init(lf_light_paths *paths, const lf_integrator_input *input,
                                           const lf_scene *seen, const lf_rig *rig, bool alone);
/* Traces the light paths of a pass. LF_E_NOMEM, LF_E_CANCELLED. */
LF_NODISCARD lf_status lf_light_paths_begin(lf_light_paths *paths, const lf_pass *pass,
                                            const lf_film *film, const lf_cancel *cancel);
/* Adds the light of the visit's paths to its sums. */
void lf_light_paths_add(const lf_light_paths *paths, lf_visit *visit);
void lf_light_paths_finish(lf_light_paths *paths);

/* The balance of a direction wi from a pivot on a surface. over: as in lf_sharing. false: light
 * paths do not come that way. */
static inline bool lf_light_balance_of(const lf_visit *visit, const lf_pivot *pivot, lf_vec3 wi,
                                       float over, lf_light_balance *out)
{
    const lf_light_paths *light = visit->plan->light;
    if (!light)
        return false;
    *out = (lf_light_balance){.emitters = &light->emitters,
                              .scale = lf_light_balance_scale(light->plan.m, over),
                              .cosine = lf_dot(pivot->event.hit.ng, wi),
                              .faults = visit->faults};
    return out->cosine > 0.0f;
}

#endif
