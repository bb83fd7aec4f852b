#include "render/import/reader/gltf_node.h"

#include <stdlib.h>
#include <string.h>

#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_animation.h"

static void take_floats(const json_t *node, const char *key, size_t n, float *out)
{
    double v[4];
    if (lf_gltf_numbers(node, key, n, v))
        for (size_t i = 0; i < n; i++)
            out[i] = (float)v[i];
}

static lf_gltf_node node_of(const json_t *json)
{
    double m[16];
    lf_gltf_node node = {.pose = LF_GLTF_AT_REST,
                         .parent = LF_GLTF_NONE,
                         .mesh = lf_gltf_index(json, "mesh"),
                         .skin = lf_gltf_index(json, "skin")};
    take_floats(json, "translation", 3, node.pose.translation);
    take_floats(json, "rotation", 4, node.pose.rotation);
    take_floats(json, "scale", 3, node.pose.scale);
    node.is_hidden =
        json_is_false(json_object_get(lf_gltf_extension(json, "KHR_node_visibility"), "visible"));
    node.has_matrix = lf_gltf_numbers(json, "matrix", 16, m);
    for (int i = 0; i < 12 && node.has_matrix; i++)
        node.matrix.m[i % 3][i / 3] = m[i / 3 * 4 + i % 3];
    return node;
}

lf_affine lf_gltf_transform(const lf_gltf_pose *pose)
{
    double x = (double)pose->rotation[0], y = (double)pose->rotation[1],
           z = (double)pose->rotation[2], w = (double)pose->rotation[3],
           length = x * x + y * y + z * z + w * w, s = length > 0 ? 2 / length : 0;
    lf_affine out = {{{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0},
                      {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w), 0},
                      {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y), 0}}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            out.m[i][j] *= (double)pose->scale[j];
        out.m[i][3] = (double)pose->translation[i];
    }
    return out;
}

/* The nodes that an array names: calls for each. */
typedef lf_status node_fn(lf_gltf_nodes *nodes, uint32_t from, uint32_t number, lf_error *err);

static lf_status for_each(const json_t *array, lf_gltf_nodes *nodes, uint32_t from, node_fn *call,
                          lf_error *err)
{
    lf_status status = LF_OK;
    for (size_t i = 0; i < json_array_size(array) && status == LF_OK; i++) {
        const json_t *value = json_array_get(array, i);
        double number = json_is_number(value) ? json_number_value(value) : -1;
        if (!(number >= 0 && number < (double)nodes->n))
            return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                                "a node index is out of range; the file has %zu nodes", nodes->n);
        status = call(nodes, from, (uint32_t)number, err);
    }
    return status;
}

static lf_status adopt(lf_gltf_nodes *nodes, uint32_t parent, uint32_t child, lf_error *err)
{
    if (nodes->node[child].parent != LF_GLTF_NONE)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "nodes[%u] is a child of two others", child);
    nodes->node[child].parent = parent;
    return LF_OK;
}

static lf_status show(lf_gltf_nodes *nodes, uint32_t from, uint32_t number, lf_error *err)
{
    (void)from, (void)err;
    nodes->node[number].is_shown = true;
    return LF_OK;
}

/* The scene's nodes; without a scene, all nodes without a parent. */
static lf_status show_scene(const lf_gltf *gltf, lf_gltf_nodes *nodes, lf_error *err)
{
    uint64_t number = lf_gltf_whole(gltf->json, "scene", 0);
    const json_t *scene = lf_gltf_element(gltf->json, "scenes", number);
    if (scene)
        return for_each(json_object_get(scene, "nodes"), nodes, 0, show, err);
    if (json_object_get(gltf->json, "scene"))
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "scenes[%llu] does not exist; the file has %zu",
                            (unsigned long long)number, lf_gltf_count(gltf->json, "scenes"));
    for (size_t i = 0; i < nodes->n; i++)
        nodes->node[i].is_shown = nodes->node[i].parent == LF_GLTF_NONE;
    return LF_OK;
}

/* Nodes in an order in which parents come first. LF_E_FORMAT: there is none. */
static lf_status sort(const lf_gltf *gltf, const lf_gltf_nodes *nodes, uint32_t *order,
                      lf_error *err)
{
    size_t n = 0;
    for (uint32_t i = 0; i < nodes->n; i++)
        if (nodes->node[i].parent == LF_GLTF_NONE)
            order[n++] = i;
    for (size_t at = 0; at < n; at++) {
        const json_t *node = lf_gltf_element(gltf->json, "nodes", order[at]),
                     *children = json_object_get(node, "children");
        for (size_t i = 0; i < json_array_size(children); i++)
            order[n++] = (uint32_t)json_number_value(json_array_get(children, i));
    }
    return n == nodes->n ? LF_OK
                         : lf_error_set(err, LF_E_FORMAT, LF_HERE,
                                        "nodes are children of each other, in a loop");
}

/* Takes the meshes of hidden nodes away. */
static lf_status hide(lf_gltf_nodes *nodes, lf_error *err)
{
    size_t n_hidden = 0, n_left = 0;
    for (size_t i = 0; i < nodes->n; i++) {
        lf_gltf_node *node = &nodes->node[i];
        if (!node->is_shown || node->mesh == LF_GLTF_NONE)
            continue;
        n_hidden += node->is_hidden;
        n_left += !node->is_hidden;
        if (node->is_hidden)
            node->mesh = LF_GLTF_NONE;
    }
    return n_hidden == 0 || n_left > 0
               ? LF_OK
               : lf_error_set(err, LF_E_FORMAT, LF_HERE,
                              "every mesh is hidden by KHR_node_visibility; one must be visible");
}

static lf_status place(const lf_gltf *gltf, const lf_affine *world, lf_gltf_nodes *nodes,
                       lf_error *err)
{
    uint32_t *order = malloc((nodes->n + 1) * sizeof *order);
    lf_status status = order ? sort(gltf, nodes, order, err)
                             : lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < nodes->n && status == LF_OK; i++) {
        lf_gltf_node *node = &nodes->node[order[i]];
        const lf_gltf_node *parent =
            node->parent == LF_GLTF_NONE ? NULL : &nodes->node[node->parent];
        lf_affine own = node->has_matrix ? node->matrix : lf_gltf_transform(&node->pose);
        node->to_world = lf_affine_compose(parent ? &parent->to_world : world, &own);
        node->is_shown = node->is_shown || (parent && parent->is_shown);
        node->is_hidden = node->is_hidden || (parent && parent->is_hidden);
    }
    free(order);
    return status == LF_OK ? hide(nodes, err) : status;
}

lf_status lf_gltf_nodes_open(lf_gltf *gltf, const lf_gltf_playing *playing, const lf_affine *world,
                             lf_gltf_nodes *out, lf_error *err)
{
    lf_status status = LF_OK;
    out->n = lf_gltf_count(gltf->json, "nodes");
    out->node = calloc(out->n + 1, sizeof *out->node);
    if (!out->node)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    for (size_t i = 0; i < out->n; i++)
        out->node[i] = node_of(lf_gltf_element(gltf->json, "nodes", i));
    for (uint32_t i = 0; i < out->n && status == LF_OK; i++)
        status = for_each(json_object_get(lf_gltf_element(gltf->json, "nodes", i), "children"), out,
                          i, adopt, err);
    if (status == LF_OK)
        status = show_scene(gltf, out, err);
    if (status == LF_OK)
        status = lf_gltf_animate(gltf, playing, out, err);
    return status == LF_OK ? place(gltf, world, out, err) : status;
}

void lf_gltf_nodes_close(lf_gltf_nodes *nodes)
{
    for (size_t i = 0; nodes->node && i < nodes->n; i++)
        free(nodes->node[i].weights);
    free(nodes->node);
    *nodes = (lf_gltf_nodes){0};
}
