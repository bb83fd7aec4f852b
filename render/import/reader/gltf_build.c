#include "render/import/reader/gltf_build.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_instances.h"
#include "render/import/reader/gltf_share.h"
#include "render/import/reader/gltf_skin.h"
#include "render/import/scene/tangents.h"

uint32_t lf_gltf_build_material(const lf_gltf_build *build, const lf_gltf_primitive *primitive)
{
    return primitive->material < build->n_materials ? primitive->material
           : primitive->colour.count > 0            ? build->plain_white
                                                    : build->plain;
}

static lf_status visit_mesh(lf_gltf_build *build, const lf_gltf_node *node,
                            const lf_affine *to_world, lf_gltf_visit_fn *visit, void *context,
                            lf_error *err)
{
    const lf_gltf_mesh *mesh = &build->meshes[node->mesh];
    lf_status status = LF_OK;
    for (size_t p = 0; p < mesh->n && status == LF_OK; p++)
        status =
            visit(build, &(lf_gltf_use){node, to_world, mesh, &mesh->primitives[p]}, context, err);
    return status;
}

static lf_status visit_node(lf_gltf_build *build, size_t number, lf_gltf_visit_fn *visit,
                            void *context, lf_error *err)
{
    const lf_gltf_node *node = &build->nodes->node[number];
    const json_t *json = lf_gltf_element(build->gltf->json, "nodes", number);
    lf_gltf_instances instances;
    if (!lf_gltf_extension(json, LF_GLTF_INSTANCING))
        return visit_mesh(build, node, &node->to_world, visit, context, err);
    lf_status status = lf_gltf_instances_open(build->gltf, json, &instances, err);
    for (size_t i = 0; status == LF_OK && i < instances.n; i++) {
        lf_affine own = lf_gltf_instance(&instances, i),
                  to_world = lf_affine_compose(&node->to_world, &own);
        status = visit_mesh(build, node, &to_world, visit, context, err);
    }
    return status;
}

lf_status lf_gltf_visit(lf_gltf_build *build, lf_gltf_visit_fn *visit, void *context, lf_error *err)
{
    lf_status status = LF_OK;
    for (size_t i = 0; i < build->nodes->n && status == LF_OK; i++) {
        const lf_gltf_node *node = &build->nodes->node[i];
        if (node->is_shown && node->mesh != LF_GLTF_NONE &&
            (build->only == 0 || build->only == node->mesh + 1))
            status = visit_node(build, i, visit, context, err);
    }
    return status;
}

/* ---------------------------------------------------------------------------------- counting -- */

/* If other parts have normals, a part without has face normals at every corner: the specification's
 * flat shading. */
static bool is_faceted(const lf_gltf_build *build, const lf_gltf_primitive *primitive)
{
    return build->desc->normals == LF_NORMALS_FILE && build->has_normals &&
           primitive->normal.count == 0;
}

/* Whether the scene's own materials need texture coordinates, and a part has them. */
static bool wants_uvs(const lf_gltf_build *build)
{
    return build->desc->wants.uvs && build->has_uvs;
}

/* Whether its material's texture uses coordinates that the primitive does not have. */
static bool lacks_coordinates(const lf_gltf_build *build, const lf_gltf_primitive *primitive)
{
    const lf_mesh_data *data = build->data;
    if (wants_uvs(build) && primitive->uv[0].count == 0)
        return true;
    if (build->desc->material >= 0 || !data->textures)
        return false;
    const lf_texture_set *textures = &data->textures[lf_gltf_build_material(build, primitive)];
    bool lacks = false;
    for (int i = 0; i < LF_SLOTS; i++) {
        const lf_texture *texture = &textures->slot[i];
        lacks = lacks || (texture->picture != 0 && primitive->uv[texture->set].count == 0);
    }
    return lacks;
}

static lf_status count(lf_gltf_build *build, const lf_gltf_use *place, void *context, lf_error *err)
{
    const lf_gltf_primitive *primitive = place->primitive;
    (void)context, (void)err;
    build->n_beside += (int64_t)primitive->n_beside;
    if (primitive->n_triangles == 0)
        return LF_OK;
    build->n_unmapped += lacks_coordinates(build, primitive);
    build->n_triangles += (int64_t)primitive->n_triangles;
    build->n_vertices += (int64_t)(is_faceted(build, primitive) ? 3 * primitive->n_triangles
                                                                : primitive->position.count);
    return LF_OK;
}

/* ---------------------------------------------------------------------------------- vertices -- */

/* Inputs for building one primitive. */
typedef struct part {
    lf_gltf_build *build;
    const lf_gltf_primitive *primitive;
    const float *weights; /* of morph targets */
    size_t n_weights;
    const lf_gltf_skin *skin; /* NULL: it is at its node's place */
    lf_mesh_place place;
} part;

typedef struct vertex {
    double position[3];
    float normal[3], tangent[4];
} vertex;

static void add(const lf_gltf_accessor *accessor, size_t v, float weight, float out[3])
{
    float d[3] = {0};
    if (accessor->count == 0)
        return;
    lf_gltf_floats(accessor, v, 3, d);
    for (int i = 0; i < 3; i++)
        out[i] += weight * d[i];
}

/* As the file has it, with what morph targets add. */
static vertex vertex_of(const part *p, size_t v)
{
    const lf_gltf_primitive *from = p->primitive;
    float position[3];
    vertex out = {0};
    lf_gltf_floats(&from->position, v, 3, position);
    if (from->normal.count > 0)
        lf_gltf_floats(&from->normal, v, 3, out.normal);
    if (from->tangent.count > 0)
        lf_gltf_floats(&from->tangent, v, 4, out.tangent);
    for (size_t i = 0; i < from->n_targets && i < p->n_weights; i++) {
        const lf_gltf_target *target = &from->targets[i];
        if (p->weights[i] == 0)
            continue;
        add(&target->position, v, p->weights[i], position);
        add(&target->normal, v, p->weights[i], out.normal);
        add(&target->tangent, v, p->weights[i], out.tangent);
    }
    for (int i = 0; i < 3; i++)
        out.position[i] = (double)position[i];
    return out;
}

/* Clamps a vertex attribute; NaN gives the lower limit. Counts in *odd. */
static float within(float v, float low, float high, int *odd)
{
    *odd += !(v >= low && v <= high);
    return v >= low ? fminf(v, high) : low;
}

static int put_coordinates(const part *p, size_t v, size_t to)
{
    lf_mesh_data *data = p->build->data;
    int odd = 0;
    for (int set = 0; set < data->n_uv_sets; set++) {
        float *uv = data->uvs + 2 * ((size_t)set * (size_t)p->build->n_vertices + to);
        if (p->primitive->uv[set].count > 0)
            lf_gltf_floats(&p->primitive->uv[set], v, 2, uv);
        for (int i = 0; i < 2; i++)
            uv[i] =
                isnan(uv[i]) ? within(NAN, 0, 0, &odd) : within(uv[i], -LF_MAX_UV, LF_MAX_UV, &odd);
    }
    return odd;
}

static int put_colour(const part *p, size_t v, size_t to)
{
    float *colour = p->build->data->colours + 4 * to;
    int odd = 0;
    for (int i = 0; i < 4; i++)
        colour[i] = 1;
    if (p->primitive->colour.count > 0)
        lf_gltf_floats(&p->primitive->colour, v, 4, colour);
    for (int i = 0; i < 4; i++)
        colour[i] = within(colour[i], 0, 1, &odd);
    return odd;
}

/* w stays 0 without a tangent, or if the tangent belongs to other normals. */
static void put_tangent(const part *p, const vertex *from, const lf_mesh_place *place, size_t to)
{
    float *tangent = p->build->data->tangents + 4 * to, length = 0;
    if (p->build->desc->normals != LF_NORMALS_FILE || p->primitive->normal.count == 0 ||
        p->primitive->tangent.count == 0)
        return;
    for (int i = 0; i < 3; i++) {
        const double *row = place->to_world.m[i];
        tangent[i] = (float)(row[0] * (double)from->tangent[0] + row[1] * (double)from->tangent[1] +
                             row[2] * (double)from->tangent[2]);
        length += tangent[i] * tangent[i];
    }
    if (!(length > 0) || !isfinite(length)) {
        memset(tangent, 0, 4 * sizeof *tangent);
        return;
    }
    tangent[3] = (from->tangent[3] < 0) == place->mirrored ? 1.0f : -1.0f;
}

static void put_vertex(const part *p, size_t v)
{
    lf_mesh_data *data = p->build->data;
    size_t to = (size_t)data->n_vertices;
    vertex from = vertex_of(p, v);
    lf_mesh_place own = p->skin ? lf_gltf_skin_node(p->skin, p->primitive, v) : p->place;
    lf_mesh_put_vertex(data, &own, from.position,
                       p->primitive->normal.count > 0 ? from.normal : NULL);
    int odd = put_coordinates(p, v, to);
    if (data->colours)
        odd += put_colour(p, v, to);
    for (int i = 0; i < 3; i++)
        odd += !isfinite(from.normal[i]);
    p->build->n_odd += odd > 0;
    if (data->tangents)
        put_tangent(p, &from, &own, to);
}

/* ----------------------------------------------------------------------------------- filling -- */

static void put_part(const part *p)
{
    const lf_gltf_primitive *from = p->primitive;
    lf_mesh_data *data = p->build->data;
    bool faceted = is_faceted(p->build, from);
    uint32_t base = (uint32_t)data->n_vertices;
    unsigned material = lf_gltf_build_material(p->build, from);
    for (size_t v = 0; v < from->position.count && !faceted; v++)
        put_vertex(p, v);
    for (size_t t = 0; t < from->n_triangles; t++) {
        uint32_t corners[3];
        bool is_there = lf_gltf_corners(from, t, corners);
        for (uint32_t c = 0; c < 3; c++) {
            if (faceted)
                put_vertex(p, corners[c]);
            corners[c] = base + (faceted ? 3 * (uint32_t)t + c : corners[c]);
        }
        p->build->n_wrong_normals += !is_there;
        if (is_there)
            lf_mesh_put_triangle(data, &p->place, corners, material);
    }
}

static lf_status find_same(lf_gltf_build *build, size_t first, lf_error *err)
{
    size_t n = (size_t)build->data->n_vertices - first;
    return build->same ? lf_mesh_find_same(build->data, first, n, build->same, err) : LF_OK;
}

static lf_status fill(lf_gltf_build *build, const lf_gltf_use *place, void *context, lf_error *err)
{
    const lf_gltf_node *node = place->node;
    const lf_gltf_mesh *mesh = place->mesh;
    part p = {.build = build,
              .primitive = place->primitive,
              .weights = node->weights ? node->weights : mesh->weights,
              .n_weights = node->weights ? node->n_weights : mesh->n_weights,
              .place = lf_mesh_place_of(place->to_world)};
    size_t first = (size_t)build->data->n_vertices;
    lf_gltf_skin skin = {0};
    lf_status status = LF_OK;
    (void)context;
    if (p.primitive->n_triangles == 0)
        return LF_OK;
    if (node->skin != LF_GLTF_NONE && p.primitive->joints[0].count > 0) {
        status = lf_gltf_skin_open(build->gltf, build->nodes, node->skin, &skin, err);
        p.skin = &skin;
    }
    if (status == LF_OK && p.skin) /* as a whole, it is turned inside out or not */
        p.place = lf_mesh_place_of(&skin.joints[0]);
    if (status == LF_OK)
        put_part(&p);
    if (status == LF_OK)
        status = find_same(build, first, err);
    lf_gltf_skin_close(&skin);
    return status;
}

/* Allocates the vertex data that materials need. */
static lf_status allocate_more(lf_gltf_build *build, lf_error *err)
{
    lf_mesh_data *data = build->data;
    size_t n = (size_t)build->n_vertices;
    bool tangents = lf_mesh_wants_tangents(data);
    for (int i = 0; i < LF_SLOTS * data->n_materials && data->textures; i++) {
        const lf_texture *texture = &data->textures[i / LF_SLOTS].slot[i % LF_SLOTS];
        if (texture->picture != 0 && texture->set >= data->n_uv_sets)
            data->n_uv_sets = texture->set + 1;
    }
    if ((tangents || wants_uvs(build)) && data->n_uv_sets == 0)
        data->n_uv_sets = 1;
    if (data->n_uv_sets > 0)
        data->uvs = lf_calloc((size_t)data->n_uv_sets * n, 2 * sizeof *data->uvs);
    if (build->has_colours && build->desc->material < 0)
        data->colours = lf_calloc(n, 4 * sizeof *data->colours);
    if (tangents)
        data->tangents = lf_calloc(n, 4 * sizeof *data->tangents);
    if (build->desc->normals == LF_NORMALS_SMOOTH)
        build->same = lf_calloc(n, sizeof *build->same);
    if ((build->desc->normals == LF_NORMALS_SMOOTH && !build->same) ||
        (data->n_uv_sets > 0 && !data->uvs) || (tangents && !data->tangents) ||
        (build->has_colours && build->desc->material < 0 && !data->colours))
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    return LF_OK;
}

/* Copies, or each mesh once. */
static lf_status fill_all(lf_gltf_build *build, bool shared, lf_error *err)
{
    if (!shared)
        return lf_gltf_visit(build, fill, NULL, err);
    lf_mesh_part *parts = lf_calloc(lf_gltf_count(build->gltf->json, "meshes"), sizeof *parts);
    lf_status status = parts ? lf_gltf_visit_once(build, fill, parts, err)
                             : lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    if (status == LF_OK)
        status = lf_gltf_put_instances(build, parts, err);
    lf_free(parts);
    return status;
}

lf_status lf_gltf_fill(lf_gltf_build *build, lf_error *err)
{
    bool normals = build->desc->normals == LF_NORMALS_SMOOTH ||
                   (build->desc->normals == LF_NORMALS_FILE && build->has_normals);
    lf_status status = lf_gltf_visit(build, count, NULL, err);
    bool shared = status == LF_OK && lf_gltf_is_shared(build);
    if (shared) {
        build->n_triangles = build->n_vertices = build->n_beside = build->n_unmapped = 0;
        status = lf_gltf_visit_once(build, count, NULL, err);
    }
    if (status == LF_OK && (build->n_triangles > LF_MAX_TRIANGLES ||
                            build->n_vertices > 3 * (int64_t)LF_MAX_TRIANGLES))
        status = lf_error_set(err, LF_E_NOMEM, LF_HERE, "its nodes have more than %d triangles",
                              LF_MAX_TRIANGLES);
    if (status == LF_OK)
        status = lf_mesh_allocate(build->data, build->n_vertices, build->n_triangles, normals, err);
    if (status == LF_OK)
        status = allocate_more(build, err);
    return status == LF_OK ? fill_all(build, shared, err) : status;
}
