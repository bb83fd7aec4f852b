#include "render/transport/light/light_tree.h"

#include "base/alloc.h"

/* Triangles of a leaf, which are chosen by their area: few enough to face the same way, and enough
 * that the tree of a fine sphere fits in the caches. */
enum { MOST = 16 };

/* Minimum projected area: a triangle that faces p is drawn occasionally, whatever the estimate. */
#define LEAST 0.02f
#define ROUNDING 1e-3f

/* ------------------------------------------------------------------------------------ making -- */

typedef struct making {
    const lf_light *light;
    const lf_mesh *mesh;
    lf_light_node *tree;
} making;

static lf_vec3 corner_of(const making *m, int triangle, int corner)
{
    const uint32_t *t = m->mesh->triangles + 3 * (size_t)m->light->triangle[triangle];
    return lf_mesh_vertex(m->mesh, t[corner]);
}

static lf_vec3 twice_area(const making *m, int triangle)
{
    lf_vec3 a = corner_of(m, triangle, 0);
    return lf_cross(lf_sub(corner_of(m, triangle, 1), a), lf_sub(corner_of(m, triangle, 2), a));
}

static void set_ball(const making *m, int first, int count, lf_light_node *node)
{
    lf_vec3 lo = corner_of(m, first, 0), hi = lo;
    for (int i = 0; i < 3 * count; i++) {
        lf_vec3 v = corner_of(m, first + i / 3, i % 3);
        lo = lf_v3(lf_min(lo.x, v.x), lf_min(lo.y, v.y), lf_min(lo.z, v.z));
        hi = lf_v3(lf_max(hi.x, v.x), lf_max(hi.y, v.y), lf_max(hi.z, v.z));
    }
    node->centre = lf_scale(lf_add(lo, hi), 0.5f);
    for (int i = 0; i < 3 * count; i++)
        node->radius = lf_max(node->radius,
                              lf_length(lf_sub(corner_of(m, first + i / 3, i % 3), node->centre)));
    node->radius *= 1.0f + ROUNDING;
}

static void set_cone(const making *m, int first, int count, lf_light_node *node)
{
    for (int i = 0; i < count; i++) {
        lf_vec3 n = twice_area(m, first + i);
        float size = lf_length(n), inverse = size > 0.0f ? 0.5f / size : 0.0f;
        node->area += 0.5f * size;
        node->normals = lf_madd(node->normals, 0.5f, n);
        node->squares = lf_madd(node->squares, inverse, lf_mul(n, n));
        node->products = lf_madd(node->products, inverse, lf_v3(n.y * n.z, n.z * n.x, n.x * n.y));
    }
    float length = lf_length(node->normals);
    bool closed = !(length > ROUNDING * node->area);
    node->cosine = closed ? -1.0f : 1.0f;
    node->axis = closed ? lf_v3(0.0f, 1.0f, 0.0f) : lf_scale(node->normals, 1.0f / length);
    for (int i = 0; i < count; i++) {
        lf_vec3 n = twice_area(m, first + i);
        float size = lf_length(n);
        if (size > 0.0f)
            node->cosine = lf_min(node->cosine, lf_dot(n, node->axis) / size - ROUNDING * ROUNDING);
    }
    node->cosine = lf_max(node->cosine, -1.0f);
    node->sine = sqrtf(lf_max(0.0f, 1.0f - node->cosine * node->cosine));
}

static void make_node(const making *m, size_t number, int first, int count)
{
    lf_light_node *node = &m->tree[number];
    set_ball(m, first, count, node);
    set_cone(m, first, count, node);
    if (count <= MOST)
        return;
    make_node(m, 2 * number, first, count / 2);
    make_node(m, 2 * number + 1, first + count / 2, count - count / 2);
}

lf_light_node *lf_light_tree_make(const lf_light *light, const lf_mesh *mesh)
{
    size_t n = 2;
    for (int count = light->n_triangles; count > MOST; count -= count / 2)
        n *= 2;
    lf_light_node *tree = lf_calloc(n, sizeof *tree);
    if (!tree)
        return NULL;
    const making m = {light, mesh, tree};
    make_node(&m, 1, 0, light->n_triangles);
    return tree;
}

/* ---------------------------------------------------------------------------------- choosing -- */

/* Whether no triangle of the node faces a point in direction w at this distance: the angle from the
 * axis is at least a right angle plus the cone and the ball's extent. */
static bool looks_away(const lf_light_node *node, lf_vec3 w, float inverse)
{
    float ball_sine = node->radius * inverse;
    if (!(ball_sine < 1.0f))
        return false;
    float ball_cosine = sqrtf(1.0f - ball_sine * ball_sine),
          less_cosine = node->cosine * ball_cosine - node->sine * ball_sine,
          less_sine = node->sine * ball_cosine + node->cosine * ball_sine;
    float cosine = lf_dot(node->axis, w), sine = sqrtf(lf_max(0.0f, 1.0f - cosine * cosine));
    return less_sine > 0.0f && cosine < less_cosine &&
           cosine * less_cosine + sine * less_sine < -ROUNDING;
}

/* The solid angle of what faces p, more or less. */
static float weight_of(const lf_light_node *node, lf_vec3 p)
{
    lf_vec3 to = lf_sub(p, node->centre);
    float distance2 = lf_max(lf_dot(to, to), 1e-30f), inverse = 1.0f / sqrtf(distance2);
    lf_vec3 w = lf_scale(to, inverse);
    if (looks_away(node, w, inverse))
        return 0.0f;
    float square = lf_dot(node->squares, lf_mul(w, w)) +
                   2.0f * lf_dot(node->products, lf_v3(w.y * w.z, w.z * w.x, w.x * w.y)),
          facing = 0.5f * (lf_dot(node->normals, w) + sqrtf(lf_max(node->area * square, 0.0f)));
    return lf_max(facing, LEAST * node->area) /
           lf_max(distance2, lf_max(node->radius * node->radius, 1e-30f));
}

/* How likely the first half of a node is; below 0: neither is. */
static float first_half(const lf_light_node *tree, size_t node, lf_vec3 p)
{
    float a = weight_of(&tree[2 * node], p), b = weight_of(&tree[2 * node + 1], p);
    return a + b > 0.0f ? a / (a + b) : -1.0f;
}

/* Chooses in a leaf, by area. */
static int choose_in_leaf(const double *cdf, int first, int count, double place, float *probability)
{
    double from = cdf[first], all = cdf[first + count] - from, at = from + place * all;
    int i = first;
    while (i + 1 < first + count && cdf[i + 1] <= at)
        i++;
    *probability *= (float)((cdf[i + 1] - cdf[i]) / all);
    return i;
}

int lf_light_tree_choose(const lf_light *light, lf_vec3 p, double place, float *out_probability)
{
    const lf_light_node *tree = light->tree;
    int first = 0, count = light->n_triangles;
    float probability = 1.0f;
    for (size_t node = 1; count > MOST; count = node % 2 ? count - count / 2 : count / 2) {
        double share = (double)first_half(tree, node, p);
        if (share < 0.0)
            return -1;
        bool above = place >= share;
        place = above ? (place - share) / (1.0 - share) : place / share;
        probability *= (float)(above ? 1.0 - share : share);
        first += above ? count / 2 : 0;
        node = 2 * node + (above ? 1 : 0);
    }
    *out_probability = probability;
    return choose_in_leaf(light->area_cdf, first, count, place, out_probability);
}

float lf_light_tree_probability(const lf_light *light, lf_vec3 p, int triangle)
{
    const lf_light_node *tree = light->tree;
    const double *cdf = light->area_cdf;
    int first = 0, count = light->n_triangles;
    float probability = 1.0f;
    for (size_t node = 1; count > MOST; count = node % 2 ? count - count / 2 : count / 2) {
        float share = first_half(tree, node, p);
        bool above = triangle >= first + count / 2;
        probability *= share < 0.0f ? 0.0f : above ? 1.0f - share : share;
        first += above ? count / 2 : 0;
        node = 2 * node + (above ? 1 : 0);
    }
    return probability *
           (float)((cdf[triangle + 1] - cdf[triangle]) / (cdf[first + count] - cdf[first]));
}
