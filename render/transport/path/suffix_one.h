/* The rest of the path behind a vertex, one at a time: a light sample, and a direction from the
 * lobe of one view with what comes along it; private to render/. Whoever draws it says who gets it
 * and by which weights. suffix_batch.h draws many together. */
#ifndef LF_RENDER_SUFFIX_ONE_H
#define LF_RENDER_SUFFIX_ONE_H

#include "render/transport/path/path.h"
#include "render/transport/sampler.h"

typedef struct lf_suffix {
    lf_light_sample light;
    /* whose `found` is, where the scene has lights in media and it is a lamp's; else NULL */
    const lf_light *found_light;
    /* another direction of the same vertex, drawn as this one, with no light; NULL: none */
    const struct lf_suffix *next;
    float light_visible; /* what is left of it, 0..1 */
    lf_vec3 wi;          /* the direction */
    lf_vec3 found;       /* light met at its first event … */
    float found_pdf;     /* … and p_L, the pdf of light sampling for it; 0: none */
    lf_vec3 scattered;   /* radiance scattered there */
    bool has_light, has_direction;
} lf_suffix;

/* Draws the light sample of a suffix that is all zero, and looks how much of it is left. */
void lf_suffix_draw_light(lf_tracer *tracer, const lf_event *event, lf_sampler *sampler,
                          lf_suffix *suffix);
/* Draws a direction in place of the suffix's own and follows it; its light sample stays. wo is
 * where the direction's lobe looks back to, the base view's place or that of any view that sees the
 * vertex. */
void lf_suffix_redraw(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                      int max_depth, lf_suffix *suffix);
/* Draws both. */
void lf_suffix_draw(lf_tracer *tracer, const lf_event *event, lf_vec3 wo, lf_sampler *sampler,
                    int max_depth, lf_suffix *out);

/* What comes along the suffix's direction, whoever has drawn it. */
void lf_suffix_follow(lf_tracer *tracer, const lf_event *event, int max_depth, lf_suffix *suffix);
/* The same where `next` is what it meets first (lf_path_next). */
void lf_suffix_meet(lf_tracer *tracer, const lf_event *event, const lf_event *next, int max_depth,
                    lf_suffix *suffix);

/* Radiance that the suffix gives to a view that looks from wo, when that view alone samples it
 * (balance heuristic between its lobe and light sampling). What vpt uses, and mvpt where the lobe
 * does not depend on the view. */
lf_vec3 lf_suffix_radiance(const lf_scene *scene, const lf_event *event, const lf_suffix *suffix,
                           lf_vec3 wo);

/* Whether what a vertex scatters depends on the view. */
bool lf_is_view_dependent(const lf_scene *scene, const lf_event *event);

#endif
