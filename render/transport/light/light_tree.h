/* Selects a triangle of an area light as seen from a point: one that faces the point, with higher
 * probability for nearer ones (after Conty and Kulla, Importance Sampling of Many Lights with
 * Adaptive Tree Splitting, 2018, without the splitting). The tree halves the list of triangles
 * repeatedly, because shapes list neighbours together. Private to render/transport/light*.c. */
#ifndef LF_RENDER_LIGHT_TREE_H
#define LF_RENDER_LIGHT_TREE_H

#include "render/scene/scene.h"

/* Bounds of a set of triangles: a ball around them, a cone around their normals, and moments of the
 * normals. Seen along direction w, the triangles that face it have the projected area (S + M) / 2,
 * S = sum a (n w) and M = sum a |n w|. M is approximated by the root of sum a times sum a (n w)^2,
 * which is exact for flat sets and 15 % too large for a ball. */
typedef struct lf_light_node {
    lf_vec3 centre, axis;
    float radius, cosine, sine; /* of the cone's half angle */
    float area;
    lf_vec3 normals;           /* sum a n */
    lf_vec3 squares, products; /* sum a (xx, yy, zz) and a (yz, zx, xy) of n */
} lf_light_node;

/* Makes the tree of a one-sided mesh light whose triangles and areas are set. A flat light, or one
 * with few triangles, does not benefit. The root is 1, the halves of i are 2 i and 2 i + 1.
 * Released with lf_free; NULL = out of memory. */
lf_light_node *lf_light_tree_make(const lf_light *light, const lf_mesh *mesh);

/* Returns an index into light->triangle, chosen with `place` in [0, 1), and its probability; -1: no
 * triangle faces p. */
int lf_light_tree_choose(const lf_light *light, lf_vec3 p, double place, float *out_probability);
/* The probability of choosing this triangle from p. */
float lf_light_tree_probability(const lf_light *light, lf_vec3 p, int triangle);

#endif
