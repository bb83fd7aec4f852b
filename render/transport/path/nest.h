/* Glass solids inside each other or overlapping (a bottle, the water in it): the solids that a path
 * is inside of, and so the media on either side of a face. Source: Schmidt and Budge 2002, Simple
 * Nested Dielectrics in Ray Traced Images. Where solids overlap, the one with the highest
 * "priority" counts, and among equal ones the smaller solid; lf_nesting.solids is in this order. A
 * face with the same solid on both sides is ignored. Private to render/; used only in scenes with
 * LF_TRAIT_NESTED_GLASS. */
#ifndef LF_RENDER_NEST_H
#define LF_RENDER_NEST_H

#include "render/transport/path/track.h"

/* Maximum number of solids around a point; further ones are ignored. */
#define LF_MOST_NESTED 8

/* A solid, in one of its instances, with the material of the face through which it was entered. */
typedef struct lf_nested {
    uint32_t place;
    uint16_t solid, material;
} lf_nested;

/* A path starts outside of all solids. */
typedef struct lf_nest {
    int n;
    lf_nested in[LF_MOST_NESTED];
} lf_nest;

struct lf_event;

/* The solids around a path that leaves the event along w. */
lf_nest lf_nest_beyond(const lf_scene *scene, const struct lf_event *from, lf_vec3 w);

/* The medium after an event that the path leaves along w, and along the segment that ends at the
 * next event. `in` is the result for a single solid (interior.c). NULL: air. */
const lf_material *lf_nest_beyond_is(const lf_scene *scene, const struct lf_event *from, lf_vec3 w,
                                     const lf_material *in);
const lf_material *lf_nest_before_is(const lf_scene *scene, const struct lf_event *from, lf_vec3 w,
                                     const struct lf_event *out, const lf_material *in);

/* lf_trace_surface for a ray from o that leaves `from` along w, which passes ignored faces. Sets
 * the solids around it, and the hit's own material to the boundary between the two media. A solid
 * that is met from inside is added to the list, and a solid that is met from outside is removed:
 * this corrects a list after errors. */
bool lf_nest_trace(lf_tracer *tracer, const struct lf_event *from, lf_vec3 o, lf_vec3 w,
                   float t_max, lf_nest *nest, lf_hit *hit);

/* The same for an event at the end of a subsurface random walk: ignored faces do not refract. */
void lf_nest_after_subsurface(const lf_scene *scene, const struct lf_event *from, lf_vec3 w,
                              struct lf_event *out);

#endif
