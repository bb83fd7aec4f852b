/* Solids of glass that stand in each other or overlap (a bottle, the water in it): which of them a
 * path is inside of, and so what lies on either side of a face (Schmidt and Budge 2002, Simple
 * Nested Dielectrics in Ray Traced Images). In a place the solid of the greatest number is there
 * (lf_nesting.solids): that of the greater "priority", and of the same the smaller one. A face on
 * both sides of which is the same is not there. Private to render/. Only scenes with
 * LF_TRAIT_NESTED_GLASS ask.
 */
#ifndef LF_RENDER_NEST_H
#define LF_RENDER_NEST_H

#include "render/transport/path/track.h"

/* So many solids may be about one place; further ones are not there. */
#define LF_MOST_NESTED 8

/* A solid, in one of its places, with the material of the face through which it was entered. */
typedef struct lf_nested {
    uint32_t place;
    uint16_t solid, material;
} lf_nested;

/* A path begins where none are. */
typedef struct lf_nest {
    int n;
    lf_nested in[LF_MOST_NESTED];
} lf_nest;

struct lf_event;

/* About a path that leaves the event along w. */
lf_nest lf_nest_beyond(const lf_scene *scene, const struct lf_event *from, lf_vec3 w);

/* What is there, where `in` is what a single solid would make of it (interior.c): beyond an event,
 * which a path leaves along w, and along the segment that ends at the next. NULL: air. */
const lf_material *lf_nest_beyond_is(const lf_scene *scene, const struct lf_event *from, lf_vec3 w,
                                     const lf_material *in);
const lf_material *lf_nest_before_is(const lf_scene *scene, const struct lf_event *from, lf_vec3 w,
                                     const struct lf_event *out, const lf_material *in);

/* lf_trace_surface of a ray from o that leaves `from` along w, past faces that are not there. Sets
 * what is about it, and the hit's own material to what its face is between the two media. A solid
 * that is met from within is about it, and one that is met from outside is not: this mends what a
 * path has missed. */
bool lf_nest_trace(lf_tracer *tracer, const struct lf_event *from, lf_vec3 o, lf_vec3 w,
                   float t_max, lf_nest *nest, lf_hit *hit);

/* The same of an event to which a walk through flesh led: faces that are not there turn nothing. */
void lf_nest_after_subsurface(const lf_scene *scene, const struct lf_event *from, lf_vec3 w,
                              struct lf_event *out);

#endif
