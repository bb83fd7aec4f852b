#include "render/import/reader/gltf_primitive.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/sandbox/reader.h"

#define PLACE_LENGTH 64
#define VARIANTS "KHR_materials_variants"

enum { POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, STRIP, FAN, MODES };

void lf_gltf_attributes(lf_gltf_primitive *p, lf_gltf_attribute out[LF_GLTF_ATTRIBUTES])
{
    const lf_gltf_attribute all[LF_GLTF_ATTRIBUTES] = {
        {"POSITION", &p->position, 3, 3},    {"NORMAL", &p->normal, 3, 3},
        {"TANGENT", &p->tangent, 4, 4},      {"TEXCOORD_0", &p->uv[0], 2, 2},
        {"TEXCOORD_1", &p->uv[1], 2, 2},     {"COLOR_0", &p->colour, 3, 4},
        {"JOINTS_0", &p->joints[0], 4, 4},   {"JOINTS_1", &p->joints[1], 4, 4},
        {"WEIGHTS_0", &p->weights[0], 4, 4}, {"WEIGHTS_1", &p->weights[1], 4, 4},
    };
    memcpy(out, all, sizeof all);
}

/* An absent attribute stays absent; a decompressed one stays as it is. */
static lf_status open_attribute(lf_gltf *gltf, const json_t *attributes,
                                const lf_gltf_attribute *wanted, size_t n_vertices,
                                const char *place, lf_error *err)
{
    lf_gltf_accessor *a = wanted->accessor;
    lf_status status = LF_OK;
    if (a->count == 0 && json_object_get(attributes, wanted->name))
        status = lf_gltf_accessor_open(gltf, lf_gltf_whole(attributes, wanted->name, LF_GLTF_NONE),
                                       a, err);
    if (status != LF_OK || a->count == 0)
        return status;
    if (a->components < wanted->least || a->components > wanted->most)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%s: %s has %u components; expected %u",
                            place, wanted->name, a->components, wanted->most);
    if (n_vertices > 0 && a->count != n_vertices)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%s: %s has %zu elements for %zu vertices",
                            place, wanted->name, a->count, n_vertices);
    return LF_OK;
}

/* Attributes are known by their names; those that begin with _ are the file's own matter. */
static unsigned lost_of(const json_t *json)
{
    json_t *value, *attributes = json_object_get(json, "attributes");
    const json_t *targets = json_object_get(json, "targets");
    const char *name;
    unsigned lost = 0;
    uint64_t set;
    json_object_foreach(attributes, name, value)
    {
        bool beyond = strncmp(name, "JOINTS_", 7) == 0 || strncmp(name, "WEIGHTS_", 8) == 0;
        if (strncmp(name, "COLOR_", 6) == 0 && strcmp(name, "COLOR_0") != 0)
            lost |= 1u << LF_GLTF_LOST_COLOURS;
        if (beyond && lf_whole_is(strchr(name, '_') + 1, &set) && set >= LF_GLTF_JOINT_SETS)
            lost |= 1u << LF_GLTF_LOST_JOINTS;
    }
    for (size_t i = 0; i < json_array_size(targets); i++)
        json_object_foreach(json_array_get(targets, i), name,
                            value) if (strncmp(name, "TEXCOORD_", 9) == 0 ||
                                       strncmp(name, "COLOR_", 6) == 0) lost |=
            1u << LF_GLTF_LOST_MORPHS;
    return lost;
}

static lf_status open_attributes(lf_gltf *gltf, const json_t *json, lf_gltf_primitive *p,
                                 const char *place, lf_error *err)
{
    const json_t *attributes = json_object_get(json, "attributes");
    lf_gltf_attribute all[LF_GLTF_ATTRIBUTES];
    lf_status status = LF_OK;
    lf_gltf_attributes(p, all);
    for (size_t i = 0; i < LF_GLTF_ATTRIBUTES && status == LF_OK; i++)
        status = open_attribute(gltf, attributes, &all[i], p->position.count, place, err);
    for (int i = 0; i < LF_GLTF_JOINT_SETS; i++)
        if (p->joints[i].count == 0 || p->weights[i].count == 0)
            p->joints[i].count = p->weights[i].count = 0;
    return status;
}

static lf_status check_indices(lf_gltf_primitive *p, const char *place, lf_error *err)
{
    const lf_gltf_accessor *a = &p->indices;
    if (a->type == LF_GLTF_FLOAT || a->type == LF_GLTF_INT8 || a->type == LF_GLTF_INT16 ||
        a->components != 1)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "%s: indices have componentType %d; expected 5121, 5123 or 5125", place,
                            (int)a->type);
    for (size_t i = 0; i < a->count; i++)
        p->n_wrong_normals += lf_gltf_integer(a, i) >= p->position.count;
    return LF_OK;
}

static lf_status check_there(const lf_gltf_primitive *p, const char *place, lf_error *err)
{
    if (lf_gltf_is_there(&p->position) && lf_gltf_is_there(&p->indices))
        return LF_OK;
    return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                        "%s: some of %zu positions and %zu indices have no bufferView", place,
                        p->position.count, p->indices.count);
}

static lf_status open_targets(lf_gltf *gltf, const json_t *json, lf_gltf_primitive *p,
                              const char *place, lf_error *err)
{
    const json_t *targets = json_object_get(json, "targets");
    size_t n = json_array_size(targets);
    lf_status status = LF_OK;
    if (n == 0)
        return LF_OK;
    if (n > LF_GLTF_MOST_TARGETS)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%s: %zu morph targets; expected at most %d",
                            place, n, LF_GLTF_MOST_TARGETS);
    p->targets = calloc(n, sizeof *p->targets);
    if (!p->targets)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    p->n_targets = n;
    for (size_t i = 0; i < n && status == LF_OK; i++) {
        lf_gltf_target *to = &p->targets[i];
        const lf_gltf_attribute parts[] = {{"POSITION", &to->position, 3, 3},
                                           {"NORMAL", &to->normal, 3, 3},
                                           {"TANGENT", &to->tangent, 3, 3}};
        for (size_t k = 0; k < sizeof parts / sizeof *parts && status == LF_OK; k++)
            status = open_attribute(gltf, json_array_get(targets, i), &parts[k], p->position.count,
                                    place, err);
    }
    return status;
}

/* The material of the variant, if it has one. */
static uint32_t material_of(const json_t *json, uint32_t variant)
{
    const json_t *mappings = json_object_get(lf_gltf_extension(json, VARIANTS), "mappings");
    for (size_t i = 0; i < json_array_size(mappings) && variant != LF_GLTF_NONE; i++) {
        const json_t *mapping = json_array_get(mappings, i),
                     *variants = json_object_get(mapping, "variants");
        for (size_t k = 0; k < json_array_size(variants); k++)
            if (json_is_number(json_array_get(variants, k)) &&
                json_number_value(json_array_get(variants, k)) == (double)variant)
                return lf_gltf_index(mapping, "material");
    }
    return lf_gltf_index(json, "material");
}

static void list_variants(const json_t *variants, char *out, size_t size)
{
    size_t n = 0;
    out[0] = '\0';
    for (size_t i = 0; i < json_array_size(variants) && n < size; i++)
        n += (size_t)snprintf(out + n, size - n, "%s\"%.80s\"", i > 0 ? ", " : "",
                              lf_gltf_text(json_array_get(variants, i), "name"));
}

lf_status lf_gltf_find_variant(const lf_gltf *gltf, const char *name, uint32_t *out, lf_error *err)
{
    const json_t *variants = json_object_get(lf_gltf_extension(gltf->json, VARIANTS), "variants");
    char names[1024];
    *out = LF_GLTF_NONE;
    if (!name)
        return LF_OK;
    for (size_t i = 0; i < json_array_size(variants); i++)
        if (strcmp(lf_gltf_text(json_array_get(variants, i), "name"), name) == 0) {
            *out = (uint32_t)i;
            return LF_OK;
        }
    list_variants(variants, names, sizeof names);
    if (json_array_size(variants) == 0)
        return lf_error_set(err, LF_E_ARG, LF_HERE, "no variant \"%s\"; the file has no variants",
                            name);
    return lf_error_set(err, LF_E_ARG, LF_HERE, "no variant \"%s\"; expected one of %s", name,
                        names);
}

/* Counts triangles, and elements that are not triangles. */
static void count_elements(lf_gltf_primitive *p)
{
    size_t n = p->indices.count > 0 ? p->indices.count : p->position.count;
    switch (p->mode) {
    case TRIANGLES:
        p->n_triangles = n / 3;
        break;
    case STRIP:
    case FAN:
        p->n_triangles = n > 2 ? n - 2 : 0;
        break;
    case LINES:
        p->n_beside = n / 2;
        break;
    default:
        p->n_beside = n;
    }
}

static lf_status open_primitive(lf_gltf *gltf, const json_t *json, uint32_t variant,
                                lf_gltf_primitive *p, const char *place, lf_error *err)
{
    lf_status status = LF_OK;
    p->mode = (unsigned)lf_gltf_whole(json, "mode", TRIANGLES);
    p->material = material_of(json, variant);
    if (p->mode >= MODES)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE, "%s: unknown mode; expected 0 to 6", place);
    p->lost = lost_of(json);
    p->lacks_material =
        p->material != LF_GLTF_NONE && p->material >= lf_gltf_count(gltf->json, "materials");
    if (p->lacks_material)
        p->material = LF_GLTF_NONE;
    if (lf_gltf_extension(json, "KHR_draco_mesh_compression"))
        status = lf_gltf_draco(gltf, json, p, err);
    if (status == LF_OK)
        status = open_attributes(gltf, json, p, place, err);
    if (status != LF_OK || p->position.count == 0)
        return status;
    if (p->indices.count == 0 && json_object_get(json, "indices"))
        status = lf_gltf_accessor_open(gltf, lf_gltf_whole(json, "indices", LF_GLTF_NONE),
                                       &p->indices, err);
    if (status == LF_OK)
        status = check_there(p, place, err);
    if (status == LF_OK && p->indices.count > 0)
        status = check_indices(p, place, err);
    count_elements(p);
    return status == LF_OK ? open_targets(gltf, json, p, place, err) : status;
}

lf_status lf_gltf_weights(const json_t *object, float **out, size_t *out_n, lf_error *err)
{
    const json_t *array = json_object_get(object, "weights");
    size_t n = json_array_size(array);
    if (n == 0 || n > LF_GLTF_MOST_TARGETS)
        return LF_OK;
    *out = calloc(n, sizeof **out);
    if (!*out)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    *out_n = n;
    for (size_t i = 0; i < n; i++)
        (*out)[i] = (float)json_number_value(json_array_get(array, i));
    return LF_OK;
}

lf_status lf_gltf_mesh_open(lf_gltf *gltf, uint32_t number, uint32_t variant, lf_gltf_mesh *out,
                            lf_error *err)
{
    const json_t *json = lf_gltf_element(gltf->json, "meshes", number),
                 *primitives = json_object_get(json, "primitives");
    size_t n = json_array_size(primitives);
    char place[PLACE_LENGTH];
    if (!json)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "meshes[%u] does not exist; the file has %zu", number,
                            lf_gltf_count(gltf->json, "meshes"));
    out->primitives = calloc(n + 1, sizeof *out->primitives);
    if (!out->primitives)
        return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
    out->n = n;
    lf_status status = lf_gltf_weights(json, &out->weights, &out->n_weights, err);
    for (size_t i = 0; i < n && status == LF_OK; i++) {
        snprintf(place, sizeof place, "meshes[%u].primitives[%zu]", number, i);
        status = open_primitive(gltf, json_array_get(primitives, i), variant, &out->primitives[i],
                                place, err);
    }
    return status;
}

void lf_gltf_mesh_close(lf_gltf_mesh *mesh)
{
    for (size_t i = 0; mesh->primitives && i < mesh->n; i++) {
        free(mesh->primitives[i].targets);
        lf_gltf_decoded_free(mesh->primitives[i].decoded);
    }
    free(mesh->primitives);
    free(mesh->weights);
    *mesh = (lf_gltf_mesh){0};
}

bool lf_gltf_corners(const lf_gltf_primitive *p, size_t triangle, uint32_t out[3])
{
    const size_t i = triangle, odd = i % 2,
                 corners[3][3] = {{3 * i, 3 * i + 1, 3 * i + 2},
                                  {i, i + 1 + odd, i + 2 - odd},
                                  {i + 1, i + 2, 0}};
    const size_t *c = corners[p->mode - TRIANGLES];
    for (int k = 0; k < 3; k++)
        out[k] = p->indices.count > 0 ? lf_gltf_integer(&p->indices, c[k]) : (uint32_t)c[k];
    if (p->n_wrong_normals == 0 ||
        (out[0] < p->position.count && out[1] < p->position.count && out[2] < p->position.count))
        return true;
    out[0] = out[1] = out[2] = 0;
    return false;
}
