/* The path after a vertex, one at a time: a light sample, and a direction from the lobe of one view
 * with the light along it; private to render/. The caller decides which views receive it and with
 * which weights. suffix_batch.h draws many together. */
#ifndef LF_RENDER_SUFFIX_ONE_H
#define LF_RENDER_SUFFIX_ONE_H

#include "render/transport/path/path.h"
#include "render/transport/sampler.h"

typedef struct lf_suffix {
    lf_light_sample light;
    /* the light of `found`, if the scene has equiangular lights and an area light was found; else
     * NULL */
    const lf_light *found_light;
    /* another direction of the same vertex, drawn in the same way, without a light sample; NULL:
     * none */
    struct lf_suffix *next;
    float light_visible; /* its transmittance, 0..1 */
    lf_vec3 wi;          /* the direction */
    lf_vec3 found;       /* light met at its first event … */
    float found_pdf;     /* … and p_L, the pdf of light sampling for it; 0: not sampled */
    lf_vec3 scattered;   /* radiance scattered there */
    bool has_light, has_direction;
    bool is_pending; /* the light along the direction is not yet computed (lf_suffix_follow) */
} lf_suffix;

/* Draws the light sample of a zeroed suffix, and estimates its transmittance. */
void lf_suffix_draw_light(lf_tracer *tracer, const lf_event *event, lf_sampler *sampler,
                          lf_suffix *suffix);
/* Draws a direction that replaces the suffix's own; the light sample stays. wo is the direction for
 * which the lobe is sampled: towards the base view or any view that sees the vertex. If the
 * direction may carry light, it is pending: to be followed next. */
void lf_suffix_turn(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                    lf_suffix *suffix);
/* lf_suffix_turn, and follows the direction. */
void lf_suffix_redraw(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                      int max_depth, lf_suffix *suffix);
/* Draws the light sample and the direction. */
void lf_suffix_draw(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                    int max_depth, lf_suffix *out);

/* Computes the light along the suffix's direction, which is already drawn. balance: as in
 * lf_path_scattered_in_balance. */
void lf_suffix_follow_in_balance(lf_tracer *tracer, const lf_event *event, int max_depth,
                                 const lf_light_balance *balance, lf_suffix *suffix);
/* The same alone. */
void lf_suffix_follow(lf_tracer *tracer, const lf_event *event, int max_depth, lf_suffix *suffix);
/* lf_suffix_follow for a known first event `next` (lf_path_next). */
void lf_suffix_meet(lf_tracer *tracer, const lf_event *event, const lf_event *next, int max_depth,
                    lf_suffix *suffix);

/* Radiance from the suffix to a view that looks from wo, if only that view samples it (balance
 * heuristic between its lobe and light sampling). Used by vpt, and by mvpt if the lobe does not
 * depend on the view. */
lf_vec3 lf_suffix_radiance(const lf_scene *scene, const lf_event *event, const lf_suffix *suffix,
                           lf_vec3 wo);

/* How many suffixes of a vertex are drawn for one radiance. */
typedef struct lf_splitting {
    int suffixes;   /* directions; 1: nothing below differs from a single suffix */
    int lights;     /* light samples: suffixes, or 1 */
    float roulette; /* as in lf_tracer */
} lf_splitting;
#define LF_SPLITTING_NONE ((lf_splitting){.suffixes = 1, .lights = 1})

/* Draws number i of the suffixes, which come in order, into a zeroed one; its direction is pending.
 * If there is one light sample for all, the first has it, as without splitting. wo: as in
 * lf_suffix_turn. */
void lf_suffix_draw_of(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                       const lf_splitting *of, int i, lf_suffix *suffix);
/* Radiance of one of the suffixes, whose mean is the radiance of the vertex. The direction has been
 * followed. */
lf_vec3 lf_suffix_radiance_of(const lf_scene *scene, const lf_event *event, lf_vec3 wo,
                              const lf_splitting *of, const lf_suffix *suffix);

/* Whether the scattering at a vertex depends on the view. */
bool lf_is_view_dependent(const lf_scene *scene, const lf_event *event);

#endif
