/* Which triangle of a lamp to draw as seen from a point: one that faces it, the more likely the
 * nearer it is (after Conty and Kulla, Importance Sampling of Many Lights with Adaptive Tree
 * Splitting, 2018, without the splitting). Halves of the list of triangles, again and again: shapes
 * list neighbours together. Private to render/transport/light*.c. */
#ifndef LF_RENDER_LIGHT_TREE_H
#define LF_RENDER_LIGHT_TREE_H

#include "render/scene/scene.h"

/* What is known of some triangles: a ball about them, a cone about their normals, and moments of
 * these. Of what is seen from a direction w the part that faces it has the projected area (S + M) /
 * 2, S = sum a (n w) and M = sum a |n w|; M is taken as the root of sum a times sum a (n w)^2,
 * which is right for flat ones and 15 % too much for a ball. */
typedef struct lf_light_node {
    lf_vec3 centre, axis;
    float radius, cosine, sine; /* of the cone's half angle */
    float area;
    lf_vec3 normals;           /* sum a n */
    lf_vec3 squares, products; /* sum a (xx, yy, zz) and a (yz, zx, xy) of n */
} lf_light_node;

/* Of a one-sided mesh light whose triangles and areas stand; what is flat or has few triangles
 * gains nothing by it. The root is 1, the halves of i are 2 i and 2 i + 1. Released with lf_free;
 * NULL = out of memory. */
lf_light_node *lf_light_tree_make(const lf_light *light, const lf_mesh *mesh);

/* A place in light->triangle by `place` in [0, 1), and how likely that was; -1: all look away from
 * p. */
int lf_light_tree_choose(const lf_light *light, lf_vec3 p, double place, float *out_probability);
/* How likely it is that this one is chosen from p. */
float lf_light_tree_probability(const lf_light *light, lf_vec3 p, int triangle);

#endif
