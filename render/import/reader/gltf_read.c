/* glTF 2.0, text and GLB. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/sandbox/reader.h"
#include "render/import/reader/gltf_animation.h"
#include "render/import/reader/gltf_build.h"
#include "render/import/reader/gltf_camera.h"
#include "render/import/reader/gltf_extensions.h"
#include "render/import/reader/gltf_material.h"
#include "render/import/reader/gltf_punctual.h"
#include "render/import/reader/mesh_read.h"
#include "render/import/scene/tangents.h"

typedef struct reading {
    lf_gltf gltf;
    lf_gltf_nodes nodes;
    size_t n_meshes;
    lf_gltf_mesh *meshes;
    size_t n_sources;
    lf_source_material *source;
    bool *used, *coloured; /* [n_sources] */
    uint32_t variant;
    size_t n_lost[LF_GLTF_LOST_KINDS];
    size_t n_lacking; /* parts that name a material that is not there */
    lf_gltf_build build;
} reading;

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, LF_HERE, "out of memory");
}

static lf_status open_meshes(reading *r, lf_error *err)
{
    lf_status status = LF_OK;
    r->n_meshes = lf_gltf_count(r->gltf.json, "meshes");
    r->meshes = calloc(r->n_meshes + 1, sizeof *r->meshes);
    if (!r->meshes)
        return no_memory(err);
    for (size_t i = 0; i < r->nodes.n && status == LF_OK; i++) {
        lf_gltf_node *node = &r->nodes.node[i];
        if (!node->is_shown || node->mesh == LF_GLTF_NONE)
            continue;
        if (node->mesh >= r->n_meshes)
            return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                                "nodes[%zu]: meshes[%u] does not exist; the file has %zu", i,
                                node->mesh, r->n_meshes);
        if (!r->meshes[node->mesh].primitives)
            status =
                lf_gltf_mesh_open(&r->gltf, node->mesh, r->variant, &r->meshes[node->mesh], err);
        if (status == LF_OK && !node->weights)
            status = lf_gltf_weights(lf_gltf_element(r->gltf.json, "nodes", i), &node->weights,
                                     &node->n_weights, err);
    }
    return status;
}

/* --------------------------------------------------------------------------------- materials -- */

static lf_status look(lf_gltf_build *build, const lf_gltf_use *place, void *context, lf_error *err)
{
    const lf_gltf_primitive *primitive = place->primitive;
    reading *r = context;
    (void)err;
    if (primitive->n_triangles == 0)
        return LF_OK;
    build->has_normals = build->has_normals || primitive->normal.count > 0;
    build->has_colours = build->has_colours || primitive->colour.count > 0;
    build->has_uvs = build->has_uvs || primitive->uv[0].count > 0;
    r->n_lacking += primitive->lacks_material;
    for (unsigned i = 0; i < LF_GLTF_LOST_KINDS; i++)
        r->n_lost[i] += primitive->lost >> i & 1;
    uint32_t material = lf_gltf_build_material(build, primitive);
    r->used[material] = true;
    r->coloured[material] = r->coloured[material] || primitive->colour.count > 0;
    return LF_OK;
}

/* Default material: grey, as for all formats; white if vertices have colours. */
static lf_source_material made_up(bool white)
{
    lf_source_material source = lf_source_material_begin("");
    source.is_none = !white;
    if (white)
        source.albedo = lf_v3(1, 1, 1);
    return source;
}

/* Drops unused default materials, so that a file with the maximum number of materials can be read.
 */
static size_t count_said(const reading *r)
{
    const lf_gltf_build *b = &r->build;
    return r->used[b->plain_white]                    ? b->plain_white + 1
           : r->used[b->plain] || b->n_materials == 0 ? b->plain + 1
                                                      : b->n_materials;
}

static lf_status make_materials(reading *r, lf_error *err)
{
    lf_mesh_data *out = r->build.data;
    float scale = (float)cbrt(fabs(lf_affine_determinant(&r->build.desc->transform)));
    size_t n = count_said(r);
    r->source = lf_calloc(n, sizeof *r->source);
    if (!r->source)
        return no_memory(err);
    r->n_sources = n;
    for (size_t i = 0; i < n; i++) {
        r->source[i] = i < r->build.n_materials
                           ? lf_gltf_source_material(&r->gltf, (uint32_t)i, scale)
                           : made_up(i == r->build.plain_white);
        if (!r->source[i].name)
            return no_memory(err);
    }
    lf_status status = lf_gltf_pictures(&r->gltf, r->source, n, r->used, out, err);
    for (size_t i = 0; i < n && i < r->build.n_materials; i++)
        lf_gltf_unlight(&r->gltf, (uint32_t)i, r->coloured[i], &r->source[i]);
    return status == LF_OK ? lf_source_materials_convert(r->source, n, r->used, out, err) : status;
}

static lf_status open_materials(reading *r, lf_error *err)
{
    size_t n = lf_gltf_count(r->gltf.json, "materials");
    r->build.n_materials = n;
    r->build.plain = (uint32_t)n;
    r->build.plain_white = (uint32_t)n + 1;
    r->used = lf_calloc(n + 2, sizeof *r->used);
    r->coloured = lf_calloc(n + 2, sizeof *r->coloured);
    if (!r->used || !r->coloured)
        return no_memory(err);
    return lf_gltf_visit(&r->build, look, r, err);
}

/* --------------------------------------------------------------------------------------- all -- */

/* Warns of choices that the scene could make and that the image does not show. */
static void warn_of_choices(const reading *r)
{
    const json_t *json = r->gltf.json;
    lf_warnings *w = &r->build.data->warnings;
    const size_t n_variants =
        lf_gltf_count(lf_gltf_extension(json, "KHR_materials_variants"), "variants");
    if (lf_gltf_count(json, "scenes") > 1)
        lf_warnings_add(w, LF_HERE, "of %zu scenes, the %s is shown", lf_gltf_count(json, "scenes"),
                        json_object_get(json, "scene") ? "default one" : "first");
    if (!r->build.desc->variant && r->build.desc->material < 0)
        lf_warnings_count(w, LF_HERE, (long long)n_variants,
                          "variant is not shown; to choose it, set variant of the mesh",
                          "variants are not shown; to choose one, set variant of the mesh");
}

static void warn_of_attributes(const reading *r, lf_warnings *w)
{
    static const struct {
        const char *one, *many;
    } lost[LF_GLTF_LOST_KINDS] = {
        [LF_GLTF_LOST_COLOURS] = {"part has more colours than COLOR_0, which are ignored",
                                  "parts have more colours than COLOR_0, which are ignored"},
        [LF_GLTF_LOST_JOINTS] =
            {"part has more than eight joints per vertex; the others are left out",
             "parts have more than eight joints per vertex; the others are left out"},
        [LF_GLTF_LOST_MORPHS] = {
            "part has morph targets of texture coordinates or colours, which are ignored",
            "parts have morph targets of texture coordinates or colours, which are ignored"}};
    for (int i = 0; i < LF_GLTF_LOST_KINDS; i++)
        lf_warnings_count(w, LF_HERE, (long long)r->n_lost[i], lost[i].one, lost[i].many);
}

/* Warns of elements besides triangles and their materials. */
static void warn(const reading *r)
{
    lf_warnings *w = &r->build.data->warnings;
    warn_of_choices(r);
    lf_warnings_count(w, LF_HERE, r->build.n_beside, "point or line is left out",
                      "points and lines are left out");
    lf_warnings_count(w, LF_HERE, r->build.n_unmapped,
                      "part lacks the texture coordinates of its textures; 0 is used",
                      "parts lack the texture coordinates of their textures; 0 is used");
    lf_warnings_count(w, LF_HERE, r->build.n_wrong_normals,
                      "triangle is left out: an index has no vertex",
                      "triangles are left out: an index has no vertex");
    lf_warnings_count(
        w, LF_HERE, r->build.n_odd,
        "vertex has a normal, texture coordinates or a colour out of range; they are clamped",
        "vertices have normals, texture coordinates or colours out of range; they are clamped");
    if (r->build.desc->material < 0)
        lf_warnings_count(w, LF_HERE, (long long)r->n_lacking,
                          "part has a missing material; it is grey",
                          "parts have missing materials; they are grey");
    warn_of_attributes(r, w);
    lf_gltf_warn_of_extensions(&r->gltf, w);
}

static lf_status complete(reading *r, lf_error *err)
{
    lf_mesh_data *data = r->build.data;
    if (r->build.n_triangles == 0 && r->build.n_beside > 0)
        return lf_error_set(err, LF_E_FORMAT, LF_HERE,
                            "no triangles in this file, only points and lines: %lld",
                            (long long)r->build.n_beside);
    lf_status status =
        lf_mesh_complete_twins(data, r->build.desc, r->build.n_triangles, r->build.same, err);
    return status == LF_OK ? lf_mesh_tangents(data, err) : status;
}

static lf_status read_opened(reading *r, lf_error *err)
{
    const lf_mesh_desc *desc = r->build.desc;
    lf_gltf_playing playing = {0};
    lf_status status = lf_gltf_find_clip(&r->gltf, &desc->clip, &playing, err);
    r->build.data->span = playing.span;
    lf_gltf_warn_of_clips(&r->gltf, &desc->clip, &r->build.data->warnings);
    if (status == LF_OK)
        status = lf_gltf_follow_pointers(&r->gltf, &playing, &r->build.data->warnings, err);
    if (status == LF_OK)
        status = lf_gltf_nodes_open(&r->gltf, &playing, &desc->transform, &r->nodes, err);
    if (status == LF_OK)
        status = lf_gltf_find_variant(&r->gltf, desc->variant, &r->variant, err);
    if (status == LF_OK)
        status = open_meshes(r, err);
    r->build.gltf = &r->gltf;
    r->build.nodes = &r->nodes;
    r->build.meshes = r->meshes;
    if (status == LF_OK)
        status = open_materials(r, err);
    if (status == LF_OK && desc->material < 0)
        status = make_materials(r, err);
    if (status == LF_OK)
        status = lf_gltf_fill(&r->build, err);
    if (status == LF_OK)
        status = complete(r, err);
    if (status == LF_OK)
        status = lf_gltf_lights(&r->gltf, &r->nodes, r->build.data, err);
    if (status == LF_OK)
        status = lf_gltf_cameras(&r->gltf, &r->nodes, r->build.data, err);
    if (status == LF_OK)
        warn(r);
    return status;
}

static void close_reading(reading *r)
{
    for (size_t i = 0; r->meshes && i < r->n_meshes; i++)
        lf_gltf_mesh_close(&r->meshes[i]);
    free(r->meshes);
    for (size_t i = 0; i < r->n_sources; i++)
        lf_free(r->source[i].name);
    lf_free(r->source);
    lf_free(r->build.same);
    lf_free(r->used);
    lf_free(r->coloured);
    lf_gltf_nodes_close(&r->nodes);
    lf_gltf_close(&r->gltf);
}

lf_status lf_gltf_read(const lf_mesh_desc *desc, int fd, lf_mesh_data *out, lf_error *err)
{
    reading r = {.build = {.desc = desc, .data = out}};
    lf_status status = lf_gltf_open(&r.gltf, fd, desc->file, err);
    if (status == LF_OK)
        status = read_opened(&r, err);
    close_reading(&r);
    return status;
}
